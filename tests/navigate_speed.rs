//! Speed of the navigator's lanes: prints lane-steps per second.
use std::time::Instant;
use tumble::navigate::{
    errors::{ImuErrors, Source},
    mission::{Mission, Site},
    motion::{Attitude, Motion, Oscillation},
    run::{self, Continue, Scenario},
};

fn swing() -> Motion {
    let angle = |amplitude: f64, period: f64, phase: f64| Oscillation {
        mean: 0.0,
        amplitude: amplitude.to_radians(),
        period,
        phase: phase.to_radians(),
    };
    Motion::swing(Attitude { pitch: angle(7.0, 6.0, 0.0), roll: angle(10.0, 8.0, 0.0), yaw: angle(5.0, 10.0, 45.0) })
        .unwrap()
}

#[test]
#[ignore = "a measurement: run alone, on an idle machine, with --ignored --nocapture"]
fn lanes_per_second() {
    let site = Site { latitude: 45.7796f64.to_radians(), longitude: 126.6705f64.to_radians(), altitude: 0.0 };
    let mission = Mission::new(site, 0.01, 1.0 * 3600.0, 60.0, swing()).unwrap();
    for lanes in [1, 4, 8, 16, 24] {
        let scenarios: Vec<Scenario> = Source::first_order()
            .into_iter()
            .take(lanes)
            .map(|s| Scenario { id: s.id(), errors: ImuErrors::single(s, 1e-6) })
            .collect();
        let best = (0..12)
            .map(|_| {
                let start = Instant::now();
                run::fly(&mission, &mission.motion, &scenarios, &mut |_| Continue::Yes);
                start.elapsed().as_secs_f64()
            })
            .fold(f64::INFINITY, f64::min);
        println!("{lanes:3} lanes: {:6.1} million lane-steps/s", lanes as f64 * mission.steps as f64 / best / 1e6);
    }
}
