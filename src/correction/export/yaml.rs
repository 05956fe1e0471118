//! Files of other programs: kalibr's intrinsics and the ROS package imu_calib, both in SI units of the inputs.

use super::{Origin, needs, number};
use crate::bench::STANDARD_GRAVITY_M_S2;
use crate::correction::{Calibration, Corrector, Quantity};
use crate::elements::Elements;
use crate::error::Result;

/// Rows (sensors) that measure a quantity, and its three columns; `None` where the unit does not measure all of it.
fn block(calibration: &Calibration, corrector: &Corrector, quantity: Quantity) -> Option<([usize; 3], [usize; 3])> {
    let prefix = if quantity == Quantity::Rate { "w_" } else { "a_" };
    let column = |axis: &str| calibration.solved().position(|i| i.name == format!("{prefix}{axis}"));
    let columns = [column("x")?, column("y")?, column("z")?];
    let others: Vec<usize> = (0..corrector.solved()).filter(|k| !columns.contains(k)).collect();
    let sensitivity = corrector.sensitivity();
    // accelerometers follow no rate; gyros may follow a force
    let rows: Vec<usize> = (0..calibration.lines.len())
        .filter(|i| {
            let own = columns.iter().any(|j| sensitivity[(*i, *j)] != 0.0);
            own && (quantity == Quantity::Rate || others.iter().all(|j| sensitivity[(*i, *j)] == 0.0))
        })
        .collect();
    Some((<[usize; 3]>::try_from(rows).ok()?, columns))
}

fn si(calibration: &Calibration, quantity: Quantity) -> f64 {
    // how many of the calibration's units make one SI unit
    match quantity {
        Quantity::Rate => calibration.rate_unit.per_deg_s() * 180.0 / std::f64::consts::PI,
        _ => calibration.force_unit.per_g() / STANDARD_GRAVITY_M_S2,
    }
}

fn sub(matrix: &nalgebra::DMatrix<f64>, rows: &[usize], columns: &[usize], factor: f64) -> String {
    let row = |i: &usize| {
        let cells: Vec<String> = columns.iter().map(|j| number(matrix[(*i, *j)] * factor)).collect();
        format!("  - [{}]", cells.join(", "))
    };
    rows.iter().map(row).collect::<Vec<_>>().join("\n")
}

fn head(calibration: &Calibration, origin: &Origin, what: &str) -> String {
    let mut text = format!("# {what}\n# Written by {} from {}.\n", origin.program, origin.report);
    origin.unit.iter().for_each(|line| text.push_str(&format!("# {line}\n")));
    for line in &calibration.lines {
        text.push_str(&format!("# {} ({}) = {}\n", line.sensor, line.unit, line.model));
    }
    text
}

/// kalibr's `scale-misalignment` intrinsics: readings = M w + A a + b and M a + b, inputs in rad/s and m/s^2.
pub(super) fn kalibr(calibration: &Calibration, corrector: &Corrector, origin: &Origin) -> Result<String> {
    let gyros = block(calibration, corrector, Quantity::Rate);
    let accelerometers = block(calibration, corrector, Quantity::Force);
    if gyros.is_none() && accelerometers.is_none() {
        return Err(needs("kalibr", "three gyros or three accelerometers"));
    }
    let what = "Intrinsics of an IMU for kalibr, model scale-misalignment, at zero input.";
    let mut text = head(calibration, origin, what);
    text.push_str("# M, A: readings per rad/s and per m/s^2; kalibr takes readings in rad/s and m/s^2 (M near 1). bias: reading at zero input, which kalibr estimates itself.\n");
    text.push_str("model: scale-misalignment\n");
    let m = corrector.sensitivity();
    let bias = |rows: &[usize]| rows.iter().map(|i| corrector.bias().at(*i)).map(number).collect::<Vec<_>>().join(", ");
    if let Some((rows, columns)) = &accelerometers {
        let factor = si(calibration, Quantity::Force);
        text.push_str(&format!("accelerometers:\n  M:\n{}\n  bias: [{}]\n", sub(m, rows, columns, factor), bias(rows)));
    }
    if let Some((rows, columns)) = &gyros {
        let factor = si(calibration, Quantity::Rate);
        text.push_str(&format!("gyroscopes:\n  M:\n{}\n", sub(m, rows, columns, factor)));
        match &accelerometers {
            Some((_, force)) => {
                text.push_str(&format!("  A:\n{}\n", sub(m, rows, force, si(calibration, Quantity::Force))))
            }
            None => text.push_str("  A:\n  - [0.0, 0.0, 0.0]\n  - [0.0, 0.0, 0.0]\n  - [0.0, 0.0, 0.0]\n"),
        }
        text.push_str("  C_gyro_i:\n  - [1.0, 0.0, 0.0]\n  - [0.0, 1.0, 0.0]\n  - [0.0, 0.0, 1.0]\n");
        text.push_str(&format!("  bias: [{}]\n", bias(rows)));
    }
    Ok(text)
}

/// The ROS package imu_calib: corrected = SM raw - bias, in m/s^2 (row by row).
pub(super) fn ros(calibration: &Calibration, corrector: &Corrector, origin: &Origin) -> Result<String> {
    let Some((rows, columns)) = block(calibration, corrector, Quantity::Force) else {
        return Err(needs("imu_calib", "three accelerometers"));
    };
    let factor = si(calibration, Quantity::Force);
    let sensitivity = nalgebra::Matrix3::from_iterator(
        columns
            .iter()
            .flat_map(|j| rows.map(|i| corrector.sensitivity().get((i, *j)).map_or(f64::NAN, |s| s * factor))),
    );
    let Some(inverse) = sensitivity.try_inverse() else { return Err(needs("imu_calib", "three accelerometers")) };
    let bias = nalgebra::Vector3::from_iterator(rows.iter().map(|i| corrector.bias().at(*i)));
    let offset = inverse * bias;
    let mut text = head(
        calibration,
        origin,
        "Accelerometer calibration for the ROS package imu_calib: corrected = SM*raw - bias, m/s^2.",
    );
    let cells: Vec<String> = inverse.transpose().iter().map(|cell| number(*cell)).collect();
    text.push_str(&format!(
        "SM: [{}]\nbias: [{}, {}, {}]\n",
        cells.join(", "),
        number(offset.x),
        number(offset.y),
        number(offset.z)
    ));
    Ok(text)
}
