//! The small-angle rows of Li, Ren, Zhao 2012, eqs. (4) and (10)-(13), fall out of the exact chain at zero tilts: at the paper's
//! positions, and at 270 and 90 degree ones that the paper has not. Expected rows: computer algebra (tests/scripts/li2012_rows.py).

use crate::support::*;
use serde_json::{Value, json};
use tumble::design::{self, Model};

fn assert_rows(table: &Value) {
    let id = table["bench"].as_str().expect("a bench");
    let keys: Vec<&Value> = table["rows"].as_array().expect("rows").iter().collect();
    let readings: Vec<Value> = keys
        .iter()
        .map(|entry| {
            let mut reading = (*entry).clone();
            reading.as_object_mut().expect("an object").remove("row");
            reading
        })
        .collect();
    let campaign = parse(
        &json!({ "bench": id, "known": { "kI": { "value": table["kI"] } }, "estimate": { "V0": {} }, "readings": readings })
            .to_string(),
    );
    let campaign = if campaign.bench.site.is_some() { without_earth_rate(&campaign) } else { campaign };
    let model = Model::new(&campaign).expect("a model");
    let design = design::assemble(&campaign, &model, &campaign.reference_point()).expect("rows");
    assert_eq!(design.rows.len(), keys.len());
    for (i, entry) in keys.iter().enumerate() {
        let expected = numbers(&entry["row"]);
        for (name, expected) in table["order"].as_array().expect("names").iter().zip(expected) {
            let name = name.as_str().expect("a name");
            let column = campaign.parameter_index(name).expect("a parameter");
            let found = design.jacobian[(i, column)];
            // a gain of 2.9 V/(deg/s) times 30 deg/s, rounded a few times
            assert_within(found, expected, 1e-13, &format!("{name} at {}", readings[i]));
            assert!(expected != 0.0 || found == 0.0, "{name} at {}: {found:e} is not exactly zero", readings[i]);
        }
    }
    println!("{id}: {} rows of {} derivatives", keys.len(), table["order"].as_array().map_or(0, Vec::len));
}

#[test]
fn gyro_rows() {
    assert_rows(&json("li2012/rows.json")["gyro"]);
}

#[test]
fn accelerometer_rows() {
    assert_rows(&json("li2012/rows.json")["accelerometer"]);
}
