//! `tumble plan` as a person runs it: the shipped example, files that run, exit codes, words that help.

use assert_cmd::Command;
use std::path::{Path, PathBuf};

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/18-plan-five-positions")
}

/// Exit code, stdout and stderr of `tumble ARGUMENTS` in a folder.
fn tumble(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(folder).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

const PUBLISHED: &str = "published.campaign.json";
const NOISE: [&str; 2] = ["--noise", "V=9e-4"];

fn plan(arguments: &[&str]) -> (i32, String, String) {
    let all: Vec<&str> = ["plan", PUBLISHED].into_iter().chain(NOISE).chain(arguments.iter().copied()).collect();
    tumble(&example(), &all)
}

/// The schedule that ships with the example is what the command in its README writes, and its efficiency is at least 0.99.
#[test]
fn the_example_is_what_the_program_writes() {
    let folder = tempfile::tempdir().unwrap();
    let (written, page) = (folder.path().join("best.json"), folder.path().join("plan.html"));
    let arguments = [
        "--choose",
        "30",
        "--unit",
        "mounting",
        "--step",
        "36",
        "--write",
        written.to_str().unwrap(),
        "--html",
        page.to_str().unwrap(),
    ];
    let (code, stdout, stderr) = plan(&arguments);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let line = stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(line.contains("At least 100.00 % as good as the best admissible choice"), "{stdout}");
    let shipped = std::fs::read_to_string(example().join("best-five.campaign.json")).unwrap();
    assert_eq!(std::fs::read_to_string(&written).unwrap(), shipped);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("<svg") && html.contains("Where the positions lie") && !html.contains("<script"));
    // the schedule runs: it can be judged, and checked
    let (code, stdout, _) = tumble(&example(), &["plan", "best-five.campaign.json", "--noise", "V=9e-4"]);
    assert!(code == 0 && stdout.contains("30 readings; mountings: 5"), "{stdout}");
    let (code, stdout, _) = tumble(&example(), &["check", "best-five.campaign.json"]);
    assert!(code == 0 && stdout.contains("a schedule"), "{stdout}");
}

#[test]
fn the_report_obeys_its_schema() {
    let (code, schema, _) = tumble(&example(), &["schema", "plan-report"]);
    assert_eq!(code, 0);
    let schema: serde_json::Value = serde_json::from_str(&schema).unwrap();
    for search in [&["--add", "6"][..], &["--goal", "1", "--most", "60"], &[]] {
        let (_, stdout, stderr) = plan(&[search, &["--json", "-"]].concat());
        let report: serde_json::Value = serde_json::from_str(&stdout).unwrap_or_else(|_| panic!("{stdout}{stderr}"));
        let errors: Vec<String> =
            jsonschema::validator_for(&schema).unwrap().iter_errors(&report).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{errors:?}");
        assert_eq!(report["report"], "plan");
        assert_eq!(report["improved"].is_null(), search.is_empty());
    }
}

/// A goal that so few readings cannot reach is an answer, "rejected", with the best reachable.
#[test]
fn a_goal_out_of_reach_says_the_best_reachable() {
    let (code, stdout, _) = plan(&["--goal", "0.1", "--most", "12"]);
    assert_eq!(code, 2, "{stdout}");
    assert!(stdout.contains("The goal is not reached: at best"), "{stdout}");
}

/// The cheapest says what it counts and that no proof goes with it, and costs no more than what a budget finds.
#[test]
fn the_cheapest_for_a_goal_is_as_cheap_as_a_budget_finds() {
    let (code, stdout, stderr) = plan(&["--goal", "1", "--cheapest", "--json", "-"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let report: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let cost = report["improved"]["judgement"]["work"]["cost"].as_f64().unwrap();
    println!("cheapest: {cost}");
    assert!(cost <= 60.0);
    let (_, stdout, _) = plan(&["--goal", "1", "--cheapest"]);
    let line = stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(line.contains("but not to bias, misalignment, azimuth, gamma"), "{stdout}");
    assert!(line.contains("the cheapest schedule that was found"), "{stdout}");
}

/// Angles moved between the candidates are never worse than the choice, stay out of forbidden zones, and need a choice.
#[test]
fn angles_are_refined_on_request() {
    let read = |further: &[&str]| {
        let arguments = ["--choose", "6", "--any-cost", "--step", "45", "--starts", "10", "--json", "-"];
        let (code, stdout, stderr) = plan(&arguments.iter().chain(further).copied().collect::<Vec<_>>());
        assert_eq!((code, stderr.as_str()), (0, ""), "{further:?}");
        serde_json::from_str::<serde_json::Value>(&stdout).unwrap()["improved"].clone()
    };
    assert!(read(&[])["refined"].is_null());
    for criterion in ["D", "A", "E", "dtheta_z2"] {
        let improved = read(&["--criterion", criterion, "--refine", "0.5", "--forbid", "beta_deg=80:100"]);
        let refined = &improved["refined"];
        println!("{criterion}: {refined}");
        let gain = refined["gain"].as_f64().unwrap();
        assert!(refined["finished"] == true && (gain > 0.0) == (refined["moved"] != 0), "{criterion}: {refined}");
        assert!(gain > 0.0 || criterion != "D", "six angles of 45 deg are not the best");
        for position in improved["positions"].as_array().unwrap() {
            let text = position.to_string();
            let beta: f64 =
                text.split("\"beta_deg\":").nth(1).unwrap().split([',', '}']).next().unwrap().parse().unwrap();
            assert!(!(80.0..=100.0).contains(&beta) && (beta / 0.5).fract() == 0.0, "{text}");
        }
    }
    let (code, _, stderr) = plan(&["--refine", "0.5"]);
    assert!(code == 1 && stderr.contains("--choose"), "{stderr}");
    let (code, _, stderr) = plan(&["--choose", "6", "--refine", "0"]);
    assert!(code == 1 && stderr.contains("resolution"), "{stderr}");
}

/// With angles between the candidates a goal takes no more readings; degrees cost, and a budget that cannot pay for the way says what would.
#[test]
fn goals_are_refined_and_the_way_is_paid_for() {
    let chosen = |further: &[&str]| {
        let arguments = ["--goal", "dtheta_z2=3", "--step", "60", "--starts", "10", "--json", "-"];
        let (code, stdout, stderr) = plan(&arguments.iter().chain(further).copied().collect::<Vec<_>>());
        assert_eq!((code, stderr.as_str()), (0, ""), "{further:?}");
        let improved = serde_json::from_str::<serde_json::Value>(&stdout).unwrap()["improved"].clone();
        assert_eq!(improved["goal"]["reached"], true);
        improved["chosen"].as_u64().unwrap()
    };
    let (coarse, fine) = (chosen(&[]), chosen(&["--refine", "1"]));
    println!("{coarse} readings among the candidates, {fine} between them");
    assert!(fine <= coarse);
    let (code, stdout, stderr) = plan(&["--budget", "200", "--cost", "degree=0.1", "--json", "-"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let improved = serde_json::from_str::<serde_json::Value>(&stdout).unwrap()["improved"].clone();
    let cost = improved["judgement"]["work"]["cost"].as_f64().unwrap();
    assert!(cost <= 200.0 && cost > 150.0, "{cost}");
    let (code, _, stderr) = plan(&["--budget", "60", "--cost", "degree=10"]);
    assert!(code == 1 && stderr.contains("the cheapest that was found"), "{stderr}");
}

/// Two effects that are the same column at every candidate: one sentence, no schedule.
#[test]
fn what_no_candidate_tells_apart_is_one_sentence() {
    let (code, stdout, _) = plan(&["--separate", "a_S", "sin(alpha)"]);
    assert_eq!(code, 2, "{stdout}");
    let said = stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("No candidate discriminates a_S and sin(alpha), so nothing is added."), "{stdout}");
    assert!(!stdout.contains("TO RUN, IN THIS ORDER") && !stdout.contains("THE BETTER SCHEDULE"), "{stdout}");
}

#[test]
fn malformed_questions_exit_with_1_and_say_what_was_expected() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let schedule = std::fs::read_to_string(example().join(PUBLISHED)).unwrap();
    file(PUBLISHED, &schedule);
    let from = schedule.find("\"readings\"").unwrap();
    let with = |readings: &str| format!("{}\"readings\": {readings} }}", &schedule[..from]);
    file("empty.json", &with("[]"));
    file("impossible.json", &with(r#"[ { "alpha_deg": 0, "beta_deg_s": 20, "gamma_deg_s": 20 } ]"#));
    file("jointless.json", &with(r#"[ { "alpha_deg": 0, "gamma_deg_s": 20 } ]"#));
    file(
        "other.json",
        r#"{ "bench": "accelerometer-plumb-plane", "estimate": { "V0": {} }, "readings": [ { "beta_deg": 0 } ] }"#,
    );
    let cases: &[(&[&str], &str)] = &[
        (&["plan", PUBLISHED], "--noise V=SD"),
        (&["plan", PUBLISHED, "--noise", "V"], "NAME=NUMBER"),
        (&["plan", PUBLISHED, "--noise", "V=0"], "positive"),
        (&["plan", PUBLISHED, "--noise", "W=1"], "one of V"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--remount", "tilt=1"], "dtheta_y2"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "0"], "a positive number"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "4"], "at least 6 readings"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--repeats", "0"], "at most 0 readings"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--criterion", "X"], "dtheta_z2"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--starts", "0"], "1 to 1000000"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--step=-3"], "above 0"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--forbid", "alpha"], "KEY=LOW:HIGH"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--forbid", "delta_deg=0:1"], "alpha_deg"),
        (
            &["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--candidates", "empty.json"],
            "at least one position",
        ),
        (
            &["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--candidates", "impossible.json"],
            "one turning joint",
        ),
        (&["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--candidates", "jointless.json"], "beta_deg"),
        (
            &["plan", PUBLISHED, "--noise", "V=1", "--choose", "12", "--candidates", "other.json"],
            "a schedule on gyro-turntable",
        ),
        (&["plan", PUBLISHED, "--noise", "V=1", "--goal=-1"], "positive"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--goal", "kOS=1"], "dtheta_z2"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--cost", "tea=1"], "one of mounting, rate, reading"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--cost", "rate=-1"], "zero or a positive number"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--budget=-3"], "a positive number, in the unit of the costs"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--budget", "20"], "a budget of "),
        (&["plan", PUBLISHED, "--noise", "V=1", "--tilts=-1"], "zero or more"),
        (&["plan", PUBLISHED, "--noise", "V=1", "--separate", "a_S", "a_Q"], "a joint's name"),
        (
            &["plan", PUBLISHED, "--noise", "V=1", "--separate", "a_O*a_S", "a_S*a_O"],
            "to be discriminated are the same",
        ),
        (&["plan", PUBLISHED, "--noise", "V=1", "--separate", "w_I", "a_S"], "zero at every candidate and reading"),
        (&["plan", "empty.json", "--noise", "V=1"], "at least one reading"),
    ];
    for (arguments, word) in cases {
        let (code, stdout, stderr) = tumble(folder.path(), arguments);
        assert!(code == 1 && stdout.is_empty(), "{arguments:?}: {code}\n{stdout}{stderr}");
        let told = stderr.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert!(told.contains(word) && !told.contains("panicked"), "{arguments:?} lacks {word}:\n{stderr}");
    }
}

/// A derived quantity is predicted in its own unit: a misalignment in urad is the total angle, which is predicted in arcsec.
#[test]
fn derived_quantities_have_their_units() {
    let derived = |schedule: &str, id: &str| {
        let (_, stdout, stderr) = tumble(&example(), &["plan", schedule, "--noise", "V=9e-4", "--json", "-"]);
        let report: serde_json::Value = serde_json::from_str(&stdout).unwrap_or_else(|_| panic!("{stdout}{stderr}"));
        report["schedule"]["derived"].as_array().unwrap().iter().find(|own| own["id"] == id).cloned().unwrap()
    };
    let measured = "../01-gyro-table/table1.campaign.json";
    let [gamma, misalignment, bias] = ["gamma", "misalignment", "bias"].map(|id| derived(measured, id));
    assert_eq!((misalignment["unit"].as_str(), bias["unit"].as_str()), (Some("urad"), Some("deg/h")));
    assert!(misalignment["u_arcsec"].is_null() && bias["u_arcsec"].is_null());
    let urad = gamma["u"].as_f64().unwrap() * 1e6;
    assert!((misalignment["u"].as_f64().unwrap() / urad - 1.0).abs() < 1e-12, "{misalignment} {gamma}");
    // the direction of an angle: known where readings say how large that is, not of an angle of which nothing is known
    assert!(derived(measured, "azimuth")["u"].as_f64().is_some() && derived(PUBLISHED, "azimuth")["u"].is_null());
}

/// An effect that the positions are chosen to find is estimated with them, and so is not among what stays hidden; without `--find` it is absorbed.
#[test]
fn what_is_to_be_found_is_not_said_to_stay_hidden() {
    let schedule = "../07-hidden-effect/schedule.campaign.json";
    let hidden = |more: &[&str]| {
        let arguments = [&["plan", schedule, "--noise", "V=1e-4"], more, &["--json", "-"]].concat();
        let (_, text, errors) = tumble(&example(), &arguments);
        let report: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {errors}"));
        let judged = if more.is_empty() { &report["schedule"] } else { &report["improved"]["judgement"] };
        let effects = judged["effects"]["effects"].as_array().expect("effects").clone();
        assert!(effects.len() > 50, "{}", effects.len());
        let of = |effect: &serde_json::Value| {
            (
                effect["regressor"].as_str().expect("a term").to_string(),
                effect["fate"].as_str().expect("a fate").to_string(),
            )
        };
        let found: Vec<(String, String)> = effects.iter().map(of).collect();
        let (_, printed, _) = tumble(&example(), &[&arguments[..arguments.len() - 2], &["-v"]].concat());
        (found, printed)
    };
    let (before, _) = hidden(&[]);
    assert!(before.iter().any(|(term, _)| term == "a_S"), "{before:?}");
    let (after, printed) = hidden(&["--find", "a_S=1e-3"]);
    assert!(after.iter().all(|(term, _)| term != "a_S"), "{after:?}");
    // what its coefficient absorbs is still said
    assert!(after.iter().any(|(_, fate)| fate == "absorbed"));
    let never = printed.split("Effects that cannot be detected").nth(1).expect("a section");
    let absorbed = |line: &str| line.starts_with("a_S^3") && line.ends_with("  c_a_S");
    assert!(never.lines().any(absorbed), "{never}");
    let words: Vec<&str> = never.split([' ', ',', '\n']).collect();
    assert!(!words.contains(&"a_S"), "{never}");
}

/// Effects that are to be found, and limits of parameters, are goals of one schedule; tilts without a limit are held to one degree.
#[test]
fn what_is_to_be_found_stands_beside_goals() {
    let (code, stdout, stderr) = plan(&["--find", "a_S=3e-3", "--goal", "dtheta_y2=2", "--json", "-"]);
    assert_eq!(code, 0, "{stderr}");
    let report: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    let (goal, finds) = (&report["improved"]["goal"], &report["finds"]);
    assert_eq!(goal["reached"], true);
    assert_eq!((&goal["limits"]["dtheta_y2"], &goal["limits"]["dtheta_x0"]), (&2.0.into(), &3600.0.into()));
    assert_eq!(goal["limits"]["c_a_S"], finds[0]["u"]);
}

/// A schedule that is kept and keeps the limits needs no reading more.
#[test]
fn a_schedule_that_is_enough_is_added_nothing() {
    let (code, stdout, stderr) = plan(&["--goal", "1000", "--keep"]);
    assert!(code == 0 && stdout.contains("30 readings; mountings: 5"), "{stdout}{stderr}");
}

/// Where an effect alone is sought, tilts that the schedule determines are held to one degree: as angles that act in the first order.
#[test]
fn what_is_to_be_found_leaves_the_tilts_determined() {
    let folder = tempfile::tempdir().expect("a folder");
    let positions = [(0, 0), (0, 45), (0, 90), (90, 90), (180, 90), (270, 90), (0, 180)];
    let rates = [10, -10, 50, -50, 100, -100, 200, -200, 300, -300];
    let readings: Vec<String> = positions
        .iter()
        .flat_map(|(alpha, beta)| {
            rates.map(|rate| {
                format!(r#"{{"position": "{alpha}/{beta}", "alpha_deg": {alpha}, "beta_deg": {beta}, "gamma_deg_s": {rate}}}"#)
            })
        })
        .collect();
    let schedule = format!(
        r#"{{"bench": {{"id": "own", "chain": [{{"joint": "gamma", "about": "z"}}, {{"tilt": "fix", "about": "x"}}, {{"joint": "beta", "about": "x"}},
            {{"joint": "alpha", "about": "z"}}, {{"tilt": "dx", "about": "x"}}, {{"tilt": "dy", "about": "y"}}],
            "sensors": {{"V": {{"unit": "mV", "model": "V0 + K*w_z"}}}}}},
            "site": {{"latitude_deg": 48}}, "estimate": {{"fix": {{}}, "dx": {{}}, "dy": {{}}, "V0": {{}}, "K": {{"start": 5}}}},
            "readings": [{}]}}"#,
        readings.join(",")
    );
    std::fs::write(folder.path().join("s.json"), schedule).expect("a file");
    let at = ["--at", "fix=300", "--at", "dx=1200", "--at", "dy=-800"];
    let asked = ["plan", "s.json", "--noise", "V=0.03", "--find", "a_z=0.05", "--json", "-"];
    let (code, stdout, stderr) = tumble(folder.path(), &[&asked[..], &at].concat());
    assert_eq!(code, 0, "{stderr}");
    let report: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    let limits = report["improved"]["goal"]["limits"].as_object().expect("limits");
    assert_eq!(limits.keys().collect::<Vec<_>>(), ["c_a_z", "dx", "dy", "fix"]);
    let parameters = report["improved"]["judgement"]["parameters"].as_array().expect("parameters");
    for own in parameters.iter().filter(|own| ["fix", "dx", "dy"].iter().any(|tilt| own["id"] == *tilt)) {
        assert!(own["u"].as_f64().is_some_and(|u| u < 1_f64.to_radians()), "{own}");
    }
}

/// A line of scatter whose u is to be estimated: a schedule cannot, and the error names the option; with it the plan is that of a schedule that states the u.
#[test]
fn scatter_that_is_to_be_estimated_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = |u: &str| {
        let text = std::fs::read_to_string(example().join(PUBLISHED)).unwrap();
        let mut own: serde_json::Value = serde_json::from_str(&text).unwrap();
        let line = format!(r#"[{{"of": "dtheta_y2", "per": "position", "u": {u}, "unit": "arcsec"}}]"#);
        own["scatter"] = serde_json::from_str(&line).unwrap();
        std::fs::write(folder.path().join("s.campaign.json"), own.to_string()).unwrap();
    };
    let run = |more: &[&str]| {
        let all: Vec<&str> = ["plan", "s.campaign.json", "--noise", "V=9e-4", "--json", "-"]
            .into_iter()
            .chain(more.iter().copied())
            .collect();
        tumble(folder.path(), &all)
    };
    let numbers = |text: &str| {
        let report: serde_json::Value = serde_json::from_str(text).unwrap();
        report["schedule"]["parameters"].clone()
    };
    schedule("5");
    let (code, stated, error) = run(&[]);
    assert_eq!(code, 0, "{error}");
    let (_, larger, _) = run(&["--noise", "dtheta_y2 per position=50"]);
    assert_ne!(numbers(&larger), numbers(&stated), "another u is given");
    schedule("\"estimate\"");
    let (code, _, error) = run(&[]);
    let words = error.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
    assert!(code == 1 && words.contains("dtheta_y2 per position=SD") && words.contains("in arcsec"), "{error}");
    let (code, given, error) = run(&["--noise", "dtheta_y2 per position=5"]);
    assert_eq!((code, numbers(&given)), (0, numbers(&stated)), "{error}");
    let (code, _, error) = run(&["--noise", "gamma per position=5"]);
    assert!(code == 1 && error.contains("dtheta_y2 per position"), "{error}");
}
