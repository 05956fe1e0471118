//! The JSON Schemas in `schemas/` are those of the Rust types, and every file that ships is valid under its schema.
//!
//! `UPDATE=1 cargo test --release --test program schemas` writes them anew after a type has changed.

use crate::support::*;
use serde_json::Value;
use std::path::{Path, PathBuf};
use tumble::{compare, fit, report};

fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn validator(kind: &str) -> jsonschema::Validator {
    let schema = report::schema(kind).unwrap_or_else(|| panic!("no schema {kind}"));
    jsonschema::validator_for(&schema).unwrap_or_else(|error| panic!("{kind}: {error}"))
}

/// A report as the program wrote it is valid under the schema of its kind, which is returned. Not-a-number would be null, which few keys allow.
pub fn assert_valid(text: &str, what: &str) -> String {
    let report: Value = serde_json::from_str(text).unwrap_or_else(|error| panic!("{what}: {error}"));
    let named = report["report"].as_str().unwrap_or_else(|| panic!("{what}: no kind of report"));
    let kind = format!("{named}-report");
    if let Some(error) = validator(&kind).iter_errors(&report).next() {
        panic!("{what}: {error} at {} of the {kind}", error.instance_path());
    }
    kind
}

/// Files below a folder whose name ends so.
fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("bad") {
            files(&path, ending, found);
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
}

#[test]
fn committed_schemas_are_the_generated_ones() {
    let mut expected: Vec<String> = Vec::new();
    for kind in report::schemas() {
        let text = serde_json::to_string_pretty(&report::schema(kind).expect("a schema")).expect("JSON") + "\n";
        let path = root("schemas").join(format!("{kind}.schema.json"));
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, &text).expect("written");
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(
            committed == text,
            "schemas/{kind}.schema.json is out of date: UPDATE=1 cargo test --release --test program schemas"
        );
        expected.push(format!("{kind}.schema.json"));
    }
    let mut found = Vec::new();
    files(&root("schemas"), ".json", &mut found);
    assert_eq!(found.len(), expected.len(), "no schema without a type: {found:?}");
}

#[test]
fn every_shipped_file_is_valid() {
    for (kind, ending) in [("bench", ".bench.json"), ("campaign", ".campaign.json")] {
        let validator = validator(kind);
        let mut found = Vec::new();
        for folder in ["data", "examples", "tests/data"] {
            files(&root(folder), ending, &mut found);
        }
        println!("{} files under the {kind} schema", found.len());
        assert!(!found.is_empty());
        for path in found {
            let text = std::fs::read_to_string(&path).expect("text");
            let value: Value =
                serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            if let Some(error) = validator.iter_errors(&value).next() {
                panic!("{}: {error} at {}", path.display(), error.instance_path());
            }
        }
    }
}

#[test]
fn unknown_keys_are_invalid() {
    let validator = validator("campaign");
    let index = json("bad/INDEX.json");
    let mut refused = 0;
    for (name, _) in
        entries(&index).filter(|(name, _)| name.starts_with("unknown-key") || name.starts_with("missing-b"))
    {
        assert!(!validator.is_valid(&json(&format!("bad/{name}"))), "{name}");
        refused += 1;
    }
    assert!(refused >= 8);
}

#[test]
fn reports_are_valid() {
    for name in ["li2012/li2012-table1.campaign.json", "li2012/li2012-table2.campaign.json"] {
        let campaign = campaign(name);
        let report = serde_json::to_value(report::fit_report(&fitted(&campaign))).expect("JSON");
        assert!(validator("fit-report").is_valid(&report), "{name}");
        let forms = compare::closed_forms(&campaign.bench.id).expect("closed forms");
        let comparison = compare::compare(&campaign, &forms, &fit::Settings::default()).expect("a comparison");
        let report = serde_json::to_value(report::compare_report(&comparison)).expect("JSON");
        assert!(validator("compare-report").is_valid(&report), "{name}");
    }
    // what cannot be known is null, also there
    for name in
        ["bad/rank-defect.campaign.json", "bad/no-redundancy.campaign.json", "xsens/static-positions.campaign.json"]
    {
        let report = serde_json::to_value(report::fit_report(&exact(&campaign(name)))).expect("JSON");
        let errors: Vec<String> = validator("fit-report").iter_errors(&report).map(|error| error.to_string()).collect();
        assert!(errors.is_empty(), "{name}: {errors:?}");
    }
}

/// Reports of every campaign that ships or once showed a fault: valid, and no table prints what is not a number.
#[test]
fn reports_of_every_campaign_are_valid() {
    let mut found = Vec::new();
    for folder in ["data", "examples", "tests/data"] {
        files(&root(folder), ".campaign.json", &mut found);
    }
    let mut fits = 0;
    for path in found {
        let Ok(campaign) = tumble::Campaign::from_path(&path) else { continue };
        let Ok(fit) = fit::fit(&campaign, &fit::Settings::default()) else { continue };
        let (report, name) = (report::fit_report(&fit), path.display().to_string());
        assert_valid(&serde_json::to_string(&report).expect("JSON"), &name);
        let document = report::fit_document(
            &report,
            &report::Asked { fit: Some(&fit), ..report::Asked::default() },
            tumble::language::Language::English,
        );
        let table = tumble::document::terminal::render(&document, tumble::document::Detail::Full);
        assert!(!table.contains("NaN"), "{name}: {table}");
        fits += 1;
    }
    println!("{fits} fits");
    assert!(fits > 100, "{fits}");
}

/// Questions at the edge of what numbers can hold: an error, or a report that is valid and prints no NaN.
/// A report as of readings that were taken another time: its first one differs by so much.
pub fn other_readings(from: &str, to: &str, by: f64) {
    let mut report: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(from).unwrap()).unwrap();
    let value = &mut report["readings"][0]["value"];
    *value = (value.as_f64().unwrap() + by).into();
    std::fs::write(to, report.to_string()).unwrap();
}

#[test]
fn edges_are_answered_without_not_a_number() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let table_1 = root("examples/01-gyro-table/table1.campaign.json").display().to_string();
    let with = |name: &str, key: &str, value: Value| {
        let mut campaign: Value =
            serde_json::from_str(&std::fs::read_to_string(&table_1).expect("text")).expect("JSON");
        campaign[key] = value;
        std::fs::write(at(name), campaign.to_string()).expect("written");
        at(name)
    };
    let wide = serde_json::json!([-1e308, 1e308]);
    let limits = serde_json::json!({ "V0": wide, "dtheta_y0": { "between": wide, "unit": "rad" }, "dtheta_x0": { "between": wide, "unit": "arcsec" } });
    let limited = with("limits.campaign.json", "limits", limits);
    let mut commands: Vec<Vec<String>> = Vec::new();
    let mut ask = |words: &[&str]| commands.push(words.iter().map(|word| (*word).to_string()).collect());
    for level in ["1e-308", "1e-16", "0.9999999999999999"] {
        ask(&["compare", &table_1, "--level", level]);
        ask(&["fit", &table_1, "--level", level]);
    }
    for rule in ["simple", "guard-u", "risk"] {
        let mut campaign: Value =
            serde_json::from_str(&std::fs::read_to_string(&limited).expect("text")).expect("JSON");
        campaign["decision"] = rule.into();
        std::fs::write(at(&format!("{rule}.campaign.json")), campaign.to_string()).expect("written");
        ask(&["fit", &at(&format!("{rule}.campaign.json"))]);
    }
    // constant, alternating, one or two samples a segment, gaps, next to nothing, beyond what can be squared
    let noise = |k: i32| f64::from((k * 7919) % 13 - 6);
    type Samples = (fn(i32) -> i32, Box<dyn Fn(i32) -> String>);
    let records: [Samples; 8] = [
        (|k| k / 200, Box::new(|_| "1".into())),
        (|k| k / 3, Box::new(|k| (1 - 2 * (k % 2)).to_string())),
        (|k| k, Box::new(move |k| noise(k).to_string())),
        (|k| k / 2, Box::new(move |k| noise(k).to_string())),
        (|k| k / 200, Box::new(move |k| if k % 3 == 0 { noise(k).to_string() } else { String::new() })),
        (|k| k / 200, Box::new(move |k| (noise(k) * 1e-310).to_string())),
        (|k| k / 200, Box::new(move |k| (noise(k) * 1e150).to_string())),
        (|k| k / 200, Box::new(move |k| (noise(k) * 1e307).to_string())),
    ];
    for (number, (segment, value)) in records.iter().enumerate() {
        let rows: String = (0..600).map(|k| format!("{},{},{}\n", f64::from(k) * 0.01, value(k), segment(k))).collect();
        std::fs::write(at(&format!("{number}.csv")), format!("time_s,V,place\n{rows}")).expect("written");
        ask(&["reduce", &at(&format!("{number}.csv")), "--by", "place", "--columns", "V", "--sources"]);
        ask(&["noise", &at(&format!("{number}.csv"))]);
    }
    // measured errors: all zero, one row, two rows that are alike
    let mission = root("examples/19-navigation-errors/navigator.mission.json").display().to_string();
    for (name, rows) in [("zero", 40), ("one", 1), ("two", 2)] {
        let rows: String = (0..rows).map(|k| format!("static,{},0,1e0\n", 30 * k)).collect();
        std::fs::write(at(&format!("{name}.csv")), format!("motion,time_s,position_east_m,position_east_m_u\n{rows}"))
            .expect("written");
        ask(&["diagnose", &mission, "--measured", &at(&format!("{name}.csv"))]);
    }
    // a history: one calibration a year
    let years = ["2023", "2024", "2025"].map(|year| {
        let report = at(&format!("{year}.fit.json"));
        let campaign = with(&format!("{year}.campaign.json"), "date", format!("{year}-05-04").into());
        let fit = assert_cmd::Command::cargo_bin("tumble")
            .expect("the program")
            .args(["fit", &campaign, "--json", &report])
            .output();
        assert_ne!(fit.expect("a run").status.code(), Some(1));
        other_readings(&report, &report, year.parse::<f64>().unwrap() * 1e-9);
        report
    });
    ask(&["compare", &years[0], &years[1], &years[2]]);
    let (mut valid, mut kinds) = (0, std::collections::BTreeSet::new());
    for words in &commands {
        let report = at("report.json");
        let _ = std::fs::remove_file(&report);
        let command = assert_cmd::Command::cargo_bin("tumble")
            .expect("the program")
            .args(words)
            .args(["--json", &report])
            .output();
        let output = command.expect("a run");
        let printed = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(!printed.contains("NaN"), "{words:?}: {printed}");
        match std::fs::read_to_string(&report) {
            Ok(text) => {
                kinds.insert(assert_valid(&text, &words.join(" ")));
                valid += 1;
            }
            Err(_) => assert!(output.status.code() == Some(1) && printed.contains("error"), "{words:?}: {printed}"),
        }
    }
    println!("{valid} of {} questions have a report", commands.len());
    assert!(
        valid >= 20 && kinds.contains("noise-report") && kinds.contains("compare-history-report"),
        "{valid} {kinds:?}"
    );
}

/// Every property of a schema that is an object: where it is, its name, what it says, and the description of the object around it.
fn properties<'a>(schema: &'a Value, path: &str, found: &mut Vec<(String, &'a Value, Option<&'a Value>)>) {
    match schema {
        Value::Object(keys) => {
            let own = keys.get("properties").and_then(Value::as_object);
            for (name, said) in own.into_iter().flatten() {
                found.push((format!("{path}/{name}"), said, keys.get("description")));
            }
            for (name, inside) in keys {
                properties(inside, &format!("{path}/{name}"), found);
            }
        }
        Value::Array(list) => list.iter().for_each(|inside| properties(inside, path, found)),
        _ => {}
    }
}

#[test]
fn every_schema_has_its_version_and_every_key_a_description() {
    for kind in report::schemas() {
        let schema = report::schema(kind).expect("a schema");
        assert_eq!(schema["$id"], format!("urn:tumble:{kind}:{}", report::VERSION));
        assert!(schema["$schema"].as_str().is_some_and(|dialect| dialect.contains("2020-12")), "{kind}");
        let mut found = Vec::new();
        properties(&schema, kind, &mut found);
        assert!(found.len() > 5, "{kind}");
        for (place, said, around) in found {
            // the one key of a variant is described with the variant
            let described = said.get("description").or(around).and_then(Value::as_str);
            assert!(described.is_some_and(|text| text.len() > 3), "{place} has no description");
        }
    }
}

/// Every number of a report says its unit, in its name or in its description, or that it is a pure number.
#[test]
fn every_number_of_a_report_says_its_unit() {
    let endings = ["_deg", "_s", "_m", "_h", "_min", "_arcsec", "_ppm", "_m_s"];
    let names = ["p", "t", "z", "w", "k", "level", "condition", "dof", "birge", "chi_square"];
    let said = [
        "unit",
        "rad",
        "deg",
        "arcsec",
        "ppm",
        "Hz",
        "robabilit",
        "ratio",
        "factor",
        "Factor",
        "share",
        "Share",
        "correl",
        "Correl",
        "pure number",
        "0 to 1",
        "-1 to 1",
        "variances",
        "tandard uncertainties",
        "tandard deviations",
        "egrees of freedom",
        "umber of",
        "Number",
        ", s",
        ", h",
        "weight",
        "tolerance",
        "differ",
        "1970",
    ];
    let is_number =
        |key: &Value| key["type"] == "number" || key["type"].as_array().is_some_and(|t| t.contains(&"number".into()));
    let mut silent = Vec::new();
    for kind in report::schemas().into_iter().filter(|kind| kind.ends_with("report")) {
        let schema = report::schema(kind).expect("a schema");
        let mut found = Vec::new();
        properties(&schema, kind, &mut found);
        for (place, key, _) in found {
            let name = place.rsplit('/').next().unwrap_or_default();
            let text = key["description"].as_str().unwrap_or_default();
            let plain = names.contains(&name) || endings.iter().any(|ending| name.ends_with(ending));
            if (is_number(key) || is_number(&key["items"])) && !plain && !said.iter().any(|word| text.contains(word)) {
                silent.push(format!("{place}: {text}"));
            }
        }
    }
    assert!(silent.is_empty(), "numbers without a unit:\n{}", silent.join("\n"));
}

/// Closed vocabularies are listed with what each word means.
#[test]
fn closed_vocabularies_are_listed() {
    let words = |kind: &str, of: &str| -> Vec<String> {
        let schema = report::schema(kind).expect("a schema");
        let listed = schema["$defs"][of]["oneOf"].as_array().unwrap_or_else(|| panic!("{kind} has no {of}")).clone();
        assert!(listed.iter().all(|word| word["description"].is_string()), "{of}");
        listed.iter().map(|word| word["const"].as_str().expect("a word").to_string()).collect()
    };
    assert_eq!(words("fit-report", "State"), ["free", "at-bound", "fixed", "not-estimable"]);
    assert_eq!(words("fit-report", "Kind"), ["tilt", "coefficient"]);
    assert_eq!(words("fit-report", "Evaluation"), ["A", "B"]);
    assert_eq!(words("fit-report", "Conformity"), ["pass", "undecided", "fail"]);
    assert_eq!(words("fit-report", "VarianceFrom"), ["stated", "estimated"]);
    assert_eq!(words("fit-report", "ConstraintState").len(), 5);
    assert_eq!(words("diagnose-report", "NoiseFrom"), ["stated", "replicates", "residuals"]);
    assert_eq!(words("diagnose-report", "Verdict").len(), 5);
    assert_eq!(words("plan-report", "Fate"), ["detectable", "absorbed", "not-exercised"]);
}

/// Every file may name its schema, by which editors complete and check it.
#[test]
fn every_file_may_name_its_schema() {
    let text = |name: &str| std::fs::read_to_string(root(name)).expect("text");
    let source = |kind: &str, text: &str, key: &str| {
        let named = text.replacen('{', &format!("{{ \"{key}\": \"urn:tumble:{kind}\", "), 1);
        let value: Value = serde_json::from_str(&named).expect("JSON");
        (tumble::wire::Source { name: kind.into(), text: named }, validator(kind).is_valid(&value))
    };
    let campaign = text("examples/01-gyro-table/table1.campaign.json");
    let bench = tumble::bench::built_in("gyro-turntable").expect("a bench").text.to_string();
    let effects = r#"{ "effects": [ { "term": "a_S^2", "name": "e" } ] }"#.to_string();
    let truth = text("examples/07-hidden-effect/hidden.truth.json");
    let mission = text("examples/19-navigation-errors/truth.mission.json");
    let mut fetch = |_: &str| -> tumble::Result<tumble::wire::Source> { panic!("nothing to fetch") };
    for (key, accepted) in [("$schema", true), ("$comment", true), ("$scheme", false)] {
        let of = |kind: &str, text: &str| source(kind, text, key);
        let (own, valid) = of("campaign", &campaign);
        let read = tumble::wire::read_campaign(&own, &mut fetch);
        assert_eq!((read.is_ok(), valid), (accepted, accepted), "{read:?}");
        let (own, valid) = of("bench", &bench);
        assert_eq!((tumble::wire::read_bench(&own).is_ok(), valid), (accepted, accepted));
        let (own, valid) = of("effects", &effects);
        assert_eq!((tumble::wire::read_effects(&own).is_ok(), valid), (accepted, accepted));
        let (own, valid) = of("truth", &truth);
        let schedule = tumble::wire::read_campaign(
            &tumble::wire::Source { name: "s".into(), text: text("examples/07-hidden-effect/schedule.campaign.json") },
            &mut fetch,
        );
        let read = tumble::wire::read_truth(&own, &schedule.expect("a schedule"));
        assert_eq!((read.is_ok(), valid), (accepted, accepted));
        let (own, valid) = of("mission", &mission);
        let read = tumble::wire::parse::<tumble::wire::MissionFile>(&own);
        assert_eq!((read.is_ok(), valid), (accepted, accepted));
    }
}
