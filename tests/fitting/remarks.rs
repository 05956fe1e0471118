//! What was typed in another unit or twice is remarked on, and nothing that is as it should be.

use crate::support::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

fn table() -> Value {
    serde_json::from_str(include_str!("../../data/campaigns/li2012-table1.campaign.json")).expect("JSON")
}

fn remarks(campaign: &Value) -> String {
    fitted(&parse(&campaign.to_string())).remarks().iter().map(|remark| remark.to_string() + "\n").collect()
}

fn changed(key: &str, by: impl Fn(f64) -> f64) -> Value {
    let mut campaign = table();
    for row in campaign["readings"].as_array_mut().expect("readings") {
        row[key] = by(row[key].as_f64().expect("a number")).into();
    }
    campaign
}

#[test]
fn other_units_and_rows_that_stand_twice_are_seen() {
    assert_eq!(remarks(&table()), "");
    let thousand = remarks(&changed("V", |v| v * 1000.0));
    assert!(thousand.contains("not a small tilt") && thousand.contains("kI") && thousand.contains("(V)"), "{thousand}");
    let radians = remarks(&changed("gamma_deg_s", |rate| (rate.to_radians() * 1e6).round() / 1e6));
    assert!(radians.contains("gamma_deg_s") && radians.contains("rad/s"), "{radians}");
    let mut twice = table();
    let rows = twice["readings"].as_array_mut().expect("readings");
    rows.extend(rows.clone());
    assert!(remarks(&twice).contains("every row occurs 2 times"), "{}", remarks(&twice));
    // such rows show no scatter: neither is there lack of fit beside it, nor is it the noise of a diagnosis
    assert_eq!(fitted(&parse(&twice.to_string())).checks.lack_of_fit, None);
    let catalogue = tumble::wire::built_in_effects().expect("the catalogue");
    let diagnosis = tumble::diagnose(&parse(&twice.to_string()), &catalogue, &Default::default()).expect("a diagnosis");
    assert_eq!(serde_json::to_value(diagnosis.noise).expect("JSON")["from"], "residuals");
    // one row more than once is a matter of chance where readings are coarse
    twice["readings"].as_array_mut().expect("readings").pop();
    assert_eq!(remarks(&twice), "");
}

/// A run of twelve readings of a gyro, noise 25 uV, into which four rows were copied: a differing pair at one rate shows that the digits are no matter of chance (q/(2 sqrt(pi) s) = 1/90
/// for steps of 1 uV). In steps of 0.1 mV, four times the noise, it would be.
#[test]
fn rows_that_were_copied_are_seen() {
    let rates = [0, 10, -10, 50, -50, 100, -100, 200, -200, 10, -10, 0, -50, 100, -100, 200];
    let volts = [
        0.491306, 0.592574, 0.390043, 0.997641, -0.014982, 1.503918, -0.521288, 2.516546, -1.533864, 0.592558,
        0.390077, 0.491270, -0.014982, 1.503918, -0.521288, 2.516546,
    ];
    // as read, in steps of 0.1 mV as a decimal, and of 70 uV as counts that were scaled
    let rounded = |volts: f64, step: f64| match step {
        1e-6 => volts,
        1e-4 => format!("{volts:.4}").parse().unwrap(),
        _ => (volts / step).round() * step,
    };
    let said = |count: usize, step: f64| {
        let rows: Vec<serde_json::Value> = rates
            .iter()
            .zip(volts)
            .take(count)
            .map(|(rate, volts): (&i32, f64)| serde_json::json!({ "rate": rate, "V": rounded(volts, step) }))
            .collect();
        remarks(&serde_json::json!({
            "bench": { "id": "line", "chain": [], "sensors": { "V": { "unit": "V", "model": "V0 + K*rate" } } },
            "estimate": { "V0": {}, "K": {} }, "readings": rows
        }))
    };
    assert_eq!(said(12, 1e-6), "");
    assert!(said(16, 1e-6).contains("readings 13 to 16 repeat readings 5 to 8"), "{}", said(16, 1e-6));
    assert_eq!(said(16, 1e-4), "");
    assert_eq!(said(16, 0.7e-4), "");
}

/// One time of twenty that goes back by seven hours is asked for; of readings in any order, and of three runs that each begin at zero in twelve readings, none is.
#[test]
fn a_time_that_goes_back_is_seen() {
    let said = |times: &[f64]| {
        let rows: Vec<serde_json::Value> = times
            .iter()
            .enumerate()
            .map(|(k, t)| json!({ "time_h": t, "x": k * k % 7, "V": 1.0 + 0.1 * t + 1e-3 * ((k * 37 % 11) as f64) }))
            .collect();
        remarks(&json!({
            "bench": { "id": "line", "chain": [], "sensors": { "V": { "unit": "V", "model": "b + d*time_h + k*x" } } },
            "estimate": { "b": {}, "d": {}, "k": {} }, "readings": rows
        }))
    };
    let mut times: Vec<f64> = (0..20).map(|k| 0.25 * f64::from(k)).collect();
    assert_eq!(said(&times), "");
    times[9] -= 7.0;
    assert!(said(&times).contains("time_h goes back once, at reading 10 (-4.75)"), "{}", said(&times));
    let any: Vec<f64> = (0..20).map(|k| f64::from(k * 7 % 20)).collect();
    assert_eq!(said(&any), "");
    let runs: Vec<f64> = (0..12).map(|k| f64::from(k % 4)).collect();
    assert_eq!(said(&runs), "");
}

/// Readings in mV where the bench has V: an estimated scale factor is a thousand times its start.
#[test]
fn a_scale_factor_of_another_unit_is_seen() {
    let at = |factor: f64| {
        let one = |rate: f64| json!({ "gamma_deg_s": rate, "V": factor * (0.002 + 0.02004 * rate) });
        let readings: Vec<Value> = [-100.0, -50.0, -20.0, 20.0, 50.0, 100.0].map(one).to_vec();
        let k = json!({ "start": 0.02, "unit": "V/(deg/s)" });
        remarks(
            &json!({ "bench": "gyro-rate-steps", "estimate": { "V0": { "start": 1e-6 }, "K": k }, "readings": readings }),
        )
    };
    // an offset far from its start carries nothing
    assert_eq!(at(1.0), "");
    // nearer to the start than to a thousand times it
    assert_eq!(at(31.0), "");
    for factor in [1e3, 1e-3, 32.0, -1e6] {
        let found = at(factor);
        assert!(found.contains("K is ") && found.contains("readings of V are in V"), "{factor}: {found}");
    }
}

/// A column that is called as the unit is: it is named, and not taken for a schedule.
#[test]
fn a_column_named_as_the_unit_is_named() {
    let refused = |column: &str| {
        let readings = [10.0, -10.0, 20.0].map(|rate| json!({ "gamma_deg_s": rate, column: 0.02 * rate }));
        let campaign = json!({ "bench": "gyro-rate-steps", "estimate": { "K": {} }, "readings": readings });
        tumble::fit(&parse(&campaign.to_string()), &Default::default()).expect_err("no value of V").to_string()
    };
    for column in ["Volt", "v", "volts"] {
        assert!(refused(column).contains(&format!("is the column '{column}' meant for 'V'?")), "{}", refused(column));
    }
    assert!(!refused("pressure").contains("meant for"), "{}", refused("pressure"));
}

/// With the table's range no round number is needed.
#[test]
fn rates_outside_the_range_of_the_table_are_seen() {
    let text = tumble::bench::built_in("gyro-turntable").expect("a bench").text;
    let mut bench: Value = serde_json::from_str(text).expect("JSON");
    bench["rate_range_deg_s"] = json!({ "gamma": [1, 400] });
    let with = |mut campaign: Value| {
        campaign["bench"] = bench.clone();
        remarks(&campaign)
    };
    assert_eq!(with(table()), "");
    let found = with(changed("gamma_deg_s", |rate| (rate * 1.013).to_radians()));
    assert!(found.contains("1 to 400 deg/s") && found.contains("gamma_deg_s"), "{found}");
    bench["rate_range_deg_s"] = json!({ "gamma": [400, 1] });
    let mut wrong = table();
    wrong["bench"] = bench;
    let error = tumble::Campaign::from_json(&wrong.to_string()).unwrap_err();
    assert!(error.place().path.contains("rate_range_deg_s.gamma"), "{error}");
}

fn campaigns(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            campaigns(&path, found);
        } else if path.to_string_lossy().ends_with(".campaign.json") {
            found.push(path);
        }
    }
}

#[test]
fn examples_tables_and_hidden_campaigns_are_remarked_on_nowhere() {
    let mut found = Vec::new();
    for folder in ["examples", "data/campaigns", "tests/data/hidden", "tests/data/li2012"] {
        campaigns(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut found);
    }
    let mut looked_at = 0;
    for path in found {
        let text = std::fs::read_to_string(&path).expect("text");
        // those that are whole in themselves: the others refer to tables of many devices and to records
        let Ok(campaign) = tumble::Campaign::from_json(&text) else { continue };
        let Ok(fit) = tumble::fit(&campaign, &Default::default()) else { continue };
        looked_at += 1;
        let all: Vec<String> = fit.remarks().iter().map(ToString::to_string).collect();
        let new = ["small tilt", "rad/s", "every row", "times its start"];
        assert!(!all.iter().any(|text| new.iter().any(|word| text.contains(word))), "{}: {all:?}", path.display());
    }
    assert!(looked_at > 30, "{looked_at}");
}

/// The last place of numbers, counted in their shortest texts; `None` for more than 12 places or 14 digits.
fn written(values: &[f64]) -> Option<f64> {
    let places = |value: &f64| {
        let text = format!("{value}");
        let places = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let digits = text.chars().filter(char::is_ascii_digit).count();
        (places <= 12 && digits <= 14).then_some(places)
    };
    let places: Option<Vec<usize>> = values.iter().map(places).collect();
    places?.into_iter().max().map(|most| 10f64.powi(-(most as i32)))
}

#[test]
fn the_last_place_is_that_of_the_text() {
    let lists: [&[f64]; 9] = [
        &[0.0614, -0.06, 0.0],
        &[1e12, 0.001],
        &[12_345_678_901_234.0, 0.25],
        &[123_456_789_012_345.0],
        &[0.1 + 0.2],
        &[1.0 / 3.0],
        &[99.123_456_789_012, -5.0],
        &[1e-12, 1e-13],
        &[2.5e-9, 40.0],
    ];
    for list in lists {
        assert_eq!(tumble::fit::resolution(list.iter().copied()), written(list), "{list:?}");
    }
    for k in 0..2000 {
        let value = f64::from(k * k * 37 % 100_003) / [1.0, 10.0, 1e3, 1e5, 7.0][k as usize % 5];
        assert_eq!(tumble::fit::resolution([value].into_iter()), written(&[value]), "{value}");
    }
}

/// A channel that reads nothing but zero is stuck, whatever the channel beside it reads.
#[test]
fn a_channel_that_reads_zero_is_stuck() {
    let readings: Vec<Value> = (0..12)
        .map(|k: i32| {
            let (sine, cosine) = f64::from(30 * k).to_radians().sin_cos();
            json!({ "x": cosine, "y": sine, "A": 0, "B": 0.1 + cosine + 1e-3 * sine + 1e-4 * f64::from(k * k % 7) })
        })
        .collect();
    let campaign = json!({
        "bench": { "id": "pair", "sensors": { "A": { "model": "a + b*x + m*y" }, "B": { "model": "c + d*x + l*y" } } },
        "estimate": { "a": {}, "b": {}, "m": {}, "c": {}, "d": {}, "l": {} },
        "readings": readings
    });
    let fit = fitted(&parse(&campaign.to_string()));
    assert_eq!(fit.stuck(), [("A", 0.0)]);
    assert!(fit.is_rejected());
}

/// A reading that was not made is counted, and where it stands is said.
#[test]
fn a_position_without_a_reading_is_told() {
    let mut campaign = table();
    campaign["readings"][3].as_object_mut().expect("a reading").remove("V");
    let found = remarks(&campaign);
    assert!(found.contains("one reading has no value of any sensor") && found.contains("readings[3]"), "{found}");
}

/// Each position has its own sensitivity to the rate: the readings of a position scatter by it, and their mean, over both senses, has nothing of it.
#[test]
fn scatter_within_positions_that_cancels_in_their_means_is_no_agreement() {
    let says = |own: f64| {
        let reading = |k: usize| {
            let (position, x) = (k / 6, [1.0, -1.0, 2.0, -2.0, 3.0, -3.0][k % 6]);
            // residues of a square, as good as drawn
            let noise = ((k * k * 7919 + k * 104_729) % 1009) as f64 / 1009.0 * 1e-3;
            let sensitivity = 1.0 + own * ([0.3, -0.4, 0.1, 0.5, -0.2, -0.3, 0.4, 0.0, -0.5, 0.2, 0.1, -0.2][position]);
            json!({ "position": position.to_string(), "x": x, "z": position, "y": 0.2 + sensitivity * x + noise })
        };
        let campaign = json!({
            "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x + c*z" } } },
            "estimate": { "a": {}, "b": {}, "c": {} }, "readings": (0..72).map(reading).collect::<Vec<_>>()
        });
        let fit = fitted(&parse(&campaign.to_string()));
        let test = fit.checks.between_positions.as_ref().expect("positions");
        (test.p, tumble::report::fit_report(&fit).checks.verdict[0].to_string())
    };
    let (p, text) = says(0.0);
    assert!(p < 0.999 && !text.contains("smaller"), "{p} {text}");
    let (p, text) = says(0.3);
    assert!(p > 0.999 && text.contains("mean residuals of positions are smaller than the scatter"), "{p} {text}");
}

/// A tilt that these readings hardly determine (36 deg, U 119 deg) may be a small one: nothing is said of the readings' unit.
#[test]
fn a_tilt_that_may_be_small_is_not_called_steep() {
    let rows: [(u32, f64, f64, f64, f64); 18] = [
        (0, 330.0, 315.0, 20.0, -0.009712),
        (0, 330.0, 315.0, -20.0, 0.032425),
        (0, 330.0, 315.0, 37.0, -0.026989),
        (1, 60.0, 0.0, 20.0, 0.010142),
        (1, 60.0, 0.0, -20.0, 0.007579),
        (1, 60.0, 0.0, 37.0, 0.011958),
        (2, 180.0, 315.0, 20.0, 0.005756),
        (2, 180.0, 315.0, -20.0, 0.013391),
        (2, 180.0, 315.0, 37.0, 0.001413),
        (3, 330.0, 0.0, 20.0, -0.011841),
        (3, 330.0, 0.0, -20.0, 0.032311),
        (3, 330.0, 0.0, 37.0, -0.029571),
        (4, 60.0, 0.0, 20.0, 0.011764),
        (4, 60.0, 0.0, -20.0, 0.008577),
        (4, 60.0, 0.0, 37.0, 0.012257),
        (5, 0.0, 315.0, 20.0, -0.004238),
        (5, 0.0, 315.0, -20.0, 0.024426),
        (5, 0.0, 315.0, 37.0, -0.015504),
    ];
    let row = |(position, alpha, beta, gamma, value): (u32, f64, f64, f64, f64)| json!({ "position": position.to_string(), "alpha_deg": alpha, "beta_deg": beta, "gamma_deg_s": gamma, "V": value });
    let mut campaign: Value = serde_json::from_str(r#"{"bench": "gyro-turntable", "estimate": {"V0": {}, "dtheta_x0": {}, "dtheta_y0": {}, "dtheta_y1": {}, "dtheta_y2": {}, "dtheta_z2": {}}, "known": {"kI": {"value": -2.9222, "unit": "V/(deg/s)", "u": 0}}, "constraints": [{"norm_of": ["dtheta_y2", "dtheta_z2"], "at_most": 56.649836263936784, "unit": "arcsec"}]}"#).expect("JSON");
    campaign["readings"] = rows.into_iter().map(row).collect();
    assert_eq!(remarks(&campaign).matches("not a small tilt").count(), 0);
}

/// A gyro in a chamber whose noise is not stated: five temperatures, ten rates at each. What goes with the temperature beyond the bench's model, or with its square times the rate, is said;
/// where there is nothing, all tests of the pattern of the residuals together reject as seldom as the level allows.
#[test]
fn residuals_that_follow_a_column_are_said() {
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
    let rates = [10.0, -10.0, 30.0, -30.0, 60.0, -60.0, 100.0, -100.0, 150.0, -150.0];
    let checks = |cubic: f64, quadratic: f64, seed: u64| {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut rows = Vec::new();
        for rate in rates {
            for temperature in [-20.0, 0.0, 25.0, 40.0, 60.0] {
                let dt: f64 = temperature - 25.0;
                let noise: f64 = StandardNormal.sample(&mut random);
                let v = 0.01
                    + 2e-5 * dt
                    + 1e-7 * dt * dt
                    + cubic * dt.powi(3)
                    + (0.02 + 1e-6 * dt + quadratic * dt * dt) * rate;
                rows.push(json!({ "gamma_deg_s": rate, "temperature_c": temperature, "V": v + 1e-5 * noise }));
            }
        }
        let campaign = json!({ "bench": "gyro-temperature", "estimate": { "V0": {}, "V1": {}, "V2": {}, "K": {}, "K1": {} }, "readings": rows });
        fitted(&parse(&campaign.to_string())).checks
    };
    let followed = |cubic: f64, quadratic: f64, seed: u64| -> Vec<String> {
        checks(cubic, quadratic, seed).follows.iter().map(|found| found.column.clone()).collect()
    };
    for seed in 0..5 {
        // a cube of 40 K of 13 standard deviations of a reading; a square times 100 deg/s of 32
        assert_eq!(followed(2e-9, 0.0, seed), ["temperature_c"], "{seed}");
        assert_eq!(followed(0.0, 2e-9, seed), ["temperature_c"], "{seed}");
    }
    let rejects = |seed: u64| {
        let found = checks(0.0, 0.0, seed);
        let p = found.runs.iter().map(|(_, test)| test.p).chain(found.normality.map(|test| test.p));
        let lack = [found.lack_of_fit, found.between_positions].into_iter().flatten().any(|test| test.rejected);
        lack || !found.follows.is_empty() || p.fold(1.0, f64::min) < found.significance
    };
    let false_alarms = (0..200).filter(|seed| rejects(*seed)).count();
    // at most 5 %: 10 of 200, and three standard deviations of that
    assert!(false_alarms < 10 + 3 * 3, "{false_alarms} of 200");
}
