//! Noiseless readings of an independent exact simulator (tests/scripts/exact_simulator.py, 50 digits): `exact` recovers the truth.

use crate::support::*;

/// Every fixture of the folder that has a full rank (tests/rank_defect.rs has the other).
fn names() -> Vec<String> {
    let mut files: Vec<String> = std::fs::read_dir(data("simulated"))
        .expect("the folder")
        .filter_map(|entry| Some(entry.ok()?.file_name().to_str()?.strip_suffix(".truth.json")?.to_string()))
        .filter(|name| name != "accelerometer-rank-defect")
        .collect();
    files.sort();
    assert!(files.len() >= 18, "fixtures are missing: {files:?}");
    files
}

#[test]
fn exact_fits_recover_the_truth() {
    println!("{:30} {:>8} {:>8} {:>5} worst error / max(|truth|, 1e-3)", "campaign", "unknowns", "readings", "steps");
    for name in names() {
        let truth = json(&format!("simulated/{name}.truth.json"));
        let campaign = campaign(&format!("simulated/{name}.campaign.json"));
        let fit = exact(&campaign);
        let record = fit.convergence.as_ref().expect("a record");
        assert!(record.converged, "{name} did not converge: {record:?}");
        let estimated = truth["estimated"].as_array().expect("names");
        let rank = truth["rank_at_start"].as_u64().unwrap_or(estimated.len() as u64);
        assert_eq!(fit.estimate.unknowns.rank as u64, rank, "{name}");
        let mut worst: f64 = 0.0;
        for id in estimated {
            let id = id.as_str().expect("a name");
            let exact = number(&truth["truth"][id]);
            let error = (value(&fit, id) - exact).abs() / exact.abs().max(1e-3);
            assert!(error < 1e-9, "{name}: {id} is {:e}, truth {exact:e}", value(&fit, id));
            worst = worst.max(error);
        }
        println!(
            "{name:30} {:8} {:8} {:5} {worst:.1e}",
            campaign.unknowns(),
            campaign.readings.rows.len(),
            record.iterations.len()
        );
    }
}

/// The linear estimator is one step from the reference point; the script's own first step is the same.
#[test]
fn linear_fits_take_the_scripts_first_step() {
    let mut compared = 0;
    for name in names() {
        let truth = json(&format!("simulated/{name}.truth.json"));
        let Some(step) = truth["linear_step"].as_object() else { continue };
        let fit = linear(&campaign(&format!("simulated/{name}.campaign.json")));
        for (id, expected) in step {
            let expected = number(expected);
            // printed by the script with 11 digits
            assert_within(value(&fit, id), expected, 2e-10 * expected.abs().max(1e-3), &format!("{name}: {id}"));
            compared += 1;
        }
    }
    println!("{compared} values");
    assert!(compared > 50);
}
