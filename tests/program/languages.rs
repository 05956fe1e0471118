//! Reports in Chinese: no key without its sentence, no English left, lines within the terminal, JSON as it is.

use crate::wrap::columns;
use assert_cmd::Command;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use tumble::language::{Language, keys};

/// Columns of the smallest terminal in use.
const COLUMNS: usize = 80;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn all_catalogues_have_the_same_keys_with_the_same_arguments() {
    let (english, _) = keys(Language::English);
    assert!(english.len() > 300, "{}", english.len());
    let names = |of: &BTreeMap<String, BTreeSet<String>>| of.keys().cloned().collect::<BTreeSet<String>>();
    for language in Language::ALL {
        let ((other, faults), code) = (keys(language), language.code());
        assert!(faults.is_empty(), "{code}: {faults:?}");
        let (left, right) = (names(&english), names(&other));
        assert_eq!(left.difference(&right).collect::<Vec<_>>(), Vec::<&String>::new(), "not in {code}");
        assert_eq!(right.difference(&left).collect::<Vec<_>>(), Vec::<&String>::new(), "in {code} alone");
        for (key, arguments) in &english {
            // a count that only chooses an English plural may be missing
            let without =
                |of: &BTreeSet<String>| of.iter().filter(|name| *name != "n").cloned().collect::<BTreeSet<String>>();
            assert_eq!(without(arguments), without(&other[key]), "{code}: {key}");
        }
    }
}

/// The types of the Python package name every language, and the glossary of each has the terms of the English one.
#[test]
fn every_language_is_complete() {
    let read =
        |path: &str| std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
    let codes: Vec<String> = Language::ALL.iter().map(|own| format!("\"{}\"", own.code())).collect();
    let line = format!("Lang = Literal[{}]", codes.join(", "));
    assert!(read("python/package/tumble/_report.py").lines().any(|own| own == line), "python: {line}");
    let rows = |page: &str| read(page).lines().filter(|line| line.starts_with("| ")).count();
    let english = rows("docs/guide/glossary.md");
    assert!(english > 40, "{english}");
    for code in Language::ALL.map(Language::code).into_iter().filter(|code| *code != "en") {
        assert_eq!(rows(&format!("docs/guide/glossary.{code}.md")), english, "{code}");
    }
}

/// The files of a folder and below it with an ending.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Messages that the sources say: key, and names of the arguments. `say!(lang, "key", a, b = c)`, `sentence!("key", a)`.
fn said(source: &str) -> Vec<(String, BTreeSet<String>)> {
    let code: String =
        source.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let mut found = Vec::new();
    for macro_name in ["say!(", "sentence!("] {
        for (at, _) in code.match_indices(macro_name) {
            let parts = arguments(&code[at + macro_name.len()..]);
            let parts = if macro_name == "say!(" { parts.get(1..).unwrap_or_default() } else { &parts };
            let Some(key) = parts.first().and_then(|first| first.strip_prefix('"')?.strip_suffix('"')) else {
                continue;
            };
            let name = |part: &String| part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            found.push((key.to_string(), parts[1..].iter().map(name).collect()));
        }
    }
    found
}

/// The arguments of a call up to its closing parenthesis.
fn arguments(text: &str) -> Vec<String> {
    let (mut depth, mut quoted, mut escaped) = (0, false, false);
    let mut parts = vec![String::new()];
    for c in text.chars() {
        let last = parts.last_mut().expect("one");
        match c {
            _ if escaped => escaped = false,
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            _ if quoted => {}
            ')' if depth == 0 => break,
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        last.push(c);
    }
    parts.iter().map(|part| part.trim().to_string()).filter(|part| !part.is_empty()).collect()
}

#[test]
fn every_message_that_the_sources_say_is_in_the_catalogues() {
    let (english, _) = keys(Language::English);
    let mut count = 0;
    for path in files(&root().join("src"), ".rs") {
        for (key, names) in said(&std::fs::read_to_string(&path).expect("a source")) {
            let expected = english.get(&key).unwrap_or_else(|| panic!("{}: no message '{key}'", path.display()));
            assert_eq!(&names, expected, "{}: {key}", path.display());
            count += 1;
        }
    }
    assert!(count > 300, "{count}");
}

/// Standard output of `tumble ARGUMENTS --lang zh`, run in a folder.
fn chinese(folder: &Path, arguments: &[&str]) -> String {
    let mut command = Command::cargo_bin("tumble").expect("the program");
    let output = command.current_dir(folder).args(arguments).args(["--lang", "zh"]).output().expect("a run");
    assert_ne!(output.status.code(), Some(1), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Words of three letters or more that are left in a text beside what a user or the field wrote: names in the files of the example, units,
/// symbols, names of programs, standards and persons.
fn foreign(text: &str, own: &BTreeSet<String>) -> Vec<String> {
    const FIELD: &[&str] = &[
        "tumble",
        "apply",
        "fit",
        "export",
        "diagnose",
        "linear",
        "JSON",
        "SHA",
        "IEEE",
        "Std",
        "JCGM",
        "JJF",
        "Shapiro",
        "Francia",
        "Sidak",
        "Holm",
        "Birge",
        "huber",
        "tukey",
        "arcsec",
        "deg",
        "rad",
        "mrad",
        "urad",
        "ppm",
        "pulse",
        "inf",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "sqrt",
        "abs",
        "sign",
        "step",
        "site",
        "gravity",
        "latitude",
        "altitude",
        "WGS",
        "Somigliana",
        "IMU",
        "ISO",
        "GJB",
        "ICRA",
        "Tedaldi",
        "Pretto",
        "Menegatti",
        "norm",
        "Cochran",
        "Kenward",
        "Roger",
        "Wei",
        "Ren",
        "Shunqing",
        "Zhao",
        "Hongbo",
        "delta",
        "cXX",
        "compX",
        "MAD",
        // regressors, columns and options as a person writes them
        "kOO",
        "kPP",
        "reading",
        "approach",
        "order",
        "day",
        "min",
        "html",
        "any",
        "cost",
        // the scenario of all errors together
        "all",
    ];
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|word| {
        let letters = word.chars().filter(char::is_ascii_alphabetic).count();
        // what has an underscore is a symbol of a model line
        letters >= 3 && !word.contains('_') && !FIELD.contains(word) && !own.contains(*word) && !is_hexadecimal(word)
    });
    words.map(String::from).collect::<BTreeSet<String>>().into_iter().collect()
}

fn is_hexadecimal(word: &str) -> bool {
    word.len() > 20 && word.chars().all(|c| c.is_ascii_hexdigit())
}

/// Words of the files beside a campaign, of the built-in benches and of the published comparisons' symbols: the user's own.
fn own_words(folder: &Path) -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    let mut take = |text: &str| {
        words.extend(text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).map(String::from));
    };
    for file in std::fs::read_dir(folder).expect("a folder").flatten().map(|file| file.path()) {
        take(&file.file_name().unwrap_or_default().to_string_lossy());
        let name = file.to_string_lossy().into_owned();
        if name.ends_with(".json") || name.ends_with(".csv") {
            take(&std::fs::read_to_string(&file).unwrap_or_default());
        }
    }
    for bench in files(&root().join("data/benches"), ".json") {
        let bench: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(bench).expect("a bench")).expect("JSON");
        symbols(&bench, &mut take);
    }
    // what a published comparison cites is in its authors' words
    for forms in files(&root().join("data/closed_forms"), ".json") {
        take(&std::fs::read_to_string(forms).expect("published forms"));
    }
    words
}

/// Every text of a bench but those that a person reads.
fn symbols(value: &serde_json::Value, take: &mut dyn FnMut(&str)) {
    match value {
        serde_json::Value::Object(members) => {
            for (key, member) in members {
                take(key);
                if !["title", "source", "is"].contains(&key.as_str()) {
                    symbols(member, take);
                }
            }
        }
        serde_json::Value::Array(items) => items.iter().for_each(|item| symbols(item, take)),
        serde_json::Value::String(text) => take(text),
        _ => {}
    }
}

/// The campaigns of the examples that are of one device and can be fitted.
fn campaigns() -> Vec<PathBuf> {
    let mut found = files(&root().join("examples"), ".campaign.json");
    found.retain(|path| {
        let mut command = Command::cargo_bin("tumble").expect("the program");
        let one = !path.to_string_lossy().contains("production-line");
        one && command.arg("fit").arg(path).output().expect("a run").status.code() != Some(1)
    });
    assert!(found.len() > 25, "{}", found.len());
    found
}

fn check(text: &str, own: &BTreeSet<String>, what: &str) {
    let left = foreign(text, own);
    assert!(left.is_empty(), "{what}: {left:?} in\n{text}");
    assert!(text.chars().any(|c| ('\u{4e00}'..='\u{9fff}').contains(&c)), "{what}: no Chinese in\n{text}");
}

fn in_columns(text: &str, what: &str) {
    for line in text.lines() {
        assert!(
            columns(line) <= COLUMNS || !line.trim_start().contains(' '),
            "{what}: {} columns\n{line}",
            columns(line)
        );
    }
}

/// The text of a page: what stands between its tags, without styles and code.
fn page_text(html: &str) -> String {
    let body = html.split_once("</style>").map_or(html, |(_, body)| body);
    let mut text = String::new();
    for part in body.split('<').skip(1) {
        if let Some((tag, after)) = part.split_once('>') {
            for name in ["aria-label=\"", "data-word=\""] {
                text.push_str(tag.split_once(name).map_or("", |(_, rest)| rest.split('"').next().unwrap_or_default()));
                text.push(' ');
            }
            text.push_str(after);
        }
        text.push(' ');
    }
    for (entity, c) in [("&amp;", "&"), ("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'")] {
        text = text.replace(entity, c);
    }
    text
}

#[test]
fn fits_are_told_in_chinese() {
    for path in campaigns() {
        let folder = path.parent().expect("a folder");
        let own = own_words(folder);
        let file = path.file_name().expect("a name").to_string_lossy().into_owned();
        let text = chinese(folder, &["fit", &file, "--readings", "--budget", "--correction"]);
        check(&text, &own, &file);
        in_columns(&text, &file);
        let html = chinese(folder, &["fit", &file, "--html", "-"]);
        assert!(html.contains("<html lang=\"zh-CN\">"));
        check(&page_text(&html), &own, &format!("{file} --html"));
        check(&chinese(folder, &["fit", &file, "--md", "-"]), &own, &format!("{file} --md"));
    }
}

#[test]
fn json_is_the_same_in_every_language() {
    let folder = root().join("examples/22-six-positions");
    let file = files(&folder, ".campaign.json").remove(0);
    let file = file.to_string_lossy();
    let english =
        Command::cargo_bin("tumble").expect("the program").args(["fit", &file, "--json", "-"]).output().expect("a run");
    let json = chinese(&folder, &["fit", &file, "--json", "-"]);
    assert_eq!(String::from_utf8_lossy(&english.stdout), json);
    assert!(json.is_ascii() || !json.chars().any(|c| ('\u{4e00}'..='\u{9fff}').contains(&c)));
}

/// Commands with the folder of the example that they are run in.
fn commands() -> Vec<(&'static str, Vec<&'static str>)> {
    let plan = |further: &[&'static str]| {
        let mut arguments = vec!["plan", "published.campaign.json", "--noise", "V=9e-4"];
        arguments.extend(further);
        ("18-plan-five-positions", arguments)
    };
    vec![
        ("05-table-1-diagnosed", vec!["diagnose", "table1.campaign.json"]),
        ("06-table-2-diagnosed", vec!["diagnose", "table2.campaign.json"]),
        ("07-hidden-effect", vec!["diagnose", "measured.campaign.json"]),
        ("08-nothing-hidden", vec!["diagnose", "measured.campaign.json"]),
        ("24-temperature", vec!["diagnose", "chamber.campaign.json"]),
        ("19-navigation-errors", vec!["diagnose", "navigator.mission.json", "--measured", "both.csv"]),
        ("19-navigation-errors", vec!["diagnose", "navigator.mission.json", "--measured", "static.csv"]),
        ("19-navigation-errors", vec!["navigate", "navigator.mission.json"]),
        plan(&["--readings"]),
        plan(&["--goal", "1", "--readings"]),
        plan(&["--goal", "1", "--cheapest"]),
        plan(&["--separate", "a_S", "a_S^2"]),
        plan(&["--choose", "30", "--unit", "mounting", "--step", "36"]),
        plan(&["--remount", "dtheta_y2=0.5", "--find", "a_S=1e-3"]),
        plan(&["--add", "4"]),
        ("15-xsens-from-the-log", vec!["reduce", "xsens.csv.gz", "--for", "accelerometer.schedule.json"]),
        ("15-xsens-from-the-log", vec!["reduce", "xsens.csv.gz", "--sources"]),
        ("15-xsens-from-the-log", vec!["noise", "xsens.csv.gz", "--unit", "g", "--to", "20", "--deviations"]),
        ("26-production-line", vec!["fit", "line.campaign.json"]),
        ("26-production-line", vec!["diagnose", "line.campaign.json"]),
        ("21-calibration-in-use", vec!["compare", "before.fit.json", "after.fit.json"]),
    ]
}

/// The numbers of a text, sorted.
fn numbers(text: &str) -> Vec<String> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let parts = text.split(|c| !is_part(c)).map(|part| part.trim_matches('.')).filter(|part| !part.is_empty());
    let mut found: Vec<String> = parts.map(str::to_string).collect();
    found.sort();
    found
}

/// Both streams of a run, for a person.
fn told(folder: &Path, arguments: &[&str], code: &str) -> String {
    let mut command = Command::cargo_bin("tumble").expect("the program");
    let output = command.current_dir(folder).args(arguments).args(["--lang", code]).output().expect("a run");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_ne!(output.status.code(), Some(1), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).expect("UTF-8") + &stderr
}

#[test]
fn every_command_is_told_in_chinese() {
    let line = |folder: &str| folder == "26-production-line";
    for (folder, arguments) in commands() {
        let of = root().join("examples").join(folder);
        let mut own = own_words(&of);
        let what = format!("{folder}: {}", arguments.join(" "));
        // rows of devices are data where they do not go to a terminal: what is told is the summary
        let mut arguments = arguments;
        let rows = std::env::temp_dir().join(format!("tumble-{}-{}.csv", std::process::id(), arguments[0]));
        let rows = rows.to_string_lossy().into_owned();
        if line(folder) {
            arguments.extend(["--force", "--to", &rows]);
        }
        let text = told(&of, &arguments, "zh");
        check(&text, &own, &what);
        in_columns(&text, &what);
        // a table that is too wide in one language repeats its first column; the pages below count
        let each = |text: &str| {
            let mut own = numbers(text);
            own.dedup();
            own
        };
        assert_eq!(each(&text), each(&told(&of, &arguments, "en")), "{what}\n{text}");
        if line(folder) && arguments[0] == "diagnose" {
            continue;
        }
        if line(folder) {
            // why a device is malformed is an error, and errors are in English
            for row in csv::Reader::from_path(&rows).expect("rows").records().map(|row| row.expect("a row")) {
                if row.iter().any(|cell| cell == "malformed") {
                    own.extend(
                        row.iter().flat_map(|cell| cell.split(|c: char| !c.is_ascii_alphanumeric())).map(String::from),
                    );
                }
            }
        }
        let page = |code: &str| told(&of, &[&arguments[..], &["--html", "-"]].concat(), code);
        let (chinese, english) = (page("zh"), page("en"));
        check(&page_text(&chinese), &own, &format!("{what} --html"));
        // definitions of terms cite the standards of their language
        let [chinese, english] = [chinese, english].map(|page| match page.split_once("<aside") {
            Some((before, rest)) => page_text(&format!("{before}{}", rest.split_once("</aside>").unwrap().1)),
            None => page_text(&page),
        });
        assert_eq!(numbers(&chinese), numbers(&english), "{what} --html\n{chinese}");
        if ["compare", "diagnose", "noise", "reduce"].contains(&arguments[0]) && !line(folder) {
            check(&told(&of, &[&arguments[..], &["--md", "-"]].concat(), "zh"), &own, &format!("{what} --md"));
        }
    }
}

#[test]
fn texts_that_are_data_are_in_the_sources() {
    let mut all = String::new();
    for path in files(&root().join("src"), ".rs").into_iter().chain(files(&root().join("data"), ".json")) {
        // not the names themselves, of whatever language
        if !path.starts_with(root().join("data/language")) {
            // a text goes on in the next line after a backslash
            let text = std::fs::read_to_string(path).expect("a source").replace("\\\"", "\"");
            all.extend(text.split("\\\n").map(str::trim_start));
        }
    }
    for name in tumble::language::names(Language::Chinese) {
        // a source makes some of them of parts (plurals, a sensor's name): every word is there, and most of the pairs of words
        for piece in name.split(['{', '}']).step_by(2) {
            let words: Vec<&str> = piece.split_whitespace().collect();
            for word in &words {
                let word = word.trim_matches(|c: char| !c.is_alphanumeric());
                assert!(all.contains(word), "'{word}' of '{name}' is nowhere");
            }
            let pairs: Vec<String> = words.windows(2).map(|pair| pair.join(" ")).collect();
            let missing: Vec<&String> = pairs.iter().filter(|pair| !all.contains(pair.as_str())).collect();
            assert!(missing.len() <= 1.max(pairs.len() / 3), "{missing:?} of '{name}' are nowhere");
        }
    }
}

#[test]
fn every_text_of_the_effects_has_chinese() {
    let effects = std::fs::read_to_string(root().join("data/effects.json")).expect("effects");
    let effects: serde_json::Value = serde_json::from_str(&effects).expect("JSON");
    for effect in effects["effects"].as_array().expect("effects") {
        for key in ["name", "why", "confirm"] {
            let mut text = effect[key].as_str().expect("a text").to_string();
            for place in
                ["{i}", "{j}", "{k}", "{joint}", "{turning}", "{tilt}", "{known}", "{reading}", "{other}", "{position}"]
            {
                text = text.replace(place, "7");
            }
            let said = Language::Chinese.name(&text);
            assert!(said.chars().any(|c| ('\u{4e00}'..='\u{9fff}').contains(&c)), "no Chinese for '{text}'");
        }
    }
}

#[test]
fn a_command_without_a_language_does_not_offer_one() {
    for (command, offers) in [
        ("bench", false),
        ("check", false),
        ("schema", false),
        ("completions", false),
        ("man", false),
        ("fit", true),
        ("plan", true),
    ] {
        let output =
            Command::cargo_bin("tumble").expect("the program").args([command, "--help"]).output().expect("a run");
        let help = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(help.contains("--lang"), offers, "{command}\n{help}");
    }
}

#[test]
fn a_command_without_chinese_says_which_have_it() {
    let output = Command::cargo_bin("tumble")
        .expect("the program")
        .args(["bench", "list", "--lang", "zh"])
        .output()
        .expect("a run");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(text.contains("--lang zh") && text.contains("fit"), "{text}");
}

/// Names with parts are said by the pattern that has the most text of its own, and parts that are names are said in their turn.
#[test]
fn parts_are_found_and_looked_up_in_their_turn() {
    let path = root().join("data/language/names.zh.json");
    let names: BTreeMap<String, String> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let say = |text: &str| Language::Chinese.name(text).into_owned();
    let filled = |pattern: &str, parts: &[(&str, &str)]| {
        parts.iter().fold(names[pattern].clone(), |said, (name, part)| said.replace(&format!("{{{name}}}"), part))
    };
    let dying = filled("dying away in {t} h", &[("t", "2")]);
    assert_eq!(say("dying away in 2 h"), dying);
    let (plain, more) = ("heading {a} deg in {t} s", "heading {a} deg in {t} s, {rest}");
    assert_eq!(say("heading 5 deg in 10 s"), filled(plain, &[("a", "5"), ("t", "10")]));
    assert_eq!(
        say("heading 5 deg in 10 s, dying away in 2 h"),
        filled(more, &[("a", "5"), ("t", "10"), ("rest", &dying)])
    );
    // a part that is not there is no part
    for text in ["heading 5 deg in  s", "heading  deg in 10 s", "dying away in h"] {
        assert_eq!(say(text), text);
    }
}
