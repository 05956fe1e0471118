//! The noise of a record as the IMU file of kalibr.

use super::noise_analysis::NoiseAnalysisReport;
use crate::document::number::significant;
use crate::error::{Fault, Malformed, Result};
use crate::noise::{Term, si_factor};

/// The IMU file of kalibr: densities in rad/s/sqrt(Hz), m/s^2/sqrt(Hz), random walks in rad/s^2/sqrt(Hz), m/s^3/sqrt(Hz); the largest of each kind of sensor.
///
/// Errors: no column in a unit of rate or specific force; a kind without white noise.
pub fn kalibr(report: &NoiseAnalysisReport) -> Result<String> {
    let largest = |gyro: bool, id: Term, bound: bool| {
        report
            .columns
            .iter()
            .filter_map(|column| {
                let (is_gyro, factor) = si_factor(&column.unit).filter(|(is_gyro, _)| *is_gyro == gyro)?;
                let c = column.coefficients.iter().find(|c| c.id == id)?;
                let in_unit = crate::noise::field_unit(id, &column.unit).factor;
                let value = if bound { c.below.map(|b| b / in_unit) } else { c.si_seconds };
                let _ = is_gyro;
                value.map(|v| (v * factor, column.column.clone()))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let mut text = String::from("#Accelerometers\n");
    let mut kinds = 0;
    for (gyro, title, words) in [
        (false, "accelerometer", ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")),
        (true, "gyroscope", ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)")),
    ] {
        if gyro {
            text.push_str("\n#Gyroscopes\n");
        }
        let Some((density, from)) = largest(gyro, Term::RandomWalk, false) else { continue };
        kinds += 1;
        text.push_str(&format!("{title}_noise_density: {density:.6e}   # {}, N of {from}\n", words.0));
        match (largest(gyro, Term::RateRandomWalk, false), largest(gyro, Term::RateRandomWalk, true)) {
            (Some((walk, from)), _) => {
                text.push_str(&format!("{title}_random_walk: {walk:.6e}   # {}, K of {from}\n", words.1));
            }
            (None, Some((walk, from))) => text.push_str(&format!(
                "{title}_random_walk: {walk:.6e}   # {}, not found in this record: what K of {from} is below (95 %)\n",
                words.1
            )),
            (None, None) => {}
        }
    }
    if kinds == 0 {
        return Err(Malformed::new(Fault::Value, "kalibr's file holds gyros and accelerometers, and no column is one")
            .expected("columns in a unit of rate (deg/s, rad/s, deg/h) or of specific force (g, mg, m/s^2)")
            .found(
                report.columns.iter().map(|c| format!("{} in {}", c.column, c.unit)).collect::<Vec<_>>().join(", "),
            ));
    }
    text.push_str(&format!("\nrostopic: /imu0\nupdate_rate: {}\n", significant(1.0 / report.interval_s, 6)));
    Ok(text)
}
