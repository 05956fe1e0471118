//! The chain of rotations: exact quarter turns, rates and forces and their derivatives, means over turns.

use crate::support::parse;
use nalgebra::Rotation3;
use serde_json::{Map, Value, json};
use tumble::algebra::Scratch;
use tumble::bench::{Bench, Link, built_in, sin_cos_deg};
use tumble::campaign::JointState;
use tumble::design::{self, Instant, Kinematics, Model, kinematics};
use tumble::wire;

#[test]
fn quarter_turns_are_exact_and_others_agree_with_the_library() {
    for k in -8..=8 {
        let (sin, cos) = sin_cos_deg(90.0 * f64::from(k));
        assert!(sin == 0.0 || sin.abs() == 1.0);
        assert_eq!(sin * sin + cos * cos, 1.0);
    }
    for k in -721..721 {
        let angle = f64::from(k) * 0.77;
        let (sin, cos) = sin_cos_deg(angle);
        // two correct roundings of the same number differ by at most the reduction error of the radian argument
        assert!((sin - angle.to_radians().sin()).abs() < 4e-15 && (cos - angle.to_radians().cos()).abs() < 4e-15);
    }
}

/// A chain with tilts that follow the joints.
const CHAIN: &str = "imu-three-axis-table";

fn bench() -> Bench {
    let text = built_in(CHAIN).map(|own| own.text).unwrap_or_default();
    wire::read_bench(&wire::Source { name: CHAIN.into(), text: text.into() }).unwrap()
}

/// Derivatives by the joints' angles, turning joints and tilts that follow the angles included, against central differences.
#[test]
fn derivatives_by_joints_are_differences() {
    let bench = bench();
    let instant = Instant { angle_deg: vec![37.0, -122.0, 200.0], rate_deg_s: vec![0.0, 15.0, -3.0] };
    let tilts: Vec<f64> = (0..bench.tilts().count()).map(|k| 1e-2 * (k as f64 - 4.0)).collect();
    let mut found = Kinematics::default();
    found.wants_joints = true;
    kinematics(&bench, &tilts, &instant, &mut found);
    for joint in 0..3 {
        let h = 1e-3_f64;
        let at = |step: f64| {
            let mut moved = instant.clone();
            moved.angle_deg[joint] += step;
            let mut out = Kinematics::default();
            kinematics(&bench, &tilts, &moved, &mut out);
            (out.rate, out.force)
        };
        let ((rate_up, force_up), (rate_down, force_down)) = (at(h), at(-h));
        let step = 2.0 * h.to_radians();
        // h^2 of the third derivative (1.7e-5 rad squared), and eps/h of rounding in rates of 15
        assert!((found.rate_by_joint[joint] - (rate_up - rate_down) / step).norm() < 1e-8, "{joint}");
        assert!((found.force_by_joint[joint] - (force_up - force_down) / step).norm() < 1e-8, "{joint}");
    }
}

/// Every rotation as a matrix, and derivatives by central differences: nothing shared with what is tested but the chain.
#[test]
fn rate_force_and_derivatives_are_those_of_rotation_matrices() {
    let bench = bench();
    let instant = Instant { angle_deg: vec![37.0, -122.0, 200.0], rate_deg_s: vec![0.0, 15.0, -3.0] };
    let by_matrices = |tilts: &[f64]| {
        let (mut rate, mut force) = (bench.earth_rate(), bench.specific_force());
        let (mut joint, mut tilt) = (0, 0);
        for link in &bench.chain {
            let (Link::Joint { about, .. } | Link::Tilt { about, .. }) = link;
            let (angle, turning) = match link {
                Link::Joint { .. } => {
                    joint += 1;
                    (instant.angle_deg[joint - 1].to_radians(), instant.rate_deg_s[joint - 1])
                }
                Link::Tilt { times, .. } => {
                    tilt += 1;
                    // factors follow the encoder, from 0 to 360 degrees
                    let angles: Vec<f64> = instant.angle_deg.iter().map(|a| a.rem_euclid(360.0).to_radians()).collect();
                    let factor = times.as_ref().map_or(1.0, |t| t.factor(&angles, &mut Scratch::default()));
                    (factor * tilts[tilt - 1], 0.0)
                }
            };
            let back = Rotation3::new(about.unit() * angle).inverse();
            (rate, force) = (back * rate + about.unit() * turning, back * force);
        }
        (rate, force)
    };
    let tilts: Vec<f64> =
        (0..bench.tilts().count()).map(|k| if k == 3 { 0.0 } else { 1e-2 * (k as f64 - 4.0) }).collect();
    let mut found = Kinematics::default();
    for _ in 0..2 {
        // the second time from what it remembers
        kinematics(&bench, &tilts, &instant, &mut found);
        let (rate, force) = by_matrices(&tilts);
        assert!((found.rate - rate).norm() < 1e-13 && (found.force - force).norm() < 1e-14);
        for k in 0..tilts.len() {
            let h = 1e-5;
            let at = |step: f64| {
                let mut moved = tilts.clone();
                moved[k] += step;
                by_matrices(&moved)
            };
            let ((rate_up, force_up), (rate_down, force_down)) = (at(h), at(-h));
            // h^2 of the third derivative (cubed factors of up to 3.5), and eps/h of rounding
            assert!((found.rate_by_tilt[k] - (rate_up - rate_down) / (2.0 * h)).norm() < 1e-7, "{k}");
            assert!((found.force_by_tilt[k] - (force_up - force_down) / (2.0 * h)).norm() < 1e-8, "{k}");
        }
    }
}

/// Readings over whole and part turns of each joint are computed at four instants at a time: the sum of the numbers of each instant by itself.
#[test]
fn means_over_turns_are_sums_of_instants() {
    let mut own: Value = serde_json::from_str(built_in(CHAIN).map(|own| own.text).unwrap_or_default()).unwrap();
    let sensors: Map<String, Value> = ["a_x", "a_y", "a_z", "w_x", "w_y", "w_z"]
        .iter()
        .map(|input| (format!("of_{input}"), json!({ "model": format!("b + {input}") })))
        .collect();
    let names: Vec<String> = bench().tilts().map(str::to_string).collect();
    let keys = own.as_object_mut().unwrap();
    keys.retain(|key, _| ["id", "site", "units", "chain"].contains(&key.as_str()));
    keys.insert("sensors".into(), sensors.into());
    let estimate: Map<String, Value> = names.iter().map(|name| (name.clone(), json!({}))).collect();
    let joints = ["outer", "middle", "inner"];
    let mut readings = Vec::new();
    for turning in 0..3 {
        for part in [None, Some(0.3), Some(2.7)] {
            let mut row = json!({ "of_w_x": 0 });
            for (k, joint) in joints.iter().enumerate() {
                if k != turning || part.is_some() {
                    row[format!("{joint}_deg")] = json!([37.0, -122.0, 200.0][k]);
                }
            }
            row[format!("{}_deg_s", joints[turning])] = json!([15.0, -3.0, 40.0][turning]);
            if let Some(turns) = part {
                row[format!("{}_turns", joints[turning])] = json!(turns);
            }
            readings.push(row);
        }
    }
    let question =
        json!({ "bench": own, "known": { "b": { "value": 0.5 } }, "estimate": estimate, "readings": readings });
    let campaign = parse(&question.to_string());
    let model = Model::new(&campaign).unwrap();
    let tilts: Vec<f64> = (0..names.len()).map(|k| if k == 3 { 0.0 } else { 1e-2 * (k as f64 - 4.0) }).collect();
    let mut point = campaign.reference_point();
    for (name, tilt) in names.iter().zip(&tilts) {
        point[campaign.parameter_index(name).unwrap()] = *tilt;
    }
    let (mut work, mut instants) = (model.workspace(), 0);
    for (r, reading) in campaign.readings.rows.iter().enumerate() {
        assert!(
            reading
                .joints
                .iter()
                .any(|joint| matches!(joint, JointState::WholeTurns { .. } | JointState::PartTurns { .. })),
            "{r}"
        );
        for s in 0..6 {
            let smoothness = model.sensor(s).unwrap().smoothness_for(&reading.joints);
            let (mut mean, mut slopes) = (0.5, vec![0.0; tilts.len()]);
            for node in design::nodes(reading, smoothness) {
                let mut at = Kinematics::default();
                kinematics(&campaign.bench, &tilts, &node.instant, &mut at);
                let (input, by) = if s < 3 { (at.force, &at.force_by_tilt) } else { (at.rate, &at.rate_by_tilt) };
                mean += node.weight * input[s % 3];
                slopes.iter_mut().zip(by).for_each(|(sum, by)| *sum += node.weight * by[s % 3]);
                instants += 1;
            }
            let mut gradient = vec![0.0; point.len()];
            let value = model.predict(&campaign, r, s, &point, &mut gradient, &mut work).unwrap();
            // rounding of sums of up to some hundred terms of 40
            assert!((value - mean).abs() < 1e-12, "reading {r}, sensor {s}: {value} for {mean}");
            for (name, expected) in names.iter().zip(&slopes) {
                let found = gradient[campaign.parameter_index(name).unwrap()];
                assert!((found - expected).abs() < 1e-11, "reading {r}, sensor {s}, {name}: {found} for {expected}");
            }
        }
    }
    assert!(instants > 500, "{instants}");
}
