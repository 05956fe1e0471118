//! A bench and a campaign in code, and the calibration: a rate gyro on a single-axis rate table.
//!
//! `cargo run --release --no-default-features --example calibrate`

use tumble::bench::Axis;
use tumble::fit::Settings;
use tumble::wire::{ReadingBuilder, SensorBuilder};
use tumble::{Bench, Campaign, Result};

fn main() -> Result<()> {
    // the table turns about z; the gyro's output follows the rate along its input axis, with a cubic error
    let bench = Bench::builder("rate-table")
        .joint("gamma", Axis::Z)
        .sensor("V", SensorBuilder::new("V", "V0 + kI*w_I + k3*w_I^3").axis("I", Axis::Z))
        .build()?;

    // two runs over six rates, deg/s; each value is a mean that is known to 0.2 mV
    let rates = [10.0, -10.0, 50.0, -50.0, 100.0, -100.0];
    let runs = [
        [0.25312, -0.24685, 1.25268, -1.24640, 2.49907, -2.49271],
        [0.25334, -0.24701, 1.25253, -1.24667, 2.49884, -2.49256],
    ];
    let readings = runs.iter().flat_map(|volts| {
        rates
            .iter()
            .zip(volts)
            .map(|(rate, volt)| ReadingBuilder::new().turning("gamma", *rate).value_u("V", *volt, 2e-4))
    });
    let campaign = Campaign::builder(&bench)
        .estimate("V0")
        .estimate("kI")
        .estimate("k3")
        .derived_in("bias", "V0/kI", "deg/s")
        .readings(readings)
        .build()?;

    let fit = tumble::fit(&campaign, &Settings::default())?;
    println!("{:<6}{:>14}{:>12}{:>12}  unit", "", "estimate", "u", "U (95 %)");
    for id in ["V0", "kI", "k3"] {
        let own = fit.parameter(id)?;
        if let (Some(value), Some(of)) = (own.value, own.uncertainty) {
            println!("{id:<6}{value:>14.4e}{:>12.1e}{:>12.1e}  {}", of.u, of.expanded, own.unit);
        }
    }
    for own in &fit.derived {
        if let (Some(value), Some(of)) = (own.value, own.uncertainty) {
            println!("{:<6}{value:>14.4e}{:>12.1e}{:>12.1e}  deg/s", own.id, of.u, of.expanded);
        }
    }
    match fit.global_test {
        Some(test) if test.rejected => println!("the readings scatter more than stated: p = {:.2}", test.p),
        Some(test) => println!("the readings scatter as stated: p = {:.2}", test.p),
        None => println!("nothing tests the stated uncertainties"),
    }
    Ok(())
}
