//! The navigator: zero stays zero, orders, the linear model, periods, closed forms.
use std::f64::consts::TAU;
use tumble::navigate::{
    earth,
    errors::{ImuErrors, Kind, Source},
    linear,
    mission::{Mission, Site},
    motion::{Attitude, Leg, Legs, Motion, Oscillation},
    run::{self, Continue, NavigationError, Scenario},
    study,
};

const HOUR: f64 = 3600.0;

fn site() -> Site {
    Site { latitude: 45.7796f64.to_radians(), longitude: 126.6705f64.to_radians(), altitude: 0.0 }
}

fn angle(amplitude: f64, period: f64, phase: f64) -> Oscillation {
    Oscillation { mean: 0.0, amplitude: amplitude.to_radians(), period, phase: phase.to_radians() }
}

fn swing() -> Motion {
    Motion::swing(Attitude { pitch: angle(7.0, 6.0, 0.0), roll: angle(10.0, 8.0, 0.0), yaw: angle(5.0, 10.0, 45.0) })
        .unwrap()
}

fn legs() -> Motion {
    Motion::legs(Legs {
        heading: 60f64.to_radians(),
        speed: 0.0,
        legs: vec![
            Leg { duration: 10.0 * HOUR, acceleration: 0.0 },
            Leg { duration: 200.0, acceleration: 0.05 },
            Leg { duration: f64::INFINITY, acceleration: 0.0 },
        ],
    })
}

fn arcsec(rad: f64) -> f64 {
    rad.to_degrees() * 3600.0
}

fn last(mission: &Mission, motion: &Motion, errors: ImuErrors) -> NavigationError {
    let scenario = Scenario { id: "one".into(), errors };
    run::fly(mission, motion, &[scenario], &mut |_| Continue::Yes).outcomes[0].last
}

/// 48 h at 100 Hz without errors: under 1 m and 0.001 arcsec per hour, in every motion.
#[test]
fn zero_errors_stay_zero() {
    println!("motion        position m   velocity m/s   attitude arcsec/h (largest of 48 h)");
    let hard = Motion::swing(Attitude {
        pitch: angle(10.0, 6.0, 0.0),
        roll: angle(10.0, 6.0, 90.0),
        yaw: angle(20.0, 10.0, 45.0),
    })
    .unwrap();
    for (name, motion) in
        [("static", Motion::at_rest(0.02, -0.03, 1.0)), ("swing", swing()), ("coning", hard), ("legs", legs())]
    {
        let mission = Mission::new(site(), 0.01, 48.0 * HOUR, 60.0, motion).unwrap();
        let scenario = Scenario { id: "none".into(), errors: ImuErrors::default() };
        let flight = run::fly(&mission, &mission.motion, &[scenario], &mut |_| Continue::Yes);
        let outcome = &flight.outcomes[0];
        let attitude = arcsec(outcome.tilt.max.hypot(outcome.azimuth.max)) / 48.0;
        println!("{name:8} {:15.2e} {:14.2e} {attitude:14.2e}", outcome.position.max, outcome.velocity.max);
        assert!(outcome.position.max < 1.0, "{name}");
        assert!(attitude < 1e-3, "{name}");
    }
}

/// Halving the step divides what is left of a swing by 16: fourth order.
#[test]
fn fourth_order_in_the_step() {
    let mut errors = Vec::new();
    println!("step s    attitude arcsec after 2 h   velocity m/s     order");
    for step in [0.12, 0.06, 0.03] {
        let mission = Mission::new(site(), step, 2.0 * HOUR, 60.0, swing()).unwrap();
        let scenario = Scenario { id: "none".into(), errors: ImuErrors::default() };
        let outcome = run::fly(&mission, &mission.motion, &[scenario], &mut |_| Continue::Yes).outcomes.remove(0);
        let pair = [arcsec(outcome.tilt.rms.hypot(outcome.azimuth.rms)), outcome.velocity.rms];
        let order = errors.last().map(|old: &[f64; 2]| [0, 1].map(|i| (old[i] / pair[i]).log2()));
        println!("{step:6} {:20.3e} {:20.3e}   {order:.2?}", pair[0], pair[1]);
        if let Some(order) = order {
            assert!(order.iter().all(|o| (3.7..5.5).contains(o)), "{order:?}");
        }
        errors.push(pair);
    }
}

/// The linear equations agree with the full simulation to 1 % for every source, in all three motions.
#[test]
fn linear_model_agrees() {
    for (name, motion) in [("static", Motion::at_rest(0.05, -0.1, 0.7)), ("swing", swing()), ("legs", legs())] {
        let mission = Mission::new(site(), 0.01, 14.0 * HOUR, 600.0, motion).unwrap();
        let sources = Source::all();
        let scenarios: Vec<Scenario> = sources
            .iter()
            .map(|s| {
                let size = match s.kind {
                    Kind::Bias => 1e-3,
                    Kind::Installation => 1.0,
                    Kind::ScaleFactor => 1e-5,
                    Kind::SecondOrder => {
                        if s.id().starts_with("gyro") {
                            3e-4
                        } else {
                            1e-5
                        }
                    }
                } * if s.id().starts_with("accelerometer_bias") { 0.1 } else { 1.0 };
                Scenario { id: s.id(), errors: ImuErrors::single(*s, size * s.si_per_unit()) }
            })
            .collect();
        // What the perfect navigator leaves (the algorithm's own error, some 0.1 mm) is taken off the full simulation.
        let mut flown = scenarios.clone();
        flown.push(Scenario { id: "none".into(), errors: ImuErrors::default() });
        let mut full = Vec::new();
        run::fly(&mission, &mission.motion, &flown, &mut |row| {
            full.push(row.errors.to_vec());
            Continue::Yes
        });
        let mut linear = Vec::new();
        linear::propagate(&mission, &mission.motion, &mut |s| {
            linear.push(scenarios.iter().map(|c| s.response(&c.errors)).collect::<Vec<_>>());
            Continue::Yes
        });
        assert_eq!(full.len(), linear.len());
        let parts = |e: &NavigationError| [e.attitude.to_vec(), e.velocity.to_vec(), e.position.to_vec()];
        println!("{name}: largest difference over largest error (attitude, velocity, position)");
        for (i, scenario) in scenarios.iter().enumerate() {
            let mut worst = [(0.0f64, 0.0f64); 3];
            for (f, l) in full.iter().zip(&linear) {
                let perfect = parts(&f[scenarios.len()]);
                for (k, (f, l)) in parts(&f[i]).iter().zip(parts(&l[i])).enumerate() {
                    for (j, (f, l)) in f.iter().zip(l).enumerate() {
                        let own = f - perfect[k][j];
                        worst[k] = (worst[k].0.max(own.abs()), worst[k].1.max((own - l).abs()));
                    }
                }
            }
            // rounding of millions of equal steps, which a vehicle at rest repeats
            let rounding = [5e-10, 5e-7, 5e-3];
            let ratio: Vec<f64> =
                worst.iter().zip(rounding).map(|(w, r)| if w.1 > r { w.1 / w.0 } else { 0.0 }).collect();
            println!("  {:32} {:9.1e} {:9.1e} {:9.1e}", scenario.id, ratio[0], ratio[1], ratio[2]);
            assert!(ratio.iter().all(|r| *r < 0.01), "{name} {}", scenario.id);
        }
    }
}

/// Schuler 84.4 min, the Earth's day, and the Foucault rotation between Schuler's two frequencies.
#[test]
fn periods_of_the_error_equations() {
    let [earth, slow, fast] = linear::frequencies(site()).unwrap();
    let foucault = TAU / (0.5 * (fast - slow)) / HOUR;
    let expected = TAU / (earth::EARTH_RATE * site().latitude.sin()) / HOUR;
    println!(
        "Schuler {:.2} min, Earth {:.4} h, Foucault {foucault:.2} h (2 pi / (W sin L) = {expected:.2} h)",
        TAU / (0.5 * (fast + slow)) / 60.0,
        TAU / earth / HOUR
    );
    assert!((TAU / (0.5 * (fast + slow)) / 60.0 - 84.4).abs() < 0.1);
    assert!((TAU / earth / HOUR - 23.934_47).abs() < 1e-4);
    assert!((foucault / expected - 1.0).abs() < 0.01);
}

/// Single-channel closed forms at rest, over half a Schuler period, before the Earth turns much.
#[test]
fn closed_forms_at_rest() {
    let mission = Mission::new(site(), 0.02, 42.2 * 60.0, 60.0, Motion::default()).unwrap();
    let radii = earth::Curvature::at(site().latitude, 0.0);
    let gravity = earth::normal_gravity(site().latitude, 0.0);
    let schuler = (gravity / radii.meridian).sqrt();
    let t = mission.duration();
    let source = |id: &str| Source::named(id).unwrap();
    // north accelerometer bias: dN = b / ws^2 (1 - cos ws t)
    let bias = 1e-4 * gravity;
    let north = last(&mission, &Motion::default(), ImuErrors::single(source("accelerometer_bias_y"), bias)).position[1];
    let expected = bias / schuler.powi(2) * (1.0 - (schuler * t).cos());
    println!("accelerometer bias 1e-4 g: {north:.1} m, closed form {expected:.1} m");
    assert!((north / expected - 1.0).abs() < 0.01);
    // east gyro bias: dN = -e R (t - sin(ws t)/ws)
    let drift = 0.01f64.to_radians() / 3600.0;
    let north = last(&mission, &Motion::default(), ImuErrors::single(source("gyro_bias_x"), drift)).position[1];
    let expected = -drift * radii.meridian * (t - (schuler * t).sin() / schuler);
    println!("east gyro bias 0.01 deg/h: {north:.1} m, closed form {expected:.1} m");
    assert!((north / expected - 1.0).abs() < 0.01);
    // up gyro bias: phi_U = -e t
    let up = last(&mission, &Motion::default(), ImuErrors::single(source("gyro_bias_z"), drift)).attitude[2];
    println!("up gyro bias 0.01 deg/h: {:.4} arcsec, closed form {:.4} arcsec", arcsec(up), arcsec(-drift * t));
    assert!((up / (-drift * t) - 1.0).abs() < 0.01);
}

/// The source's findings: each group of errors in swing and in slow acceleration, against rest, over 48 h.
#[test]
fn findings_of_the_source() {
    let mut errors = ImuErrors::default();
    for source in Source::first_order() {
        let value = match source.kind {
            Kind::Bias if source.id().starts_with("gyro") => 0.01,
            Kind::Bias => 1e-4,
            // not equal in the three axes: equal ones are a scale of the whole vector, which a level navigator ignores
            Kind::ScaleFactor => [1e-3, -5e-4, 7e-4][source.axis],
            _ => 10.0,
        };
        source.set(&mut errors, value * source.si_per_unit());
    }
    let mission =
        Mission::new(site(), 0.01, 48.0 * HOUR, 60.0, Motion::at_rest(0.0, 0.0, -60f64.to_radians())).unwrap();
    let yaw = Oscillation { mean: -60f64.to_radians(), ..angle(5.0, 10.0, 45.0) };
    let swing = Motion::swing(Attitude { pitch: angle(7.0, 6.0, 0.0), roll: angle(10.0, 8.0, 0.0), yaw }).unwrap();
    let mission = mission.beside(swing).unwrap().beside(legs()).unwrap();
    let scenarios = study::scenarios(&errors, study::Separation::Groups);
    let flown = study::fly(&mission, &scenarios, &mut |_, _, _| Continue::Yes);
    for f in &flown {
        for o in &f.flight.outcomes {
            println!(
                "{:8} {:30} tilt {:9.2} arcsec azimuth {:9.2} arcsec v {:8.3} m/s p {:9.1} m",
                f.motion,
                o.id,
                arcsec(o.tilt.rms),
                arcsec(o.azimuth.rms),
                o.velocity.rms,
                o.position.rms
            );
        }
    }
    for r in study::ratios(&flown) {
        println!(
            "{:30} {:6} / static: tilt {:.2?} azimuth {:.2?} velocity {:.2?} position {:.2?}",
            r.scenario, r.motion, r.tilt, r.azimuth, r.velocity, r.position
        );
    }
}
