//! Documents as they are rendered: anchors, hostile texts, numbers point under point, charts of anything.

use tumble::document::{
    Bar, Cell, Chart, Detail, Document, GapPanel, GapPoint, Interval, Part, Residual, Row, Rows, Section, Table, html,
    markdown, plot, terminal,
};
use tumble::language::Language;

#[test]
fn anchors_are_plain_and_distinct() {
    let page = Document::new("p")
        .section(Section::new("A & b").prose("x"))
        .section(Section::new("A & b").prose("y"))
        .section(Section::new("empty"));
    let anchors: Vec<&str> = page.sections.iter().map(|s| s.anchor.as_str()).collect();
    assert_eq!(anchors, ["a---b", "a---b-2"]);
}

#[test]
fn markup_of_the_user_stays_text() {
    let texts = ["<i> `a<b` & c", "one ` alone", "a\u{0}b\u{ffff}"];
    let section = texts.into_iter().fold(Section::new("s"), |section, text| section.prose(text));
    let page = html::render(&Document::new("p").section(section)).unwrap();
    for expected in ["&lt;i&gt; <code class=\"short\">a&lt;b</code> &amp; c", "one ` alone", "a\u{fffd}b\u{fffd}"] {
        assert!(page.contains(expected), "{expected}");
    }
}

/// A name may have the sign that sets names in code type: a bench `b`1|x` in a text with another name, in every output.
#[test]
fn a_backtick_in_a_name_is_a_letter_of_it() {
    let table = Rows::of(["b`1|x", "`a", "c"]).name("bench", |name| name).left("of", |_| "one of `V0` and `kI`");
    let page = Document::new("p").section(Section::new("s").table(table));
    let expected = [
        (markdown::render(&page), ["``` b`1\\|x ``` | one of `V0` and `kI` |", "``` `a ``` "]),
        (html::render(&page).unwrap(), ["<code class=\"short\">b`1|x</code>", "<code class=\"short\">`a</code>"]),
        (terminal::render(&page, Detail::Full), ["b`1|x  one of V0 and kI", "`a     one of V0 and kI"]),
    ];
    for (text, words) in expected {
        words.into_iter().for_each(|word| assert!(text.contains(word), "{word} is not in {text}"));
    }
}

/// Beyond the colours of the palette each source of a budget still has one of its own.
#[test]
fn every_source_of_a_budget_has_its_colour() {
    let part = |k: usize| Part { source: format!("s{k}"), type_b: k.is_multiple_of(2), size: 1.0 };
    let bar = Bar { label: "x".into(), parts: (0..16).map(part).collect() };
    let svg = plot::draw(&Chart::Bars(vec![bar], "u".into(), String::new(), true), Language::English).unwrap();
    let entries = svg.split("<rect").filter(|rect| rect.contains("width=\"22\" height=\"20\""));
    let colours: std::collections::BTreeSet<String> = entries
        .map(|rect| rect.split(" stroke").next().unwrap().split("opacity=").nth(1).unwrap().to_string())
        .collect();
    assert_eq!(colours.len(), 16, "{svg}");
}

#[test]
fn numbers_stand_point_under_point() {
    let cells = [Cell::from("-1.25"), "30".into(), Cell::absent()];
    let mut table: Table = Rows::of(&cells).decimal("u", |cell| cell.clone()).into();
    table.rows.push(Row::default());
    let page = html::render(&Document::new("p").section(Section::new("s").table(table))).unwrap();
    let (_, body) = page.split_once("<tbody>").unwrap();
    let cells: Vec<&str> = body
        .split("<td")
        .skip(1)
        .filter_map(|cell| cell.split_once('>')?.1.split_once("</td>").map(|(own, _)| own))
        .collect();
    assert_eq!(cells[..3], ["\u{2212}1.25", "30\u{2008}\u{2007}\u{2007}", "\u{2013}"]);
}

#[test]
fn charts_survive_hostile_numbers_and_names() {
    let drawn = |chart: Chart| plot::draw(&chart, Language::English);
    let wild = [0.0, -0.0, f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX, f64::MIN_POSITIVE, 1.0, 1.0 + 1e-15];
    // what XML 1.0 has besides the characters above the controls
    let is_allowed = |c: char| matches!(c, '\t' | '\n' | '\r') || (c >= ' ' && !('\u{fffe}'..='\u{ffff}').contains(&c));
    for a in wild {
        for b in wild {
            let row = |value, bar| Interval {
                label: "<&\"\u{0}\u{ffff}\u{1b}x".into(),
                value,
                expanded: bar,
                at_bound: None,
            };
            let text = drawn(Chart::Values(vec![row(a, b), row(b, a)], "angle, arcsec".into())).unwrap();
            assert!(!text.contains("<&") && text.chars().all(is_allowed));
            assert!(drawn(Chart::Values(vec![row(a, a)], "angle".into())).is_ok());
            let part = |size| Part { source: "readings".into(), type_b: false, size };
            let bar = |size| Bar { label: "x".into(), parts: vec![part(size), part(a)] };
            assert!(drawn(Chart::Bars(vec![bar(a), bar(b)], "u".into(), "arcsec".into(), true)).is_ok());
            let point = |value, band| Residual { number: 1, group: "p".into(), value, band, far: false };
            let points = vec![point(a, Some(b)), point(b, None)];
            assert!(drawn(Chart::Residuals(points, "residual".into(), "V".into())).is_ok());
            let pair = |after, band| GapPoint { group: "<".into(), before: a, after, band };
            let points = vec![pair(Some(b), Some(a)), pair(None, None)];
            assert!(drawn(Chart::Gap(vec![GapPanel { points, ..GapPanel::default() }], "x".into())).is_ok());
            assert!(drawn(Chart::Normal(vec![a, b, 1.0])).is_ok());
            let matrix = vec![vec![Some(1.0), Some(a)], vec![Some(b), None]];
            assert!(drawn(Chart::Correlation(vec!["a".into(), "b".into()], matrix)).is_ok());
        }
    }
    let empty = [
        Chart::Values(Vec::new(), String::new()),
        Chart::Bars(Vec::new(), String::new(), String::new(), false),
        Chart::Residuals(Vec::new(), String::new(), String::new()),
        Chart::Normal(Vec::new()),
        Chart::Correlation(Vec::new(), Vec::new()),
        Chart::Gap(Vec::new(), String::new()),
    ];
    for chart in empty {
        assert!(drawn(chart).is_ok());
    }
}

#[test]
fn text_in_a_chart_is_text() {
    let row = Interval { label: "dtheta_y2".into(), value: -162.07, expanded: 1.23, at_bound: None };
    let text = plot::draw(&Chart::Values(vec![row], "angle, arcsec".into()), Language::English).unwrap();
    assert!(text.contains("<text") && text.contains("dtheta_y2") && text.contains("angle, arcsec"));
}

/// Of a long table the program says which option shows all; a value that is printed has no options.
#[test]
fn rows_that_are_left_out_are_counted() {
    let table = Rows::of(1..=7_usize).right("n", |n| n).most(3);
    let page = Document::new("p").section(Section::new("s").table(table));
    let (program, value) = (terminal::render(&page, Detail::Brief), terminal::brief(&page));
    assert!(program.contains("\n... and 4 more rows (all with -v)\n"), "{program}");
    assert!(value.contains("\n... and 4 more rows\n") && !value.contains("-v"), "{value}");
    let all = terminal::render(&page, Detail::Full);
    assert!(all.contains("7\n") && !all.contains("more rows"), "{all}");
}
