//! The ready lines of benches about input axes (misalignment, azimuth, non-orthogonality) and about what is referred to the input, against
//! vectors: a cross product gives the misalignment with its direction, a scalar product the angle between two axes.

use crate::support::{campaign, exact, truth};
use nalgebra::{Rotation3, Vector3};
use tumble::fit::{self, Fit};

const ARCSEC: f64 = 648_000.0 / std::f64::consts::PI;

fn fitted(name: &str) -> Fit {
    fit::fit(&campaign(&format!("tests/data/simulated/{name}.campaign.json")), &exact()).expect(name)
}

/// Values of derived quantities in the units of the tables.
fn derived(found: &Fit) -> impl Fn(&str) -> f64 + use<> {
    let report = serde_json::to_value(tumble::report::fit_report(found)).expect("a report");
    move |id| {
        let all = report["derived"].as_array().expect("derived");
        let own = all.iter().find(|own| own["id"] == *id).unwrap_or_else(|| panic!("{id} is not derived"));
        own["arcsec"]["value"].as_f64().or(own["value"].as_f64()).unwrap_or_else(|| panic!("{id} has no value"))
    }
}

/// Angle (rad) between the axes, and direction (deg) of the second about the first, from `next` towards `after`.
fn turned([axis, next, after]: [Vector3<f64>; 3], seen: Vector3<f64>) -> (f64, f64) {
    let across = axis.cross(&seen);
    let azimuth = (-across.dot(&next)).atan2(across.dot(&after)).to_degrees();
    (across.norm().atan2(axis.dot(&seen)), azimuth)
}

fn near(found: f64, expected: f64, within: f64, what: &str) {
    assert!((found - expected).abs() <= within, "{what}: {found}, expected {expected}");
}

#[test]
fn a_gyro_on_the_turntable() {
    for name in ["gyro-1", "gyro-2"] {
        let truth = truth(&format!("tests/data/simulated/{name}.truth.json"));
        let value = derived(&fitted(name));
        // the chain ends about y, then about z; the input axis is x
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), truth["dtheta_y2"])
            * Rotation3::from_axis_angle(&Vector3::z_axis(), truth["dtheta_z2"]);
        let (angle, azimuth) = turned([Vector3::x(), Vector3::y(), Vector3::z()], turn * Vector3::x());
        // the line is that of small angles: its square is off by less than the square of the angle
        near(value("misalignment"), 1e6 * angle, 1e6 * angle.powi(3), name);
        near(value("azimuth"), azimuth, angle.powi(2).to_degrees(), name);
        // V0 in V, kI in V/(deg/s)
        near(value("bias"), truth["V0"] / truth["kI"] * 3600.0, 1e-9, name);
    }
}

#[test]
fn an_accelerometer_by_the_plumb_line() {
    let truth = truth("tests/data/simulated/accelerometer-1.truth.json");
    let value = derived(&fitted("accelerometer-1"));
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), truth["dtheta_y2"])
        * Rotation3::from_axis_angle(&Vector3::z_axis(), truth["dtheta_z2"]);
    let (angle, azimuth) = turned([Vector3::x(), Vector3::y(), Vector3::z()], turn * Vector3::x());
    near(value("misalignment"), 1e6 * angle, 1e6 * angle.powi(3), "misalignment");
    near(value("azimuth"), azimuth, angle.powi(2).to_degrees(), "azimuth");
    near(value("bias"), 1e6 * truth["V0"] / truth["kI"], 1e-6, "bias");
}

#[test]
fn an_accelerometer_on_the_dividing_head() {
    let truth = truth("tests/data/simulated/dividing-head.truth.json");
    let value = derived(&fitted("dividing-head"));
    for (id, over) in [
        ("bias", "K0"),
        ("nonlinearity_2", "K2"),
        ("nonlinearity_3", "K3"),
        ("cross_IP", "KIP"),
        ("misalignment_P", "KP"),
    ] {
        near(value(id), 1e6 * truth[over] / truth["K1"], 1e-6, id);
    }
}

#[test]
fn gyros_on_a_cone() {
    let truth = truth("tests/data/simulated/skew-triad.truth.json");
    let value = derived(&fitted("skew-triad"));
    let degrees = |a: f64, b: f64, c: f64| Vector3::new(a, b, c).map(|own| own.to_radians().cos());
    // angles of the input axes against the body axes, as the source of the bench gives them
    let nominal =
        [(54.735610317, 114.094842551, 45.0), (54.735610317, 114.094842551, 135.0), (54.735610317, 35.264389683, 90.0)]
            .map(|(a, b, c)| degrees(a, b, c).normalize());
    let seen =
        [1, 2, 3].map(|n| Vector3::new(truth[&format!("E{n}x")], truth[&format!("E{n}y")], truth[&format!("E{n}z")]));
    for n in 0..3 {
        let (input, k) = (nominal[n], n + 1);
        // the spin axis: in the plane of the body's x and the input axis, square to it
        let spin = (Vector3::x() - input * input.x).normalize();
        let (angle, azimuth) = turned([input, spin, input.cross(&spin)], seen[n]);
        near(value(&format!("misalignment_{k}")), 1e6 * angle.tan(), 1e-3, "misalignment");
        near(value(&format!("azimuth_{k}")), azimuth, 1e-5, "azimuth");
        near(value(&format!("scale_factor_{k}")), seen[n].norm(), 1e-9, "scale factor");
        near(value(&format!("bias_{k}")), truth[&format!("D{k}")] / seen[n].norm(), 1e-7, "bias");
    }
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let angle = seen[i].cross(&seen[j]).norm().atan2(seen[i].dot(&seen[j]));
        let id = format!("nonorthogonality_{}{}", i + 1, j + 1);
        near(value(&id), (std::f64::consts::FRAC_PI_2 - angle) * ARCSEC, 1e-5, &id);
    }
}

/// The face on which a unit stands is free against its input axes, the angles between these are not: they come out as on the table whose face
/// is known, and a quantity that turns with the face has no value.
#[test]
fn angles_between_axes_are_determined_where_the_mounting_face_is_free() {
    let path = |file: &str| format!("examples/10-imu-three-axis-table/{file}.campaign.json");
    let [free, known] =
        ["everything", "table-errors"].map(|file| fit::fit(&campaign(&path(file)), &exact()).expect(file));
    let of = |found: &Fit, id: &str| found.derived.iter().find(|own| own.id == id).cloned().expect("a ready line");
    for group in ["g", "a"] {
        for pair in ["xy", "xz", "yz"] {
            let id = format!("{group}_nonorthogonality_{pair}");
            let (free, known) = (of(&free, &id), of(&known, &id));
            let (u, v) = (free.uncertainty.expect(&id).u, known.uncertainty.expect(&id).u);
            assert!((free.value.expect(&id) - known.value.expect(&id)).abs() < 3.0 * u.hypot(v), "{id}");
        }
        for id in ["misalignment_x", "azimuth_z"].map(|own| format!("{group}_{own}")) {
            assert_eq!(of(&free, &id).value, None, "{id}");
            assert!(of(&known, &id).value.is_some(), "{id}");
        }
    }
}

#[test]
fn the_six_sensors_of_an_imu() {
    let truth = truth("tests/data/simulated/imu-table-tilted.truth.json");
    let value = derived(&fitted("imu-table-tilted"));
    for group in ["g", "a"] {
        let e = |name: &str| truth[&format!("E{group}{name}")];
        let seen = [[1.0, e("xz"), e("xy")], [e("yz"), 1.0, e("yx")], [e("zy"), e("zx"), 1.0]].map(Vector3::from);
        for (k, name) in ["x", "y", "z"].iter().enumerate() {
            let axes = [k, (k + 1) % 3, (k + 2) % 3].map(|own| Vector3::ith(own, 1.0));
            let (angle, azimuth) = turned(axes, seen[k]);
            near(value(&format!("{group}_misalignment_{name}")), 1e6 * angle.tan(), 1e-4, name);
            near(value(&format!("{group}_azimuth_{name}")), azimuth, 1e-4, name);
        }
        for (pair, i, j) in [("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)] {
            let angle = seen[i].cross(&seen[j]).norm().atan2(seen[i].dot(&seen[j]));
            let square = (std::f64::consts::FRAC_PI_2 - angle) * ARCSEC;
            near(value(&format!("{group}_nonorthogonality_{pair}")), square, 1e-4, pair);
        }
    }
}
