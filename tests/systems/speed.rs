//! How long a six-sensor campaign of 24 positions and 36 rate runs takes, in process. Printed; the bound is loose because other work
//! may share the machine.

use crate::support::*;
use std::time::Instant;
use tumble::fit;

#[test]
fn a_six_sensor_campaign_of_24_positions_and_36_rate_runs_fits_in_milliseconds() {
    println!("fastest and median of 41 fits in one process, ms");
    let folder = "examples/20-imu-three-axis-table";
    let files = [
        "tests/data/simulated/imu-table.campaign.json".to_string(),
        "tests/data/simulated/imu-table-tilted.campaign.json".to_string(),
        format!("{folder}/perfect-table.campaign.json"),
        format!("{folder}/table-errors.campaign.json"),
    ];
    for path in files {
        let campaign = campaign(&path);
        for settings in [fit::Settings::default(), exact()] {
            let mut steps = 0;
            let mut times: Vec<f64> = (0..41)
                .map(|_| {
                    let start = Instant::now();
                    let fit = fit::fit(&campaign, &settings).unwrap();
                    steps = fit.estimate.group_iterations;
                    start.elapsed().as_secs_f64() * 1e3
                })
                .collect();
            times.sort_by(f64::total_cmp);
            println!(
                "  {:6.2} {:6.2}  {path}, {}, {} unknowns, {steps} steps to the sensors' scales",
                times[0],
                times[20],
                if settings.exact { "exact" } else { "linear" },
                campaign.unknowns()
            );
            // the campaign of the requirement: stated uncertainties, a perfect table
            assert!(
                cfg!(debug_assertions) || !path.ends_with("imu-table.campaign.json") || times[0] < 5.0,
                "{path}: {} ms",
                times[0]
            );
        }
    }
}
