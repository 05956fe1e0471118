//! Missions: what they may hold, turns and swings under way, acceleration-sensitive drift, the navigator's own error.
use crate::navigate::errors::{ErrorSource, ImuErrors};
use crate::navigate::mission::Mission;
use crate::navigate::run::{self, Continue, Flight, Scenario};
use crate::navigate::{propagation, study};
use crate::wire::{self, MissionFile};
use tumble::error::Malformed;
use tumble::{navigate as public, report};

fn parsed(motion: serde_json::Value) -> Result<Mission, Malformed> {
    with(serde_json::json!({ "motion": motion }))
}

/// A short mission with some keys of one's own.
fn with(keys: serde_json::Value) -> Result<Mission, Malformed> {
    let source = source(keys);
    let file: MissionFile = wire::parse(&source)?;
    file.mission().map_err(|error| wire::locate(error, &source))
}

/// The same as the library has it.
fn asked(keys: serde_json::Value) -> public::Mission {
    wire::parse::<tumble::wire::MissionFile>(&source(keys)).and_then(|file| file.mission()).unwrap()
}

fn source(keys: serde_json::Value) -> wire::Source {
    let mut mission = serde_json::json!({
        "site": { "latitude_deg": 45.0 }, "step_s": 0.01, "duration_h": 0.1, "output_every_s": 10,
        "motion": { "static": {} }, "errors": { "gyro_bias_deg_h": 0.01 }
    });
    for (key, value) in keys.as_object().unwrap() {
        mission[key] = value.clone();
    }
    wire::Source { name: "m.mission.json".into(), text: serde_json::to_string_pretty(&mission).unwrap() }
}

fn perfect(mission: &Mission) -> Flight {
    let scenario = Scenario { id: "none".into(), errors: ImuErrors::default() };
    run::fly(mission, &mission.motion, &[scenario], &mut |_| Continue::Yes)
}

#[test]
fn legs_along_a_parallel_go_anywhere_and_towards_a_pole_to_89_degrees() {
    let east = serde_json::json!({ "legs": { "heading_deg": 90, "speed_m_s": 250, "legs": [{}] } });
    let mission = with(serde_json::json!({ "site": { "latitude_deg": 86.0 }, "motion": east })).unwrap();
    let flight = perfect(&mission);
    println!("86 degrees, due east: {:.1e} m", flight.outcomes[0].position.max);
    assert!(flight.outcomes[0].position.max < 1e-3);
    let north = serde_json::json!({ "legs": { "heading_deg": 0, "speed_m_s": 2000, "legs": [{}] } });
    let error = with(serde_json::json!({ "site": { "latitude_deg": 86.0 }, "motion": north })).unwrap_err();
    assert!(error.to_string().contains("towards a pole"), "{error}");
}

#[test]
fn a_leg_may_have_an_odd_number_of_steps() {
    let legs = |first: f64| {
        serde_json::json!({ "legs": { "legs": [
            { "duration_s": first }, { "duration_s": 20.0, "acceleration_m_s2": 2.0 }, {}] } })
    };
    let mission = parsed(legs(10.01)).unwrap();
    let mut speeds = Vec::new();
    let scenario = Scenario { id: "none".into(), errors: ImuErrors::default() };
    let flight = run::fly(&mission, &mission.motion, &[scenario], &mut |row| {
        speeds.push((row.truth.time, row.truth.velocity[1]));
        Continue::Yes
    });
    for (time, speed) in &speeds {
        assert!((speed - 2.0 * (time - 10.01).clamp(0.0, 20.0)).abs() < 1e-9, "{time} {speed}");
    }
    // an acceleration that begins between two samples: the algorithm takes the pair as smooth, no more
    println!("own error {:.1e} m, {:.1e} m/s", flight.outcomes[0].position.max, flight.outcomes[0].velocity.max);
    assert!(flight.outcomes[0].position.max < 1e-2 && flight.outcomes[0].velocity.max < 1e-4);
    let error = parsed(legs(10.005)).unwrap_err();
    assert!(
        error.to_string().contains("within a step") && error.to_string().contains("whole number of steps"),
        "{error}"
    );
}

#[test]
fn a_heading_of_361_degrees_is_one_of_1_degree() {
    let heading = |degrees: f64| parsed(serde_json::json!({ "static": { "heading_deg": degrees } })).unwrap().motion;
    assert_eq!(heading(361.0), heading(1.0));
    assert_eq!(heading(-721.0), heading(-1.0));
    let legs =
        |degrees: f64| parsed(serde_json::json!({ "legs": { "heading_deg": degrees, "legs": [{}] } })).unwrap().motion;
    assert_eq!(legs(361.0), legs(1.0));
}

#[test]
fn a_motion_is_of_one_kind() {
    let error = parsed(serde_json::json!({ "static": {}, "swing": {} })).unwrap_err();
    println!("{error}");
    assert!(error.to_string().contains("two kinds, 'static' and 'swing'") && error.place().path.starts_with("motion"));
    let error = parsed(serde_json::json!({})).unwrap_err();
    assert!(error.to_string().contains("no kind"), "{error}");
}

/// A swing's heading is clockwise, as every heading; `yaw` is the same counter-clockwise.
#[test]
fn a_swing_in_heading_is_clockwise() {
    let swing = |key: &str, mean: f64, phase: f64| {
        let mut swing = serde_json::json!({ "swing": {} });
        swing["swing"][key] =
            serde_json::json!({ "mean_deg": mean, "amplitude_deg": 5, "period_s": 10, "phase_deg": phase });
        parsed(swing).unwrap().motion
    };
    let (clockwise, counter) = (swing("heading", 60.0, 45.0), swing("yaw", -60.0, 225.0));
    for time in [0.0, 1.0, 2.7, 9.9] {
        let (a, b) = (clockwise.attitude.yaw.at(time), counter.attitude.yaw.at(time));
        assert!((a - b).abs() < 1e-12, "{time}: {a} {b}");
    }
    let both = serde_json::json!({ "swing": { "heading": { "mean_deg": 1 }, "yaw": { "mean_deg": 1 } } });
    assert!(parsed(both).unwrap_err().to_string().contains("a heading and a yaw"));
    // and it is written so
    let text = wire::MotionFile::of(&counter).in_words();
    assert_eq!(text, "swing, heading 5 deg in 10 s");
}

/// At rest and level 1 (deg/h)/g along the vertical is a bias of as many deg/h as there are g.
#[test]
fn acceleration_sensitive_drift_at_rest_is_a_bias() {
    let mission = parsed(serde_json::json!({ "static": { "heading_deg": 30 } })).unwrap();
    let gravity = crate::navigate::earth::normal_gravity(mission.site.latitude_rad, 0.0) / 9.80665;
    for (drift, bias) in [("xz", "x"), ("yz", "y"), ("zz", "z")] {
        let one = |id: String, value: f64| {
            let source = ErrorSource::named(&id).unwrap();
            let errors = ImuErrors::single(source, value * source.si_per_unit());
            let scenario = Scenario { id, errors };
            run::fly(&mission, &mission.motion, &[scenario], &mut |_| Continue::Yes).outcomes[0].last
        };
        let a = one(format!("gyro_acceleration_sensitive_{drift}"), 2.0);
        let b = one(format!("gyro_bias_{bias}"), 2.0 * gravity);
        for (a, b) in a.attitude.iter().chain(&a.position).zip(b.attitude.iter().chain(&b.position)) {
            // 6 minutes at 2 deg/h: 1e-3 rad; rounding of 36000 steps
            assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-2), "{drift}: {a} {b}");
        }
    }
    // as a mission file gives it
    let errors = serde_json::json!({ "gyro_acceleration_sensitive_deg_h_per_g": { "xz": 2 } });
    let mission = with(serde_json::json!({ "errors": errors })).unwrap();
    assert_eq!(
        mission.errors.present().iter().map(ErrorSource::id).collect::<Vec<_>>(),
        ["gyro_acceleration_sensitive_xz"]
    );
}

/// A full circle comes back, and the navigator, which integrates rates and forces without knowing of turns, agrees with the truth.
#[test]
fn turns_and_swings_under_way_close() {
    let swing = serde_json::json!({ "pitch": { "amplitude_deg": 3, "period_s": 6 }, "roll": { "amplitude_deg": 5, "period_s": 8 },
        "heading": { "amplitude_deg": 2, "period_s": 10 } });
    let turn = |swing: Option<&serde_json::Value>| {
        let mut legs = serde_json::json!({ "legs": { "heading_deg": 20, "speed_m_s": 10, "legs": [
            { "duration_s": 30 }, { "duration_s": 120, "turn_deg_s": 3 }, {} ] } });
        if let Some(swing) = swing {
            legs["legs"]["swing"] = swing.clone();
        }
        parsed(legs).unwrap()
    };
    for (name, mission) in [("turn", turn(None)), ("turn with a swing", turn(Some(&swing)))] {
        let scenario = Scenario { id: "none".into(), errors: ImuErrors::default() };
        let mut places = Vec::new();
        let flight = run::fly(&mission, &mission.motion, &[scenario], &mut |row| {
            places.push((row.truth.time, row.truth.latitude_rad, row.truth.longitude_rad, row.truth.velocity));
            Continue::Yes
        });
        let own = flight.outcomes[0].position.max;
        println!("{name}: own error {own:.1e} m, {:.1e} rad", flight.outcomes[0].tilt.max);
        // rates and forces that jump where the turn begins and ends
        assert!(own < 0.05, "{name}");
        let at = |time: f64| places.iter().find(|p| (p.0 - time).abs() < 1e-6).unwrap();
        let (begin, end) = (at(30.0), at(150.0));
        let north = (end.1 - begin.1) * 6.37e6;
        let east = (end.2 - begin.2) * 6.37e6 * begin.1.cos();
        // a circle of 191 m on a curved Earth: millimetres
        assert!(north.abs() < 0.05 && east.abs() < 0.05, "{name}: {north} {east}");
        assert!((end.3[0] - begin.3[0]).abs() < 1e-9 && (end.3[1] - begin.3[1]).abs() < 1e-9);
        // a quarter of the way round it heads 110 degrees
        let quarter = at(60.0).3;
        assert!((quarter[0] - 10.0 * 110f64.to_radians().sin()).abs() < 1e-9);
        assert!((quarter[1] - 10.0 * 110f64.to_radians().cos()).abs() < 1e-9);
        let text = serde_json::to_value(wire::MotionFile::of(&mission.motion)).unwrap();
        assert_eq!(parsed(text.clone()).unwrap().motion.path, mission.motion.path, "{text}");
    }
}

#[test]
fn there_is_no_foucault_period_at_the_equator() {
    let mission = asked(serde_json::json!({ "site": { "latitude_deg": 0 } }));
    let report = report::navigate_report(&mission, &[], &[], &[]);
    let periods = report.periods.unwrap();
    assert_eq!(periods.foucault_h, None);
    assert!((periods.earth_h - 23.9345).abs() < 1e-3);
    let text = report.to_string();
    assert!(text.contains("Foucault none (at the equator)") && text.contains("Vertical channel: held"), "{text}");
}

#[test]
fn too_many_draws_are_refused_before_the_work() {
    for draws in [9_223_372_036_854_775_808_u64, 1_000_000_000] {
        let calibration = serde_json::json!({ "report": "fit.json", "carry": {}, "monte_carlo": draws });
        let error = with(serde_json::json!({ "calibration": calibration })).unwrap_err();
        println!("{error}");
        assert!(error.to_string().contains("too many draws") && error.place().path == "calibration.monte_carlo");
    }
}

#[test]
fn a_matrix_that_is_no_covariance_is_refused() {
    let order: Vec<String> = ["a", "b", "c"].map(String::from).into();
    let carry = |matrix: [[f64; 3]; 3]| {
        let matrix: Vec<Vec<Option<f64>>> = matrix.iter().map(|row| row.iter().map(|v| Some(*v)).collect()).collect();
        propagation::combine(&order, &matrix, &[]).map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(carry([[4.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]]), Ok(()));
    let cases = [
        ([[4.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]], "variance of 'b' is negative"),
        ([[4.0, 1.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]], "not symmetric in 'a' and 'b'"),
        ([[4.0, 2.5, 0.0], [2.5, 1.0, 0.0], [0.0, 0.0, 1.0]], "'a' and 'b' correlate beyond 1"),
        ([[1.0, 0.9, -0.9], [0.9, 1.0, 0.9], [-0.9, 0.9, 1.0]], "some combination would have a negative variance"),
    ];
    for (matrix, expected) in cases {
        let error = carry(matrix).unwrap_err();
        println!("{error}");
        assert!(error.contains(expected), "{error}");
    }
}

/// A vibration that the step does not resolve: the perfect unit's row shows it, and a warning says so; a slow swing has none.
#[test]
fn the_navigators_own_error_is_a_row_and_a_warning() {
    let swing = |period: f64, step: f64| {
        let swing = serde_json::json!({ "swing": {
            "pitch": { "amplitude_deg": 0.01, "period_s": period }, "roll": { "amplitude_deg": 0.01, "period_s": period, "phase_deg": 90 } } });
        asked(serde_json::json!({ "motion": swing, "step_s": step, "errors": { "gyro_bias_deg_h": 0.001 } }))
    };
    for (period, step, warns) in [(0.025, 0.01, true), (6.0, 0.01, false), (0.025, 0.001, false)] {
        let mission = swing(period, step);
        let scenarios = public::scenarios(&mission.errors, public::FlownTogether::Groups);
        assert_eq!(scenarios.last().unwrap().id, "perfect_unit");
        let flown = public::fly(&mission, &scenarios, &mut |_, _, _| public::Continue::Yes);
        let report = report::navigate_report(&mission, &scenarios, &flown, &[]);
        println!("{period} s at {step} s: {:?}", report.warnings);
        assert_eq!(!report.warnings.is_empty(), warns);
        let text = report.to_string();
        assert!(text.contains("perfect_unit") && text.contains("Caution: ") == warns, "{text}");
    }
}

/// Where the first motion's error is no more than the navigator's own, a ratio to it says nothing.
#[test]
fn ratios_to_rounding_are_not_printed() {
    let keys = serde_json::json!({ "step_s": 0.05, "duration_h": 4, "output_every_s": 7.3,
        "beside": [{ "swing": { "pitch": { "amplitude_deg": 7, "period_s": 6 } } }],
        "errors": { "accelerometer_scale_factor": [1e-3, -5e-4, 7e-4], "gyro_bias_deg_h": 0.01 } });
    let mission = with(keys).unwrap();
    let scenarios = study::scenarios(&mission.errors, study::FlownTogether::Groups);
    let flown = study::fly(&mission, &scenarios, &mut |_, _, _| Continue::Yes);
    for ratio in study::ratios(&mission, &flown) {
        let all = [ratio.tilt, ratio.azimuth, ratio.velocity, ratio.position];
        println!("{} {all:?}", ratio.scenario);
        // level and at rest an accelerometer's scale factor acts on the vertical alone, which is held
        assert_eq!(ratio.scenario == "accelerometer_scale_factor", all.iter().all(Option::is_none));
    }
}
