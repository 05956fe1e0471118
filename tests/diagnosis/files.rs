//! `tumble diagnose` at the command line: catalogues good and bad, the repaired model run again, pages and pictures, outputs whole or not at all.

use crate::markup::element;
use assert_cmd::Command;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

fn tumble(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("tumble").unwrap().current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn table_1() -> String {
    root("examples/05-table-1-diagnosed/table1.campaign.json").to_str().unwrap().into()
}

/// An accelerometer in 24 positions of the plane, three times round; simulated from a truth into `measured.campaign.json`.
fn measured(folder: &Path, change: impl Fn(&mut Value), effects: Value, seed: u64) {
    let positions: Vec<Value> = (0..72)
        .map(|k| json!({ "position": format!("{}", k % 24), "beta_deg": 15 * (k % 24), "time_s": 60 * k }))
        .collect();
    let mut schedule = json!({ "bench": "accelerometer-plumb-plane", "known": { "kI": { "value": 1.299 } },
        "estimate": { "V0": {}, "dtheta_y2": {}, "dtheta_z2": {} }, "readings": positions });
    change(&mut schedule);
    let angle = |value: f64| json!({ "value": value, "unit": "arcsec" });
    let truth = json!({ "values": { "V0": { "value": 0.002 }, "dtheta_y2": angle(-5.0), "dtheta_z2": angle(20.0) },
        "noise": { "V": { "sd": 3e-6 } }, "effects": effects });
    fs::write(folder.join("schedule.json"), schedule.to_string()).unwrap();
    fs::write(folder.join("truth.json"), truth.to_string()).unwrap();
    let seed = seed.to_string();
    let arguments = [
        "simulate",
        "schedule.json",
        "--truth",
        "truth.json",
        "--seed",
        &seed,
        "-o",
        "measured.campaign.json",
        "--force",
    ];
    let (code, _, errors) = tumble(folder, &arguments);
    assert_eq!(code, 0, "{errors}");
}

fn report(folder: &Path, arguments: &[&str], exit: i32) -> Value {
    let all: Vec<&str> =
        ["diagnose", "measured.campaign.json", "--json", "-"].iter().chain(arguments).copied().collect();
    let (code, text, errors) = tumble(folder, &all);
    assert_eq!(code, exit, "{errors}");
    serde_json::from_str(&text).unwrap()
}

fn regressors(report: &Value) -> Vec<&str> {
    report["effects"].as_array().unwrap().iter().map(|e| e["regressor"].as_str().unwrap()).collect()
}

#[test]
fn bad_catalogues_are_located() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.json");
    let effect = |rest: &str| {
        format!("{{\n  \"effects\": [\n    {{ \"term\": \"a_S\", \"name\": \"mine\" }},\n    {{ {rest} }}\n  ]\n}}\n")
    };
    // the text, the line of the fault, words that must be said
    let cases: [(&str, usize, &[&str]); 8] = [
        (r#""term": "a_S * * 2", "name": "x""#, 4, &["does not parse", "effects[1].term"]),
        (r#""term": "a_S + a_Q", "name": "x""#, 4, &["a_Q", "effects[1].term"]),
        (r#""term": "sin({axle})", "name": "x""#, 4, &["does not parse", "effects[1].term"]),
        (r#""term": "a_S", "name": "x""#, 4, &["there twice", "effects[0]"]),
        (r#""term": "a_S*1", "name": "x", "sensor": "V""#, 4, &["unknown key 'sensor'", "effects[1].sensor"]),
        (r#""term": "", "name": "x""#, 4, &["no term", "effects[1].term"]),
        (r#""term": "tilt:dtheta_q9", "name": "x""#, 4, &["dtheta_q9", "effects[1].term"]),
        (r#""term": "2", "name": "x""#, 4, &["constant", "effects[1].term"]),
    ];
    for (rest, line, words) in cases {
        fs::write(&file, effect(rest)).unwrap();
        let (code, text, errors) =
            tumble(folder.path(), &["diagnose", &table_1(), "--effects", "own.json", "--json", "out.json"]);
        assert_eq!((code, text.as_str()), (1, ""), "{rest}: {errors}");
        assert!(errors.contains(&format!("in own.json, line {line}, ")), "{rest}: {errors}");
        assert!(words.iter().all(|word| errors.contains(word)), "{rest}: {errors}");
        assert!(!folder.path().join("out.json").exists() && !errors.contains("panicked"));
    }
    // the caret stands under the second star
    fs::write(&file, effect(cases[0].0)).unwrap();
    let (_, _, errors) = tumble(folder.path(), &["diagnose", &table_1(), "--effects", "own.json"]);
    let lines: Vec<&str> = errors.lines().collect();
    let (quoted, line) = lines.iter().enumerate().find(|(_, l)| l.contains("a_S * * 2")).unwrap();
    let column = |text: &str, what: &str| text.find(what).map(|k| text.get(..k).unwrap().chars().count());
    let star = column(line, "* 2").unwrap();
    let mark = lines[quoted + 1].chars().position(|c| matches!(c, '┬' | '▲' | '^' | '─')).unwrap();
    assert_eq!(mark, star, "{errors}");
}

#[test]
fn the_catalogue_that_ships_has_nothing_twice() {
    assert!(tumble::wire::built_in_effects().unwrap().len() > 20);
}

#[test]
fn an_effect_of_ones_own_is_named_explained_and_repaired() {
    let folder = tempfile::tempdir().unwrap();
    measured(folder.path(), |_| {}, json!([{ "regressor": "sin(2.5*beta)", "value": 3e-5 }]), 5);
    // the built-in catalogue has whole harmonics only
    let without = report(folder.path(), &[], 2);
    let is_open = without["verdict"] != "effects-found" || !without["suspected"].as_array().unwrap().is_empty();
    assert!(is_open, "{}", without["verdict"]);
    let own = json!({ "effects": [{ "term": "sin(2.5*{joint})", "name": "five-lobed bearing of {joint}", "coefficient": "lobes_{joint}",
        "why": "the bearing has five lobes", "confirm": "measure every 10 deg" }] });
    fs::write(folder.path().join("own.json"), own.to_string()).unwrap();
    let with = report(
        folder.path(),
        &["--effects", "own.json", "--write-model", "repaired.bench.json", "--html", "p.html"],
        2,
    );
    assert_eq!((with["verdict"].as_str(), regressors(&with)), (Some("effects-found"), vec!["sin(2.5*beta)"]));
    let effect = &with["effects"][0];
    assert_eq!(
        (effect["name"].as_str(), effect["coefficient"].as_str()),
        (Some("five-lobed bearing of beta"), Some("lobes_beta"))
    );
    let (value, u) = (effect["value"].as_f64().unwrap(), effect["u"].as_f64().unwrap());
    assert!((value - 3e-5).abs() < 4.0 * u && effect["U"].as_f64().unwrap() > u);
    let bench = fs::read_to_string(folder.path().join("repaired.bench.json")).unwrap();
    assert!(bench.contains("+ lobes_beta*sin(2.5*beta)"));
    let page = fs::read_to_string(folder.path().join("p.html")).unwrap();
    assert!(page.contains("the bearing has five lobes") && page.contains("<mark>lobes_beta*sin(2.5*beta)</mark>"));
}

/// For each kind of repair: the written bench and campaign fit without complaint, and nothing more is missing in them.
#[test]
fn the_written_model_is_complete() {
    let prior = |schedule: &mut Value| {
        schedule["estimate"]["dtheta_z2"] = json!({ "prior": 90, "prior_u": 2, "unit": "arcsec" })
    };
    let equal = |schedule: &mut Value| schedule["constraints"] = json!([{ "of": { "dtheta_z2": 1 }, "equals": 0, "unit": "arcsec" }, { "of": { "dtheta_y2": 1 }, "between": [-50, 50], "unit": "arcsec" }]);
    let plain = |_: &mut Value| {};
    type Case<'a> = (&'a str, &'a dyn Fn(&mut Value), Value);
    let cases: [Case; 6] = [
        ("term", &plain, json!([{ "regressor": "abs(a_P)", "value": 5e-5 }])),
        ("position", &plain, json!([{ "regressor": "position:7", "value": 3e-5 }])),
        ("reading", &plain, json!([{ "regressor": "reading:40", "value": 6e-5 }])),
        ("drift", &plain, json!([{ "regressor": "time_s", "value": 1e-8 }])),
        ("prior", &prior, json!([])),
        ("constraint", &equal, json!([])),
    ];
    for (name, change, effects) in cases {
        let folder = tempfile::tempdir().unwrap();
        measured(folder.path(), change, effects, 2);
        let first = report(folder.path(), &["--write-model", "fixed.bench.json"], 2);
        assert_eq!(first["verdict"], "effects-found", "{name}");
        let (code, _, errors) = tumble(folder.path(), &["fit", "fixed.campaign.json"]);
        assert_eq!(code, 0, "{name}: {errors}");
        let (code, text, errors) = tumble(folder.path(), &["diagnose", "fixed.campaign.json"]);
        assert_eq!(code, 0, "{name}: {text}{errors}");
        assert!(text.contains("OK: "), "{name}: {text}");
        let fixed: Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("fixed.campaign.json")).unwrap()).unwrap();
        match name {
            "prior" if regressors(&first) == ["prior:dtheta_z2"] => {
                assert!(fixed["estimate"]["dtheta_z2"]["prior"].is_null())
            }
            // the wrong equality is gone, the bound that did not bind stays
            "constraint" => assert_eq!(fixed["constraints"].as_array().unwrap().len(), 1, "{fixed}"),
            _ => {}
        }
    }
}

#[test]
fn outputs_are_written_all_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let entries = || fs::read_dir(folder.path()).unwrap().count();
    let good = folder.path().join("good.json");
    for bad in [
        ["--html", "none/page.html"],
        ["--svg", "none/picture.svg"],
        ["--write-model", "none/fixed.bench.json"],
        ["--md", "/dev/null/page.md"],
    ] {
        let (code, text, errors) =
            tumble(folder.path(), &["diagnose", &table_1(), "--json", good.to_str().unwrap(), bad[0], bad[1]]);
        assert_eq!((code, text.as_str()), (1, ""), "{errors}");
        assert!(errors.contains("cannot write"), "{errors}");
        assert_eq!(entries(), 0, "{bad:?} leaves something behind");
    }
    // a folder stands where the campaign should go: the bench is not written either
    fs::create_dir(folder.path().join("fixed.campaign.json")).unwrap();
    let (code, _, errors) = tumble(folder.path(), &["diagnose", &table_1(), "--write-model", "fixed.bench.json"]);
    assert!(code == 1 && errors.contains("it is a folder"), "{errors}");
    assert_eq!(entries(), 1);
    // and a name that is no bench file's is refused before anything is done
    let (code, text, errors) = tumble(folder.path(), &["diagnose", &table_1(), "--write-model", "fixed.json"]);
    assert!(code == 1 && text.is_empty() && errors.contains(".bench.json"), "{errors}");
}

#[test]
fn the_page_says_what_the_report_says() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, _) =
        tumble(folder.path(), &["diagnose", &table_1(), "--html", "p.html", "--svg", "p.svg", "--md", "p.md"]);
    assert!(code == 2 && text.contains("Problem: One effect is missing from the model"));
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let page = read("p.html");
    let (head, rest) = page.split_once("<style>").unwrap();
    let (_, rest) = rest.split_once("</style>").unwrap();
    let closed = format!("{head}{rest}").replace("<!DOCTYPE html>", "").replace("<meta charset=\"utf-8\">", "");
    let closed = closed.replace("<meta name=\"color-scheme\" content=\"light dark\">", "");
    let closed = closed.replace("<meta name=\"generator\" content=\"tumble\">", "");
    let tree = element(&closed.replace("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">", ""));
    let headings: Vec<String> = tree.all("h2").into_iter().map(|h| h.text).collect();
    for heading in [
        "Result",
        "What is missing",
        "Model",
        "Effect on the estimates",
        "Where the residuals are",
        "Residuals step by step",
        "What was assumed",
    ] {
        assert!(headings.iter().any(|h| h == heading), "{heading} is not in {headings:?}");
    }
    assert!(page.contains("<mark>D_S*a_S</mark>"));
    assert!(page.contains("gamma_deg_s*cos(2*alpha)") && page.contains("is not absorbed by the model"));
    assert!(!page.contains("src=") && !page.contains("<script"));
    // before and after of each of the 30 readings, and the two marks of the legend
    let picture = read("p.svg");
    assert!(picture.starts_with("<svg") && picture.contains("fill=\"#fff\""));
    assert_eq!(element(&picture).all("circle").len(), 2 * 30 + 2);
    let markdown = read("p.md");
    let sections: Vec<&str> = markdown.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    assert_eq!(sections, headings);
    assert!(markdown.contains("+ D_S*a_S\n") && markdown.contains("^^^^^^^"));
}

/// Six thousand readings: columns for all bad readings and steps would be 36 million numbers twice over.
#[test]
fn long_campaigns_are_diagnosed_like_short_ones() {
    let folder = tempfile::tempdir().unwrap();
    let long = |schedule: &mut Value| {
        let at = |k: usize| json!({ "position": (k % 24).to_string(), "beta_deg": 15 * (k % 24), "time_s": 10 * k });
        schedule["readings"] = (0..6000).map(at).collect();
    };
    for (effects, named) in [
        (json!([{ "regressor": "reading:4321", "value": 4e-5 }]), vec!["reading:4321"]),
        (
            json!([{ "regressor": "abs(a_P)", "value": 3e-5 }, { "regressor": "reading:17", "value": 5e-5 }]),
            vec!["abs(a_P)", "reading:17"],
        ),
        (json!([{ "regressor": "step(time_s-31415)", "value": 2e-6 }]), vec!["step(time_s-31415.0)"]),
        (json!([]), vec![]),
    ] {
        measured(folder.path(), long, effects, 3);
        let found = report(folder.path(), &[], if named.is_empty() { 0 } else { 2 });
        let effects = found["effects"].as_array().unwrap();
        assert_eq!(effects.len(), named.len(), "{:?} is not {named:?}", regressors(&found));
        for name in &named {
            let held = |effect: &Value| {
                effect["regressor"] == *name
                    || effect["aliases"].as_array().unwrap().iter().any(|a| a["regressor"] == *name)
            };
            assert!(effects.iter().any(held), "{name} is not in {:?}", regressors(&found));
        }
        // every bad reading and every step is accounted for in the probabilities
        assert!(found["distinct_candidates"].as_u64().unwrap() > 11_900);
    }
}

/// A norm needs its triad: offsets at which all scale factors are zero leave nothing of the readings, and explain nothing.
#[test]
fn a_norm_is_not_explained_by_offsets_of_its_size() {
    let campaign = tumble::Campaign::from_path(root("tests/data/norm/mpu9150.campaign.json")).expect("a campaign");
    let catalogue = tumble::wire::built_in_effects().unwrap();
    let found = tumble::diagnose(&campaign, &catalogue, &Default::default()).expect("a diagnosis");
    let sizes: Vec<f64> = found.effects.iter().filter_map(|own| own.value).collect();
    assert!(sizes.iter().all(|size| size.abs() < 0.1), "{:?} {sizes:?}", found.verdict);
    assert_eq!(found.verdict, tumble::diagnosis::Verdict::Unexplained);
}

/// Campaigns of simulators that are not this program, in which 0.2.0 named a scatter of 0 V, cosines of two joints, or nothing at F = 787.
#[test]
fn effects_that_once_were_missed_are_named() {
    let cases: [(&str, &[&str]); 6] = [
        // the fronts of two classes that share members were a pair that chi-square contradicts; the truth is exp(-order/4), and time constants have a grid
        ("order-and-exponential", &["position:17", "order", "exp(-order/3.6)"]),
        // "partly explained", since the third sensor of each kind may have it as well
        ("some-of-a-triad", &["sign(inner_deg_s)", "position:p15", "tilt:middle_linear"]),
        ("imu-Gx-a_z", &["a_z"]),
        ("scatter-false-drift", &["time_s"]),
        ("scatter-zero", &["w_I^2"]),
        ("nothing-missing-two", &["a_P^3", "time_s"]),
    ];
    let catalogue = tumble::wire::built_in_effects().unwrap();
    for (file, hidden) in cases {
        let campaign =
            tumble::Campaign::from_path(root(&format!("tests/data/hidden/once/{file}.campaign.json"))).unwrap();
        let found = tumble::diagnose(&campaign, &catalogue, &Default::default()).unwrap();
        let names: Vec<&str> = found.effects.iter().map(|own| own.effect.regressor.as_str()).collect();
        assert_eq!(
            (found.verdict, names.len()),
            (tumble::diagnosis::Verdict::EffectsFound, hidden.len()),
            "{file}: {names:?}"
        );
        for own in hidden {
            let is = |finding: &tumble::diagnosis::Finding| {
                finding.effect.regressor == *own || finding.aliases.iter().any(|alias| alias.regressor == *own)
            };
            assert!(found.effects.iter().any(is), "{file}: {own} is not in {names:?}");
        }
    }
}

/// Campaigns of such a simulator in which names were wrong: a random factor of the rate at each position, to which linear solutions with tilts of thousands of turns
/// were fitted; two effects in the place of two others, each of which is worse by itself.
#[test]
fn names_that_nothing_supports_are_not_given() {
    let catalogue = tumble::wire::built_in_effects().unwrap();
    let cases: [(&str, &[&str]); 2] = [
        ("rate-factors", &["reading:55", "position:55"]),
        ("two-for-two", &["gamma_deg_s^2", "sin(beta)", "position:4", "sin(1*beta)"]),
    ];
    for (file, hidden) in cases {
        let campaign =
            tumble::Campaign::from_path(root(&format!("tests/data/hidden/once/{file}.campaign.json"))).unwrap();
        let found = tumble::diagnose(&campaign, &catalogue, &Default::default()).unwrap();
        for own in &found.effects {
            let is_hidden = |name: &String| hidden.contains(&name.as_str());
            let aliases = own.aliases.iter().map(|alias| &alias.regressor);
            assert!(aliases.chain([&own.effect.regressor]).any(is_hidden), "{file}: {}", own.effect.regressor);
        }
    }
}
