//! What a published model misses, and the repaired bench file: the gyro of Li, Ren, Zhao 2012, table 1.
//!
//! `cargo run --release --no-default-features --example diagnose`

use tumble::diagnosis::Settings;
use tumble::{Campaign, Result, wire};

fn main() -> Result<()> {
    let campaign = Campaign::from_json(include_str!("../../data/campaigns/li2012-table1.campaign.json"))?;
    let diagnosis = tumble::diagnose(&campaign, &wire::built_in_effects()?, &Settings::default())?;

    println!("{}: {} candidates tried", diagnosis.verdict, diagnosis.candidates.0);
    for found in &diagnosis.effects {
        println!("missing: {} ({})", found.effect.name, found.effect.regressor);
        if let (Some(value), Some(u)) = (found.value, found.u) {
            println!("  {} = {value:.3e}, u = {u:.1e} {}", found.effect.coefficient, found.unit);
        }
        println!("  takes {:.0} % of the gap's sum of squares off, p = {:.1e}", 100.0 * found.explains, found.p);
        for alias in &found.aliases {
            println!("  this schedule cannot distinguish it from {} ({})", alias.name, alias.regressor);
        }
    }
    if let Some(repaired) = &diagnosis.repaired {
        println!("repaired model:");
        for sensor in &wire::bench_file(&repaired.bench).sensors.0 {
            println!("  {} = {}", sensor.0, sensor.1.model);
        }
    }
    Ok(())
}
