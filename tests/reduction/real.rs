//! Real records through the program: from the log to the calibration, beside published values.

use crate::support::*;
use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

fn tumble(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::cargo_bin("tumble").expect("the program").current_dir(folder).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

/// Reduce a record for a schedule and fit the campaign; both reports.
fn calibrated(folder: &Path, log: &str, more: &[&str]) -> (Value, Value) {
    let scratch = tempfile::tempdir().expect("a folder");
    let to = scratch.path().join("reduced.campaign.json");
    let report = scratch.path().join("reduce.json");
    let (to, report) = (to.to_str().expect("a path"), report.to_str().expect("a path"));
    let mut arguments = vec!["reduce", log, "--for", "accelerometer.schedule.json", "--to", to, "--json", report];
    arguments.extend(more);
    let (code, _, stderr) = tumble(folder, &arguments);
    assert_eq!(code, 0, "{stderr}");
    let (_, fit, stderr) = tumble(folder, &["fit", to, "--json", "-"]);
    let value = |text: &str| serde_json::from_str::<Value>(text).unwrap_or_else(|error| panic!("{error}: {stderr}"));
    (value(&std::fs::read_to_string(report).expect("a report")), value(&fit))
}

/// Value and standard uncertainty of a parameter.
fn parameter(fit: &Value, id: &str) -> (f64, f64) {
    let all = fit["parameters"].as_array().expect("parameters");
    let one = all.iter().find(|p| p["id"] == id).unwrap_or_else(|| panic!("no {id}"));
    (number(&one["value"]), number(&one["u"]))
}

/// The gyroscope half: imucal's closed forms K_g R_g, K_ga and b_g to rounding, least squares beside them.
#[test]
fn ferraris_gyroscope() {
    let folder = example("17-ferraris-session");
    let (code, out, error) = tumble(&folder, &["compare", "gyroscope.campaign.json", "--json", "-"]);
    assert_eq!(code, 0, "{error}");
    let report: Value = serde_json::from_str(&out).expect("a report");
    let (_, out, _) = tumble(&folder, &["fit", "gyroscope.campaign.json", "--json", "-"]);
    let fit: Value = serde_json::from_str(&out).expect("a report");
    let scales = [16.67769558952488, 16.187895200550262, 16.253362639451936];
    let rotation = [
        [-0.9999143756542296, -0.0006142300632876558, 0.013071498821540703],
        [0.0055057030733027396, -0.9992594967426224, -0.03808077472097593],
        [-0.01314650914177706, 0.0365074524847183, -0.9992469040284595],
    ];
    let by_force = [
        [0.0022926499308660976, -0.016134632407810497, 0.018465435717563698],
        [0.013873705024757028, 0.005443610335094903, -0.008812480865044459],
        [-0.00925910567448679, 0.008506306471459087, -0.003935382156556474],
    ];
    let offsets = [1.960686204431737, -4.472837741243746, -3.6511794138670477];
    // numpy, every mean alike: tests/scripts/ferraris_gyroscope.py
    let least_squares = [1.9693535979195542, -4.466244212807449, -3.6509707222004772];
    let closed_form = |id: &str| {
        let all = report["groups"][0]["quantities"].as_array().expect("quantities");
        number(&all.iter().find(|q| q["id"] == id).unwrap_or_else(|| panic!("no {id}"))["closed_form"])
    };
    for (i, row) in ["x", "y", "z"].into_iter().enumerate() {
        for (j, column) in ["x", "y", "z"].into_iter().enumerate() {
            // the specific force of the turns stands in the campaign with twelve decimals
            let id = format!("m_{row}{column}");
            let expected = scales[i] * rotation[i][j];
            assert!((closed_form(&id) - expected).abs() < 1e-9, "{id}: {} {expected}", closed_form(&id));
            let (value, u) = parameter(&fit, &id);
            assert!((value - expected).abs() < 0.05 * u && u < 0.35, "{id}: {value} {u}");
            let id = format!("k_{row}{column}");
            assert!((closed_form(&id) - by_force[i][j]).abs() < 1e-12, "{id}");
        }
        let id = format!("b_{row}");
        assert!((closed_form(&id) - offsets[i]).abs() < 1e-9, "{id}");
        let (value, u) = parameter(&fit, &id);
        // positions that were held less still weigh less here: the estimate moves within its uncertainty
        assert!((value - least_squares[i]).abs() < u && u < 0.1, "{id}: {value} {u}");
        assert!((value - offsets[i]).abs() < 2.0 * u, "{id}: {value} {u}");
    }
}

/// 38 positions from the raw record; chi-square as the means' uncertainties foretell it; the calibration of two other programs.
#[test]
fn xsens_from_the_log() {
    let (reduced, fit) = calibrated(&example("15-xsens-from-the-log"), "xsens.csv.gz", &[]);
    let segments = reduced["segments"].as_array().expect("segments");
    let ratio = number(&fit["fit"]["chi_square"]) / number(&fit["fit"]["dof"]);
    println!("{} segments, chi-square/dof {ratio:.3}", segments.len());
    for column in 0..3 {
        let mean =
            |key: &str| segments.iter().map(|s| number(&s["means"][column][key])).sum::<f64>() / segments.len() as f64;
        println!(
            "{}: u {:.3}, white {:.3}, autocorrelation {:.3}, Allan {:.3}",
            segments[0]["means"][column]["column"],
            mean("u"),
            mean("u_white"),
            mean("u_autocorrelation"),
            mean("u_allan_floor")
        );
    }
    // counts/(m/s^2) and counts of the independent fit of the 38 means (scipy)
    for (id, expected, u) in [
        ("s_x", 1.0 / 414.42150746381276, 0.027 / 414.4 / 414.4),
        ("s_y", 1.0 / 412.0315694796456, 0.014 / 412.0 / 412.0),
        ("s_z", 1.0 / 414.62013497959765, 0.016 / 414.6 / 414.6),
        ("b_x", 33123.83285524601, 0.245),
        ("b_y", 33275.15734142898, 0.138),
        ("b_z", 32364.495433058903, 0.15),
        ("mis_yz", 0.0033907352501340695, 0.000134),
        ("mis_zy", -0.009199058800369154, 0.000477),
        ("mis_zx", 0.021364906764877355, 0.00012),
    ] {
        let (value, own) = parameter(&fit, id);
        println!(
            "{id}: {value:.9} u {own:.2e}; expected {expected:.9} u {u:.2e}: {:.2} u",
            (value - expected) / own.hypot(u)
        );
        assert!((value - expected).abs() < 2.0 * own.hypot(u), "{id}");
    }
    assert_eq!(segments.len(), 38);
    assert!((0.7..=1.6).contains(&ratio), "{ratio}");
}

/// Each of the nine published parameters of each device within two standard uncertainties.
#[test]
fn three_mpu_9150() {
    let folder = example("16-mpu-9150");
    let expected = json("mpu9150.json");
    for device in expected.as_array().expect("devices") {
        let name = device["device"].as_str().expect("a name");
        let more = ["--rate", "100", "--columns", "ax=c1,ay=c2,az=c3"];
        let (reduced, fit) = calibrated(&folder, &format!("{name}.log.gz"), &more);
        let segments = reduced["segments"].as_array().expect("segments").len();
        let ratio = number(&fit["fit"]["chi_square"]) / number(&fit["fit"]["dof"]);
        println!("{name}: {segments} segments ({} positions), chi-square/dof {ratio:.3}", device["positions"]);
        let published = numbers(&device["published"]);
        for (k, id) in ["s_x", "s_y", "s_z", "m_yz", "m_xy", "m_xz", "b_x", "b_y", "b_z"].into_iter().enumerate() {
            let factor = if k < 3 {
                100.0
            } else if k < 6 {
                180.0 / std::f64::consts::PI
            } else {
                1.0
            };
            let (value, u) = parameter(&fit, id);
            let (value, u) = (value * factor, u * factor);
            println!(
                "  {id}: {value:8.4} u {u:.4}, published {:7.3}: {:5.2} u",
                published[k],
                (value - published[k]) / u
            );
            assert!((value - published[k]).abs() < 2.0 * u, "{name} {id}");
        }
    }
}

/// The closed forms of Ferraris as imucal computes them, least squares beside them, and what the hand scatters.
#[test]
fn ferraris_session() {
    let folder = example("17-ferraris-session");
    let (code, out, error) = tumble(&folder, &["compare", "accelerometer.campaign.json", "--json", "-"]);
    assert_eq!(code, 0, "{error}");
    let report: Value = serde_json::from_str(&out).expect("a report");
    let (_, out, _) = tumble(&folder, &["fit", "accelerometer.campaign.json", "--json", "-"]);
    let fit: Value = serde_json::from_str(&out).expect("a report");
    // imucal's example calibration: K_a R_a and b_a; offsets by least squares and residual standard deviations by numpy from the 18 means
    let scales = [208.54567263762615, 208.0011341167055, 214.78455364603022];
    let rotation = [
        [0.9999125214309234, 0.007122056140390757, -0.011145662922687352],
        [-0.007947378455060604, 0.9996887358297629, 0.023648903373787954],
        [0.021342900724016442, -0.010781879507682177, 0.9997140749549175],
    ];
    let closed = [-6.018868019671572, -48.287874016760156, -28.96636637224333];
    let least_squares = [-7.87391974, -55.94324755, -31.03089317];
    let closed_form = |id: &str| {
        let all = report["groups"][0]["quantities"].as_array().expect("quantities");
        let one = all.iter().find(|q| q["id"] == id).unwrap_or_else(|| panic!("no {id}"));
        number(&one["closed_form"])
    };
    for (i, row) in ["x", "y", "z"].into_iter().enumerate() {
        for (j, column) in ["x", "y", "z"].into_iter().enumerate() {
            let id = format!("m_{row}{column}");
            let expected = scales[i] * rotation[i][j];
            assert!((closed_form(&id) - expected).abs() < 1e-9, "{id}");
            let (value, u) = parameter(&fit, &id);
            assert!((value - expected).abs() < 0.05 * u, "{id}");
        }
        let id = format!("b_{row}");
        assert!((closed_form(&id) - closed[i]).abs() < 1e-9, "{id}");
        let (value, u) = parameter(&fit, &id);
        assert!(
            (value - least_squares[i]).abs() < 0.05 * u && (value - closed[i]).abs() < 2.0 * u,
            "{id}: {value} {u}"
        );
    }
    let lines = fit["scatter"].as_array().expect("lines");
    for (axis, sd) in [("b_x", 5.0), ("b_y", 21.0), ("b_z", 2.9)] {
        let line = lines.iter().find(|line| line["of"] == axis).expect(axis);
        assert!((number(&line["sd"]) / sd - 1.0).abs() < 0.1, "{line}");
    }
}

/// The uncertainty of a norm follows the scale factors, which at the start may be any: it is that of the solution.
#[test]
fn a_norm_has_the_same_uncertainty_from_any_start() {
    let folder = tempfile::tempdir().expect("a folder");
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/15-xsens-from-the-log");
    std::fs::copy(example.join("xsens.csv.gz"), folder.path().join("xsens.csv.gz")).expect("a copy");
    let text = std::fs::read_to_string(example.join("accelerometer.campaign.json")).expect("a campaign");
    let campaign: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let found: Vec<Vec<(f64, f64)>> = [1.0, 0.7]
        .map(|share| {
            let mut own = campaign.clone();
            for id in ["s_x", "s_y", "s_z"] {
                let start = own["estimate"][id]["start"].as_f64().expect("a start");
                own["estimate"][id]["start"] = (share * start).into();
            }
            let path = folder.path().join("c.campaign.json");
            std::fs::write(&path, own.to_string()).expect("a campaign");
            let campaign = tumble::Campaign::from_path(&path).expect("a campaign");
            let fit = tumble::fit(&campaign, &Default::default()).expect("a fit");
            fit.parameters
                .iter()
                .map(|own| (own.value.expect("a value"), own.uncertainty.as_ref().expect("u").u))
                .collect()
        })
        .into();
    for ((a, u), (b, v)) in found[0].iter().zip(&found[1]) {
        assert!((a - b).abs() < 1e-6 * u && (u / v - 1.0).abs() < 1e-6, "{a} {u}, {b} {v}");
    }
}
