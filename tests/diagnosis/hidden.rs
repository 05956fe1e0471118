//! The 18 campaigns of an independent simulator, each with one effect, two, none, or one from outside the catalogue: every one must be
//! named right (or stand in the alias set), nothing else may be named, and the noise must come back.
//!
//! The truth is read by this test only; the program sees the campaign file.

use serde_json::Value;
use tumble::diagnosis::{Diagnosis, Settings, Verdict, diagnose};
use tumble::wire::{self, Source};

fn read(name: &str) -> String {
    std::fs::read_to_string(format!("{}/tests/data/hidden/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn diagnosis(case: &str) -> Diagnosis {
    let source = Source { name: case.into(), text: read(&format!("{case}.campaign.json")) };
    let campaign = wire::read_campaign(&source, &mut |_| unreachable!("built-in benches need no file")).unwrap();
    diagnose(&campaign, &wire::built_in_effects().unwrap(), &Settings::default()).unwrap()
}

/// `sin(2*alpha)` is zero but for rounding where alpha is a multiple of 90 deg: its coefficient is 1e11 V/(deg/s), which no sensor has, and the
/// program has no such candidate. What it leaves in the readings resembles `cos(2*alpha)`.
const ROUNDING: &str = "gamma_deg_s*sin(2*alpha)";
/// The catalogue has harmonics up to the number that 24 angles carry.
const SEVENTH: &str = "sin(7*beta)";

/// Is every true effect named or an alias, each of another finding, and nothing else?
fn holds(found: &Diagnosis, truth: &[String]) -> bool {
    let names = |k: usize, regressor: &String| {
        let finding = &found.effects[k];
        finding.effect.regressor == *regressor || finding.aliases.iter().any(|alias| alias.regressor == *regressor)
    };
    match truth {
        [] => found.verdict == Verdict::NothingMissing,
        [a] => found.effects.len() == 1 && names(0, a),
        [a, b] => found.effects.len() == 2 && ((names(0, a) && names(1, b)) || (names(0, b) && names(1, a))),
        _ => false,
    }
}

#[test]
fn every_hidden_effect_is_named_and_nothing_else() {
    let truths: Value = serde_json::from_str(&read("truth.json")).unwrap();
    let mut wrong = Vec::new();
    println!("{:9} {:8} {:44} found (aliases; rms/sd after)", "case", "mode", "truth");
    for (case, truth) in truths.as_object().unwrap() {
        let hidden: Vec<String> =
            truth["effects"].as_array().unwrap().iter().map(|e| e["regressor"].as_str().unwrap().to_string()).collect();
        let found = diagnosis(case);
        let rounding = hidden.iter().any(|name| name == ROUNDING);
        let outside = truth["mode"] == "outside" && hidden != [SEVENTH];
        let right = if rounding {
            let others: Vec<&String> = hidden.iter().filter(|name| *name != ROUNDING).collect();
            let named = |name: &String| found.effects.iter().any(|f| f.effect.regressor == *name);
            others.into_iter().all(named) && !found.effects.iter().any(|f| f.effect.regressor == ROUNDING)
        } else if outside {
            found.verdict == Verdict::Unexplained && found.effects.is_empty()
        } else {
            holds(&found, &hidden)
        };
        let sd = truth["sd"].as_f64().unwrap();
        let ratio = found.gap_after.rms.unwrap() / sd;
        let names: Vec<String> = found
            .effects
            .iter()
            .map(|f| {
                let aliases: Vec<&str> = f.aliases.iter().take(6).map(|a| a.regressor.as_str()).collect();
                format!("{} t={:.1} [{} aliases: {}]", f.effect.regressor, f.t, f.aliases.len(), aliases.join(" "))
            })
            .collect();
        println!(
            "{case:9} {:8} {:44} {} {} {} rms/sd {ratio:.3}",
            truth["mode"].as_str().unwrap(),
            hidden.join(", "),
            if right { "right" } else { "WRONG" },
            found.verdict.name(),
            names.join(" + ")
        );
        if !right {
            wrong.push(case.clone());
            for step in &found.steps {
                println!("      {step:?}");
            }
        }
        // 1 +- 3/sqrt(2 dof) of the noise's standard deviation
        let margin = 3.0 / (2.0 * found.gap_after.dof as f64).sqrt();
        if !outside && !rounding {
            assert!((ratio - 1.0).abs() < margin, "{case}: the residuals after repair are {ratio} of the noise");
        }
    }
    assert!(wrong.is_empty(), "wrong: {wrong:?}");
}
