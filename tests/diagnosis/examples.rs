//! The examples 05 to 08 say what the program says: both published tables diagnosed, a hidden effect from simulation to repair, and nothing.

use assert_cmd::Command;
use serde_json::Value;

fn example(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

fn diagnose(name: &str, campaign: &str, exit: i32) -> Value {
    let output = Command::cargo_bin("tumble")
        .unwrap()
        .current_dir(example(name))
        .args(["diagnose", campaign, "--json", "-"])
        .assert()
        .code(exit)
        .get_output()
        .stdout
        .clone();
    serde_json::from_slice(&output).unwrap()
}

fn names(effect: &Value) -> Vec<String> {
    let own = effect["regressor"].as_str().unwrap().to_string();
    let aliases = effect["aliases"].as_array().unwrap().iter().map(|a| a["regressor"].as_str().unwrap().to_string());
    std::iter::once(own).chain(aliases).collect()
}

#[test]
fn table_1_lacks_one_acceleration_sensitive_drift() {
    let report = diagnose("05-table-1-diagnosed", "table1.campaign.json", 2);
    assert_eq!(report["effects"].as_array().unwrap().len(), 1);
    let effect = &report["effects"][0];
    assert_eq!((effect["regressor"].as_str(), effect["coefficient"].as_str()), (Some("a_S"), Some("D_S")));
    // F = t^2 = 211 and 0.909 mV to 0.29 mV, as an independent fit of the published table gives them (to their printed digits)
    let t = effect["t"].as_f64().unwrap();
    assert!((t * t - 211.0).abs() < 10.0, "F = {}", t * t);
    assert!((report["gap"]["before"]["rms"].as_f64().unwrap() - 0.909e-3).abs() < 0.002e-3);
    assert!((report["gap"]["after"]["rms"].as_f64().unwrap() - 0.29e-3).abs() < 0.005e-3);
    assert_eq!(report["gap"]["noise"]["from"], "residuals");
    assert!(names(effect).iter().any(|name| name == "a_S^2"));
    // a_S changes its sign at alpha = 270 and a_S^2 does not
    assert_eq!(effect["separate_by"][0]["alpha_deg"].as_f64(), Some(270.0));
}

#[test]
fn table_2_lacks_one_term_of_twice_the_angle() {
    let report = diagnose("06-table-2-diagnosed", "table2.campaign.json", 2);
    assert_eq!(report["effects"].as_array().unwrap().len(), 1);
    assert!(names(&report["effects"][0]).iter().any(|name| name == "cos(2*beta)"));
    assert_eq!(report["gap"]["noise"]["from"], "replicates");
    // one of beta = 45, 135, 225, 315 tells them apart
    let beta = report["effects"][0]["separate_by"][0]["beta_deg"].as_f64().unwrap();
    assert!((beta / 45.0) % 2.0 == 1.0, "beta = {beta}");
}

#[test]
fn a_hidden_effect_from_simulation_to_repair() {
    let folder = tempfile::tempdir().unwrap();
    let measured = folder.path().join("measured.campaign.json");
    let here = example("07-hidden-effect");
    let tumble = || Command::cargo_bin("tumble").unwrap();
    tumble()
        .current_dir(&here)
        .args(["simulate", "schedule.campaign.json", "--truth", "hidden.truth.json", "--seed", "7", "-o"])
        .arg(&measured)
        .assert()
        .success();
    let kept = std::fs::read_to_string(here.join("measured.campaign.json")).unwrap();
    assert_eq!(std::fs::read_to_string(&measured).unwrap(), kept);
    let repaired = folder.path().join("repaired.bench.json");
    tumble().arg("diagnose").arg(&measured).arg("--write-model").arg(&repaired).assert().code(2);
    assert!(std::fs::read_to_string(&repaired).unwrap().contains("+ D_OO*a_O^2"));
    // with the effect in its model the campaign passes the global test: exit code 0
    tumble().arg("fit").arg(folder.path().join("repaired.campaign.json")).assert().success();
    let report = diagnose("07-hidden-effect", "measured.campaign.json", 2);
    let (value, u) = (report["effects"][0]["value"].as_f64().unwrap(), report["effects"][0]["u"].as_f64().unwrap());
    assert!((value - 0.0008).abs() < 3.0 * u, "{value} +- {u}");
}

#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    let report = diagnose("08-nothing-hidden", "measured.campaign.json", 0);
    assert_eq!(report["verdict"], "nothing-missing");
    assert!(report["effects"].as_array().unwrap().is_empty());
}

/// `UPDATE=1 cargo test --release --test diagnosis examples` draws them anew.
#[test]
fn the_pictures_are_what_the_program_draws() {
    for (name, campaign) in [
        ("05-table-1-diagnosed", "table1.campaign.json"),
        ("06-table-2-diagnosed", "table2.campaign.json"),
        ("07-hidden-effect", "measured.campaign.json"),
        ("08-nothing-hidden", "measured.campaign.json"),
    ] {
        let arguments = ["diagnose", campaign, "--svg", "-"];
        let output = Command::cargo_bin("tumble").unwrap().current_dir(example(name)).args(arguments).output().unwrap();
        let drawn = String::from_utf8(output.stdout).unwrap();
        let kept = example(name).join("gap.svg");
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&kept, &drawn).unwrap();
        }
        assert!(std::fs::read_to_string(&kept).unwrap() == drawn, "{name}/gap.svg is out of date");
    }
}

#[test]
fn a_catalogue_of_ones_own_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.json");
    for (term, said) in [("a_S * * 2", "does not parse"), ("a_Q", "a_Q")] {
        std::fs::write(&file, format!("{{ \"effects\": [ {{ \"term\": \"{term}\", \"name\": \"mine\" }} ] }}"))
            .unwrap();
        let output = Command::cargo_bin("tumble")
            .unwrap()
            .current_dir(example("05-table-1-diagnosed"))
            .args(["diagnose", "table1.campaign.json", "--effects"])
            .arg(&file)
            .assert()
            .code(1)
            .get_output()
            .stderr
            .clone();
        let text = String::from_utf8(output).unwrap();
        assert!(text.contains(said) && text.contains("effects[0].term"), "{text}");
    }
}
