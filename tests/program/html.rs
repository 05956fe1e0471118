//! Reports as pages: one file that needs nothing else, every section where it belongs, numbers of the report, hostile names harmless.

use crate::markup::{Element, element};
use assert_cmd::Command;
use std::fs;

const TABLE_1: &str = "data/campaigns/li2012-table1.campaign.json";
const TABLE_2: &str = "data/campaigns/li2012-table2.campaign.json";
const RANK_DEFECT: &str = "tests/data/simulated/accelerometer-rank-defect.campaign.json";
const SIX_SENSORS: &str = "tests/data/simulated/imu-three-axis.campaign.json";

fn tumble(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("tumble").unwrap().args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn page(campaign: &str) -> String {
    let (code, text, errors) = tumble(&["fit", campaign, "--html", "-"]);
    assert!(code != 1, "{errors}");
    text
}

/// The page as a tree: void elements closed, the doctype and the style (which is no markup) left out.
fn tree(page: &str) -> Element {
    let body = page.replace("<!DOCTYPE html>", "");
    let (head, rest) = body.split_once("<style>").unwrap();
    let (_, rest) = rest.split_once("</style>").unwrap();
    let closed = format!("{head}{rest}");
    element(
        &closed
            .replace("<meta charset=\"utf-8\">", "")
            .replace("<meta name=\"color-scheme\" content=\"light dark\">", "")
            .replace("<meta name=\"generator\" content=\"tumble\">", "")
            .replace("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">", ""),
    )
}

/// Terms in headings and columns lead to their definitions, each once, which are those of the guide's glossary in the language of the page.
#[test]
fn terms_lead_to_their_definitions() {
    let rows = |page: &str| -> Vec<(String, String)> {
        let page = fs::read_to_string(format!("docs/guide/{page}")).unwrap();
        let row = |line: &str| {
            let (names, meaning) = line.strip_prefix("| ")?.strip_suffix(" |")?.split_once(" | ")?;
            Some((names.to_string(), meaning.to_string()))
        };
        page.lines().filter_map(row).skip(1).collect()
    };
    let [english, chinese] = ["glossary.md", "glossary.zh.md"].map(rows);
    assert!(english.len() == chinese.len() && english.len() > 40, "{} {}", english.len(), chinese.len());
    for (lang, glossary, some) in [("en", &english, "MDB, minimal detectable bias"), ("zh", &chinese, "最小可探测偏差")]
    {
        let (_, text, _) = tumble(&["fit", TABLE_1, "--html", "-", "--lang", lang]);
        let root = tree(&text);
        let used: Vec<String> = root
            .all("a")
            .iter()
            .filter_map(|a| a.attribute("href")?.strip_prefix('#').map(String::from))
            .filter(|anchor| anchor.starts_with("term-"))
            .collect();
        let mut defined: Vec<String> =
            root.all("dt").iter().filter_map(|dt| dt.attribute("id").map(String::from)).collect();
        let mut once = used.clone();
        once.sort();
        defined.sort();
        assert!(used.len() > 8 && once == defined, "{lang}: {used:?} {defined:?}");
        let names: Vec<String> =
            root.all("dt").iter().filter(|dt| dt.attribute("id").is_some()).map(|dt| dt.text.clone()).collect();
        assert!(names.iter().any(|name| name == some), "{lang}: {names:?}");
        for name in names {
            let row = glossary.iter().find(|(names, _)| *names == name).unwrap_or_else(|| panic!("{lang}: {name}"));
            // `text` is that of the element itself, without code in it
            let said = root.all("dd").iter().any(|dd| dd.text == row.1);
            assert!(said || row.1.contains('`'), "{lang}: {}", row.1);
        }
    }
}

fn headings(page: &str) -> Vec<String> {
    tree(page).all("h2").into_iter().map(|h| h.text).collect()
}

#[test]
fn a_page_is_one_well_formed_file_that_loads_nothing() {
    for campaign in [TABLE_1, TABLE_2, RANK_DEFECT, SIX_SENSORS] {
        let text = page(campaign);
        let root = tree(&text);
        assert!(root.all("script").is_empty() && root.all("link").is_empty() && root.all("img").is_empty());
        for hungry in ["src=", "@import", "url("] {
            assert!(!text.contains(hungry), "{campaign}: {hungry}");
        }
        // the only address is the name of the SVG namespace
        let addresses = text.matches("http").count();
        assert_eq!(addresses, text.matches("http://www.w3.org/2000/svg").count(), "{campaign}");
        assert!(text.contains("@media print"));
        assert!(root.all("svg").iter().all(|svg| !svg.all("text").is_empty()), "{campaign}: a figure without text");
        let anchors: Vec<String> = root
            .all("a")
            .iter()
            .filter_map(|a| a.attribute("href").map(|h| h.trim_start_matches('#').into()))
            .filter(|anchor: &String| !anchor.starts_with("term-"))
            .collect();
        let ids: Vec<String> = root.all("section").iter().filter_map(|s| s.attribute("id").map(String::from)).collect();
        assert_eq!(anchors, ids);
        assert!(text.len() < 1_000_000, "{campaign}: {} bytes", text.len());
    }
}

#[test]
fn the_page_of_table_1_says_what_the_report_says() {
    let text = page(TABLE_1);
    for heading in [
        "Result",
        "Estimates",
        "The correction to apply",
        "Sources of uncertainty",
        "Residuals and correlations",
        "Comparison with the published closed forms",
        "What was assumed",
        "Readings",
    ] {
        assert!(headings(&text).iter().any(|h| h == heading), "{heading} is not in {:?}", headings(&text));
    }
    // the paper's table: 162.2, 55.8 and 171.5 arcsec from the mean of three rates; least squares within half an arcsecond
    for number in ["\u{2212}162.07", "56.02", "171.48"] {
        assert!(text.contains(number), "{number}");
    }
    // 1/kI = 1/-2.9222 = -0.342207926, and V0 = 1.582 mV
    assert!(text.contains("w_I = -0.342207926*(V - 0.00158"));
    assert!(text.contains("<code class=\"short\">dtheta_z1</code>"), "what was assumed zero");
    // the digest is that of the file: the same that sha256sum prints
    use sha2::Digest;
    let digest = sha2::Sha256::digest(fs::read(TABLE_1).unwrap());
    let hexadecimal: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    assert!(text.contains(&hexadecimal));
    assert_eq!(text, page(TABLE_1), "the same inputs give the same bytes");
}

#[test]
fn every_reading_is_listed_and_drawn() {
    let root = tree(&page(TABLE_1));
    let tables = root.all("table");
    let rows = tables.last().unwrap().all("tbody")[0].all("tr").len();
    assert_eq!(rows, 30);
    let residuals = root.all("svg").into_iter().find(|svg| svg.all("text").iter().any(|t| t.text.contains("residual")));
    assert_eq!(residuals.unwrap().all("circle").len(), 30);
}

#[test]
fn a_rank_defect_is_named_and_the_correction_says_what_is_missing() {
    let text = page(RANK_DEFECT);
    assert!(headings(&text).iter().any(|h| h.starts_with("Not estimable")));
    assert!(text.contains("V0 + kI*dtheta_y0") && text.contains("V0 - kI*dtheta_y0"));
    assert!(text.contains("Readings cannot be corrected"));
    assert!(!headings(&page(TABLE_1)).iter().any(|h| h.starts_with("Not estimable")));
}

#[test]
fn six_sensors_have_six_residual_figures_and_six_corrections() {
    let text = page(SIX_SENSORS);
    let root = tree(&text);
    let figures = root.all("figcaption").into_iter().filter(|c| c.text.starts_with("Residuals of")).count();
    assert_eq!(figures, 6);
    // the six sensors are solved together, one line for each component of rate and force
    for input in ["w_x", "w_y", "w_z", "a_x", "a_y", "a_z"] {
        let line =
            root.all("code").into_iter().chain(root.all("pre")).find(|e| e.text.contains(&format!("{input} = ")));
        assert!(line.is_some() || text.contains(&format!("{input} = ")), "{input}");
    }
}

#[test]
fn hostile_names_stay_text() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "<script>alert('1')</script>\"&`|*_x\u{7}";
    let mut campaign: serde_json::Value = serde_json::from_str(&fs::read_to_string(TABLE_1).unwrap()).unwrap();
    let mut bench: serde_json::Value =
        serde_json::from_str(&fs::read_to_string("data/benches/gyro-turntable.bench.json").unwrap()).unwrap();
    bench["title"] = hostile.into();
    bench["source"] = hostile.into();
    campaign["bench"] = bench;
    for reading in campaign["readings"].as_array_mut().unwrap() {
        reading["position"] = hostile.into();
    }
    let path = folder.path().join("hostile.campaign.json");
    fs::write(&path, campaign.to_string()).unwrap();
    let text = page(path.to_str().unwrap());
    let root = tree(&text);
    assert!(root.all("script").is_empty() && !text.contains('\u{7}'));
    assert!(root.text_of("h1").starts_with("<script>alert('1')</script>\"&"));
    let (code, markdown, _) = tumble(&["fit", path.to_str().unwrap(), "--md", "-"]);
    assert_eq!(code, 0);
    // in markdown a cell's bar and a tag's bracket are escaped, so that the table keeps its columns
    let row = markdown.lines().find(|line| line.starts_with('|') && line.contains("script")).unwrap();
    assert!(row.contains("\\<script>") && row.contains("\\|"));
}

#[test]
fn markdown_has_the_same_sections_and_numbers() {
    let (_, markdown, _) = tumble(&["fit", TABLE_1, "--md", "-"]);
    let sections: Vec<&str> = markdown.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    assert_eq!(sections, headings(&page(TABLE_1)));
    assert!(
        markdown
            .lines()
            .any(|line| line.starts_with("| `dtheta_y2` ") && line.contains(" -162.1 ") && line.contains(" 1.2 "))
    );
    for block in markdown.split("\n\n").filter(|block| block.starts_with('|')) {
        let bars: Vec<usize> = block.lines().map(|line| line.replace("\\|", "").matches('|').count()).collect();
        assert!(bars.iter().all(|n| *n == bars[0]), "a table loses its columns:\n{block}");
    }
}

#[test]
fn compare_writes_pages_too() {
    let folder = tempfile::tempdir().unwrap();
    let (html, md) = (folder.path().join("c.html"), folder.path().join("c.md"));
    let (code, _, errors) =
        tumble(&["compare", TABLE_1, "--html", html.to_str().unwrap(), "--md", md.to_str().unwrap()]);
    assert!(code != 1, "{errors}");
    let text = fs::read_to_string(html).unwrap();
    assert!(headings(&text).contains(&"Group by group".to_string()));
    assert!(fs::read_to_string(md).unwrap().contains("## Group by group"));
}

#[test]
fn a_page_that_cannot_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none").join("page.html");
    let (code, _, errors) = tumble(&["fit", TABLE_1, "--html", path.to_str().unwrap()]);
    assert!(code == 1 && errors.contains("cannot write"), "{errors}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Every figure says in words what it shows; the page has its colours for a dark screen, and none of them on paper.
#[test]
fn figures_have_words_and_screens_may_be_dark() {
    let (_, plan, _) = tumble(&["plan", TABLE_1, "--noise", "V=9e-4", "--html", "-"]);
    let (_, diagnosis, _) = tumble(&["diagnose", TABLE_1, "--html", "-"]);
    for text in [page(TABLE_1), page(SIX_SENSORS), plan, diagnosis] {
        let root = tree(&text);
        let figures = root.all("figure");
        assert!(!figures.is_empty());
        for figure in figures {
            let label = figure.all("div")[0].attribute("aria-label").map(str::to_string).unwrap_or_default();
            assert!(label.len() > 20, "'{label}'");
        }
        assert!(text.contains("@media screen and (prefers-color-scheme: dark)"));
    }
}

/// The first thing on the page of a plan is what the schedule reaches.
#[test]
fn the_page_of_a_plan_begins_with_the_answer() {
    let (_, text, _) = tumble(&["plan", TABLE_1, "--noise", "V=9e-4", "--html", "-"]);
    let root = tree(&text);
    let first = &root.all("section")[0];
    assert_eq!(first.all("h2")[0].text, "The given schedule");
    assert!(first.all("svg").is_empty() && text.contains("Every parameter can be estimated."));
}

/// Coefficients of a closed form are no angles: their column is not called so, and their digits are seen.
#[test]
fn closed_forms_of_coefficients_have_their_digits() {
    let (code, text, errors) = tumble(&["compare", "examples/11-gyro-skew-triad/direct.campaign.json", "--html", "-"]);
    assert!(code != 1, "{errors}");
    let root = tree(&text);
    let table = &root.all("table")[0];
    assert!(table.all("th")[0].text != "angle");
    assert!(!table.all("td").iter().any(|cell| cell.text == "0.000"));
}

/// A name with characters that XML does not allow breaks neither page nor picture, and steers no terminal.
#[test]
fn names_with_forbidden_characters_are_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("odd.campaign.json");
    let text = fs::read_to_string(TABLE_1).unwrap();
    let odd = text.replacen("\"position\": \"1\"", "\"position\": \"\\u001b[31m\u{9b}\u{7f}\u{ffff}\"", 1);
    assert!(odd != text);
    fs::write(&file, odd).unwrap();
    let file = file.display().to_string();
    let (code, text, errors) = tumble(&["fit", &file, "--html", "-"]);
    assert!(code != 1, "{errors}");
    assert!(!text.contains(['\u{ffff}', '\u{1b}']));
    assert!(!tree(&text).all("svg").is_empty());
    let (_, table, _) = tumble(&["fit", &file, "--readings"]);
    let (_, json, _) = tumble(&["fit", &file, "--json", "-"]);
    for text in [table, json] {
        assert!(
            !text.contains(['\u{1b}', '\u{7f}', '\u{9b}']) && text.contains("?\u{bf}?") | text.contains("\u{bf}?"),
            "{text}"
        );
    }
}

/// A bound that holds an angle is drawn, and its bar is the interval that the bound leaves.
#[test]
fn an_active_bound_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let mut campaign: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string("data/campaigns/li2012-table1.campaign.json").unwrap()).unwrap();
    let path = folder.path().join("bounded.campaign.json");
    let page = |campaign: &serde_json::Value| {
        std::fs::write(&path, campaign.to_string()).unwrap();
        let output = assert_cmd::Command::cargo_bin("tumble")
            .unwrap()
            .args(["fit", path.to_str().unwrap(), "--html", "-"])
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(!page(&campaign).contains("active bounds"));
    // the free estimate is -162 arcsec
    campaign["constraints"] =
        serde_json::json!([{ "of": { "dtheta_y2": 1 }, "between": [-161.5, 161.5], "unit": "arcsec" }]);
    let html = page(&campaign);
    assert!(html.contains("Vertical lines: active bounds"));
    assert!(html.contains("#D55E00\" stroke-width=\"5\""), "the line at the bound");
}

/// Beside a lack of fit beyond doubt, or limits that are not met, nothing is in order; the fit says which command goes on.
#[test]
fn nothing_is_in_order_beside_what_is_not() {
    // of the result: that the closed forms agree stands in a section of its own
    let said = |text: &str| text.split("<h2").nth(1).unwrap().matches("\"OK.\"").count();
    let table_1 = page(TABLE_1);
    assert!(said(&table_1) == 0 && table_1.contains("LACK OF FIT") && table_1.contains("tumble diagnose"));
    let (code, printed, _) = tumble(&["fit", TABLE_1]);
    assert!(
        code == 0 && printed.contains("LACK OF FIT by position") && printed.contains("tumble diagnose"),
        "{printed}"
    );
    // a line that fits, and a limit that its slope is outside of
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.campaign.json");
    let campaign = |limits: &str| {
        let readings: Vec<String> = [0.9, 3.1, 4.9, 7.1, 8.9, 11.1]
            .iter()
            .enumerate()
            .map(|(x, y)| format!(r#"{{"x": {x}, "y": {y}, "y_u": 0.1}}"#))
            .collect();
        let text = format!(
            r#"{{"bench": {{"id": "line", "sensors": {{"y": {{"model": "a + b*x"}}}}}}, "estimate": {{"a": {{}}, "b": {{}}}},
                "limits": {{"b": {limits}}}, "readings": [{}]}}"#,
            readings.join(",")
        );
        fs::write(&path, text).unwrap();
        page(path.to_str().unwrap())
    };
    assert!(said(&campaign("[1.5, 2.5]")) > 0);
    let failed = campaign("[0, 1]");
    assert!(said(&failed) == 0 && failed.contains("Problem"));
}

/// Of many suspicious readings five are printed; the report has them all.
#[test]
fn five_suspicious_readings_are_printed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.campaign.json");
    let readings: Vec<String> = (0..60)
        .map(|k| {
            let y = if k % 8 == 0 { 1000.0 + 100.0 * f64::from(k) } else { f64::from(k % 3) };
            format!(r#"{{"y": {y}, "y_u": 1}}"#)
        })
        .collect();
    let text = format!(
        r#"{{"bench": {{"id": "mean", "sensors": {{"y": {{"model": "a"}}}}}}, "estimate": {{"a": {{}}}}, "readings": [{}]}}"#,
        readings.join(",")
    );
    fs::write(&path, text).unwrap();
    let (_, printed, _) = tumble(&["fit", path.to_str().unwrap()]);
    let (_, json, _) = tumble(&["fit", path.to_str().unwrap(), "--json", "-"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let suspects = report["checks"]["snooping"]["suspects"].as_array().unwrap().len();
    assert!(suspects > 5);
    assert_eq!(printed.matches("SUSPICIOUS").count(), 5, "{printed}");
    assert!(printed.contains(&format!("{} more suspicious", suspects - 5)) && printed.contains("tumble diagnose"));
}
