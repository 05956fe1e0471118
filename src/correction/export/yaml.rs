//! Files of other programs: kalibr's IMU file and the ROS package imu_calib, both in SI units of the inputs, both by axis.

use super::{Origin, needs, number, one_line, origin_lines};
use crate::bench::STANDARD_GRAVITY_M_S2;
use crate::correction::{Calibration, Corrector, Quantity, linearity};
use crate::elements::Elements;
use crate::error::Result;
use nalgebra::DMatrix;

/// The sensors that measure x, y and z of a quantity, and the columns of these; `None` where the unit does not measure all of it.
fn block(calibration: &Calibration, corrector: &Corrector, quantity: Quantity) -> Option<([usize; 3], [usize; 3])> {
    let prefix = if quantity == Quantity::Rate { "w_" } else { "a_" };
    let column = |axis: &str| calibration.solved().position(|i| i.name == format!("{prefix}{axis}"));
    let columns = [column("x")?, column("y")?, column("z")?];
    let others: Vec<usize> = (0..corrector.solved()).filter(|k| !columns.contains(k)).collect();
    let sensitivity = corrector.sensitivity();
    // accelerometers follow no rate; gyros may follow a force
    let rows: Vec<usize> = (0..calibration.lines.len())
        .filter(|i| {
            let reads = columns.iter().any(|j| sensitivity[(*i, *j)] != 0.0);
            reads && (quantity == Quantity::Rate || others.iter().all(|j| sensitivity[(*i, *j)] == 0.0))
        })
        .collect();
    let [a, b, c] = <[usize; 3]>::try_from(rows).ok()?;
    // each sensor to the axis that it follows: the order in which they follow their axes most, together
    let share = |row: usize, column: usize| {
        let size = columns.iter().map(|j| sensitivity[(row, *j)].powi(2)).sum::<f64>().sqrt();
        sensitivity[(row, column)].abs() / size
    };
    let follows = |rows: &[usize; 3]| rows.iter().zip(columns).map(|(row, column)| share(*row, column)).sum::<f64>();
    let orders = [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]];
    let rows = orders.into_iter().max_by(|one, other| follows(one).total_cmp(&follows(other)))?;
    Some((rows, columns))
}

fn si(calibration: &Calibration, quantity: Quantity) -> f64 {
    // how many of the calibration's units make one SI unit
    match quantity {
        Quantity::Rate => calibration.rate_unit.per_deg_s() * 180.0 / std::f64::consts::PI,
        _ => calibration.force_unit.per_g() / STANDARD_GRAVITY_M_S2,
    }
}

fn block_of(name: &str, matrix: &DMatrix<f64>) -> String {
    let row = |row: usize| {
        let cells: Vec<String> = matrix.row(row).iter().map(|cell| number(*cell)).collect();
        format!("  - [{}]\n", cells.join(", "))
    };
    format!("  {name}:\n{}", (0..matrix.nrows()).map(row).collect::<String>())
}

/// What stands at the top, as comments: where it comes from, the lines, what of them these files cannot hold.
fn head(calibration: &Calibration, corrector: &Corrector, origin: &Origin, what: &[&str]) -> String {
    let mut lines: Vec<String> = what.iter().map(|line| (*line).to_string()).collect();
    lines.extend(origin_lines(origin));
    lines.extend(calibration.lines.iter().map(|line| format!("{} ({}) = {}", line.sensor, line.unit, line.model)));
    let linearity = linearity(calibration, corrector);
    for ((input, error), range) in calibration.solved().zip(&linearity.linear_error).zip(&linearity.range) {
        if *error > 1e-12 * range {
            let unit = &input.unit;
            lines.push(format!(
                "Quadratic and higher terms are left out: {} is wrong by up to {error:.2e} {unit} within {range} {unit}.",
                input.name
            ));
        }
    }
    let given = calibration.inputs.iter().filter(|input| !input.solved);
    lines.extend(given.map(|input| format!("At {} = {} {}.", input.name, input.fallback(), input.unit)));
    lines.iter().map(|line| format!("# {}\n", one_line(line).trim_end())).collect()
}

fn sensors(calibration: &Calibration, rows: &[usize; 3]) -> String {
    let names = rows.map(|row| calibration.lines.get(row).map_or("", |line| line.sensor.as_str()));
    one_line(&format!("# x, y, z: {}\n", names.join(", "))).trim_end().to_string() + "\n"
}

/// kalibr's IMU file: what it reads (topic, rate, noise), then its `scale-misalignment` intrinsics, readings = M w + A a + b and M a + b,
/// inputs in rad/s and m/s^2.
pub(super) fn kalibr(calibration: &Calibration, corrector: &Corrector, origin: &Origin) -> Result<String> {
    let gyros = block(calibration, corrector, Quantity::Rate);
    let accelerometers = block(calibration, corrector, Quantity::Force);
    if gyros.is_none() && accelerometers.is_none() {
        return Err(needs("kalibr", "three gyros or three accelerometers", calibration));
    }
    let what = [
        "IMU file of kalibr. kalibr reads the topic, the update rate and the noise; it estimates intrinsics itself",
        "(--imu-models scale-misalignment): M, A and bias below are for reference, at zero input.",
        "M, A: readings per rad/s and per m/s^2; kalibr takes readings in rad/s and m/s^2 (M near 1). bias: reading at zero input.",
    ];
    let mut text = head(calibration, corrector, origin, &what);
    match &origin.noise {
        Some(noise) => text.push_str(noise.trim_end()),
        None => text.push_str(
            "rostopic: /imu0\n# update_rate, accelerometer_noise_density, accelerometer_random_walk, gyroscope_noise_density and gyroscope_random_walk are\n\
             # not known here: tumble noise LOG --json noise.json, then --noise noise.json",
        ),
    }
    text.push_str("\n\nmodel: scale-misalignment\n");
    let m = corrector.sensitivity();
    let bias = |rows: &[usize]| rows.iter().map(|i| corrector.bias().at(*i)).map(number).collect::<Vec<_>>().join(", ");
    let part = |rows: &[usize; 3], columns: &[usize; 3], quantity: Quantity| {
        let cells = rows.iter().flat_map(|i| columns.iter().map(move |j| m[(*i, *j)] * si(calibration, quantity)));
        DMatrix::from_row_iterator(3, 3, cells)
    };
    if let Some((rows, columns)) = &accelerometers {
        let m = block_of("M", &part(rows, columns, Quantity::Force));
        text += &format!("{}accelerometers:\n{m}  bias: [{}]\n", sensors(calibration, rows), bias(rows));
    }
    if let Some((rows, columns)) = &gyros {
        // by every force of the lines, whether accelerometers of this unit measure it or not
        let by_force = corrector.by_force();
        let a = DMatrix::from_fn(3, 3, |i, j| {
            let slope = rows.get(i).and_then(|row| by_force.get(*row)).map_or(f64::NAN, |slope| slope[j]); // a row for each sensor
            slope * si(calibration, Quantity::Force)
        });
        text += &format!("{}gyroscopes:\n", sensors(calibration, rows));
        text += &block_of("M", &part(rows, columns, Quantity::Rate));
        text += &block_of("A", &a);
        text += &block_of("C_gyro_i", &DMatrix::identity(3, 3));
        text += &format!("  bias: [{}]\n", bias(rows));
    }
    Ok(text)
}

/// The ROS package imu_calib: corrected = SM raw - bias, in m/s^2 (row by row).
pub(super) fn ros(calibration: &Calibration, corrector: &Corrector, origin: &Origin) -> Result<String> {
    let Some((rows, columns)) = block(calibration, corrector, Quantity::Force) else {
        return Err(needs("imu_calib", "three accelerometers", calibration));
    };
    let factor = si(calibration, Quantity::Force);
    let sensitivity = nalgebra::Matrix3::from_fn(|i, j| match (rows.get(i), columns.get(j)) {
        (Some(i), Some(j)) => corrector.sensitivity()[(*i, *j)] * factor,
        _ => f64::NAN,
    });
    let Some(inverse) = sensitivity.try_inverse() else {
        return Err(needs("imu_calib", "three accelerometers", calibration));
    };
    let bias = nalgebra::Vector3::from_iterator(rows.iter().map(|i| corrector.bias().at(*i)));
    let offset = inverse * bias;
    let what = ["Accelerometer calibration for the ROS package imu_calib: corrected = SM*raw - bias, m/s^2."];
    let mut text = head(calibration, corrector, origin, &what);
    text.push_str(&sensors(calibration, &rows));
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
