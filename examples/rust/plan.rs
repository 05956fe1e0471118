//! A schedule that reaches a goal, before anyone measures: the fewest positions that give each angle of a gyro's table to 1 arcsec.
//!
//! `cargo run --release --no-default-features --example plan`

use std::f64::consts::PI;
use tumble::plan::{Costs, Goal, Noise, Offer, Request, Unit, positions_only, reach, sweep};
use tumble::report::position_keys;
use tumble::{Campaign, Result};

fn main() -> Result<()> {
    // what is asked and how the table turns, as in the published schedule; one reading scatters by 0.9 mV
    let published = Campaign::from_json(include_str!("../../data/campaigns/li2012-table1.campaign.json"))?;
    let noise = Noise::new(&published, &[("V".into(), 9e-4)], &[])?;
    let given = tumble::plan::judge(&published, &noise, &Costs::default())?;

    let arcsec = PI / 648_000.0;
    let angles = || given.parameters.iter().filter(|own| own.kind == tumble::campaign::Kind::Tilt);
    let goals: Vec<Goal> = angles().map(|own| Goal { id: own.id.clone(), u: arcsec }).collect();
    let offer = Offer {
        kept: tumble::campaign::Readings { rows: Vec::new(), ..positions_only(&published.readings) },
        candidates: sweep(&published, 90.0)?,
        noise,
        costs: Costs::default(),
    };
    let request = Request { readings: 60, unit: Unit::Pair, starts: 20, ..Request::default() };
    let found = reach(&published, &offer, &request, &goals, false)?;

    let best = &found.improvement;
    println!("{} readings instead of {}:", best.chosen, published.readings.rows.len());
    for reading in &best.schedule.readings.rows {
        let keys = position_keys(&best.schedule, &reading.joints);
        let said: Vec<String> = keys.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        println!("  {}", said.join(", "));
    }
    println!("{:<12}{:>16}{:>12}", "u in arcsec", "as published", "planned");
    for own in angles() {
        let planned = best.judgement.parameters.iter().find(|other| other.id == own.id).and_then(|other| other.u);
        let shown = |u: Option<f64>| u.map_or("-".into(), |u| format!("{:.2}", u / arcsec));
        println!("{:<12}{:>16}{:>12}", own.id, shown(own.u), shown(planned));
    }
    println!(
        "{}",
        match (found.goal.reached, found.goal.is_fewest) {
            (true, true) => "the goal is reached; fewer readings of these positions cannot",
            (true, false) => "the goal is reached",
            (false, _) => "the goal is not reached",
        }
    );
    Ok(())
}
