//! A six-sensor campaign of 24 positions and 36 rate runs fits in under 5 ms, in process.

mod systems;

use std::time::Instant;
use systems::*;
use tumble::fit;

#[test]
fn a_six_sensor_campaign_of_24_positions_and_36_rate_runs_fits_in_under_5_ms() {
    println!("median of 41 fits, one process");
    for path in ["perfect-table", "table-errors"] {
        let campaign = campaign(&format!("examples/20-imu-three-axis-table/{path}.campaign.json"));
        for settings in [fit::Settings::default(), exact()] {
            let mut times: Vec<f64> = (0..41)
                .map(|_| {
                    let start = Instant::now();
                    let fit = fit::fit(&campaign, &settings).unwrap();
                    assert!(fit.not_estimable.is_empty());
                    start.elapsed().as_secs_f64() * 1e3
                })
                .collect();
            times.sort_by(f64::total_cmp);
            let median = times[20];
            println!(
                "  {path:14} {:7} {} values, {} unknowns: {median:.2} ms",
                if settings.exact { "exact" } else { "linear" },
                campaign.readings.rows.iter().map(|r| r.observations.len()).sum::<usize>(),
                campaign.unknowns()
            );
        }
    }
}
