//! The navigator: zero stays zero, orders, the linear model, periods, closed forms.
use crate::navigate::{
    earth,
    errors::{ErrorSource, ImuErrors, Kind},
    linear,
    mission::{Mission, Site},
    motion::{Attitude, Leg, Legs, Motion, Oscillation},
    propagation,
    run::{self, Continue, NavigationError, Scenario},
    study,
};
use crate::wire;
use std::f64::consts::TAU;

const HOUR: f64 = 3600.0;

/// The navigation error of a set of small errors, by the linear equations.
fn response(signatures: &linear::Signatures, errors: &ImuErrors) -> NavigationError {
    let mut sum = [0.0; 7];
    for (source, state) in ErrorSource::catalogue().iter().zip(&signatures.states) {
        sum.iter_mut().zip(state).for_each(|(total, part)| *total += source.of(errors) * part);
    }
    signatures.error(&sum)
}

fn site() -> Site {
    Site { latitude_rad: 45.7796f64.to_radians(), longitude_rad: 126.6705f64.to_radians(), altitude_m: 0.0 }
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
            Leg { duration: 10.0 * HOUR, acceleration: 0.0, turn: 0.0 },
            Leg { duration: 200.0, acceleration: 0.05, turn: 0.0 },
            Leg { duration: f64::INFINITY, acceleration: 0.0, turn: 0.0 },
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
        let sources = ErrorSource::catalogue();
        let scenarios: Vec<Scenario> = sources
            .iter()
            .map(|s| {
                let size = match s.kind {
                    Kind::Bias => 1e-3,
                    Kind::Installation | Kind::Attitude | Kind::Position => 1.0,
                    Kind::AccelerationSensitive => 1e-3,
                    Kind::ScaleFactor => 1e-5,
                    Kind::Velocity => 1e-3,
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
            linear.push(scenarios.iter().map(|c| response(s, &c.errors)).collect::<Vec<_>>());
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
    let expected = TAU / (earth::EARTH_RATE * site().latitude_rad.sin()) / HOUR;
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
    let radii = earth::Curvature::at(site().latitude_rad, 0.0);
    let gravity = earth::normal_gravity(site().latitude_rad, 0.0);
    let schuler = (gravity / radii.meridian).sqrt();
    let t = mission.duration();
    let source = |id: &str| ErrorSource::named(id).unwrap();
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
///
/// With its values (1 per mille on all axes) its sentences hold; what excites an accelerometer's scale factor are the legs, not the swing.
#[test]
fn findings_of_the_source() {
    let text = include_str!("../../examples/09-navigator/findings.mission.json");
    let source = wire::Source { name: "findings.mission.json".into(), text: text.into() };
    let file: wire::MissionFile = wire::parse(&source).unwrap();
    let mission = file.mission().unwrap();
    let scenarios = study::scenarios(&mission.errors, file.scenarios);
    let flown = study::fly(&mission, &scenarios, &mut |_, _, _| Continue::Yes);
    let ratios = study::ratios(&mission, &flown);
    println!("scenario                       motion / static: tilt azimuth velocity position");
    for r in &ratios {
        println!(
            "{:30} {:6} {:.2?} {:.2?} {:.2?} {:.2?}",
            r.scenario, r.motion, r.tilt, r.azimuth, r.velocity, r.position
        );
    }
    let of = |scenario: &str, motion: &str| {
        let r = ratios.iter().find(|r| r.scenario == scenario && r.motion == motion).unwrap();
        [r.tilt, r.azimuth, r.velocity, r.position]
    };
    let near = |ratio: Option<f64>, by: f64| (ratio.unwrap() - 1.0).abs() < by;
    // "gyro bias, accelerometer bias and installation: nearly the same in all three"
    for scenario in ["gyro_bias", "accelerometer_bias", "accelerometer_installation"] {
        for motion in ["swing", "legs"] {
            assert!(of(scenario, motion).into_iter().all(|r| near(r, 0.12)), "{scenario} {motion}");
        }
    }
    // "gyro scale factor and installation: excited by swing, little by slow acceleration"
    for scenario in ["gyro_scale_factor", "gyro_installation"] {
        let [tilt, azimuth, velocity, position] = of(scenario, "swing");
        assert!(tilt.unwrap() > 3.0 && velocity.unwrap() > 1.02 && near(position, 0.1), "{scenario}");
        // an independent simulation gives 3.38 for the scale factor; installation errors do so near east only
        let expected = if scenario == "gyro_scale_factor" { 3.38 } else { 0.94 };
        assert!((azimuth.unwrap() / expected - 1.0).abs() < 0.01, "{scenario}: {azimuth:?}");
        let [tilt, azimuth, velocity, position] = of(scenario, "legs");
        assert!([tilt, velocity, position].into_iter().all(|r| near(r, 0.1)) && azimuth.unwrap() < 1.5, "{scenario}");
    }
    // accelerometer scale factors that are equal are one scale of the whole vector: nothing at rest, level, nor in a swing
    let tilt = |motion: usize| {
        let outcomes = &flown[motion].flight.outcomes;
        arcsec(outcomes.iter().find(|o| o.id == "accelerometer_scale_factor").unwrap().tilt.rms)
    };
    println!(
        "accelerometer scale factor, tilt: static {:.1e}, swing {:.3}, legs {:.3} arcsec",
        tilt(0),
        tilt(1),
        tilt(2)
    );
    assert!(tilt(0) < 1e-5 && tilt(1) < 1e-5 && tilt(2) > 0.1);
}

/// Linear covariance and Monte Carlo of the full simulation agree within what so few draws allow.
#[test]
fn covariance_carried_two_ways() {
    let order: Vec<String> = ["b", "k", "t"].map(String::from).to_vec();
    // correlated: bias and tilt by 0.8
    let matrix = vec![
        vec![Some(1e-6), Some(0.0), Some(0.8e-6)],
        vec![Some(0.0), Some(1e-10), Some(0.0)],
        vec![Some(0.8e-6), Some(0.0), Some(1e-6)],
    ];
    let factor = |id: &str, parameter: &str, factor: f64| (id.to_string(), vec![(parameter.to_string(), factor)]);
    let factors = [
        factor("gyro_bias_x", "b", 5.0),
        factor("gyro_scale_factor_z", "k", 1.0),
        factor("accelerometer_installation_yz", "t", 1000.0),
    ];
    let covariance = propagation::combine(&order, &matrix, &factors).unwrap();
    let mut mission = Mission::new(site(), 0.02, 4.0 * HOUR, 600.0, swing()).unwrap();
    mission.errors.gyro.random_walk = 0.001f64.to_radians() / 60.0;
    mission.seed = 11;
    let draws = 160;
    let carried = study::propagate_calibration(&mission, &covariance, draws, &mut |_| Continue::Yes);
    let (linear, sampled) = (carried[0].linear.last().unwrap(), carried[0].monte_carlo.unwrap());
    let all = |u: &NavigationError| [&u.attitude[..], &u.velocity, &u.position].concat();
    println!("linear {:?}\nMonte Carlo {:?}", all(linear), all(&sampled));
    // A standard deviation from n draws has the relative uncertainty 1/sqrt(2 n) = 3.5 %; three of them, seeded.
    for (a, b) in all(linear).iter().zip(all(&sampled)) {
        assert!((b / a - 1.0).abs() < 3.0 / (2.0 * draws as f64).sqrt(), "{a} {b}");
    }
}

/// A seeded angle random walk alone: the azimuth's standard deviation after t is N sqrt(t), as long as t is short against
/// Schuler's period (tilts then feed the azimuth through the transport rate).
#[test]
fn random_walk_grows_with_the_root_of_time() {
    let mut errors = ImuErrors::default();
    errors.gyro.random_walk = 0.01f64.to_radians() / 60.0;
    let mission = Mission::new(site(), 0.02, 0.05 * HOUR, 60.0, Motion::default()).unwrap();
    let scenarios: Vec<Scenario> = (0..400).map(|k| Scenario { id: k.to_string(), errors }).collect();
    let flight = run::fly(&mission, &mission.motion, &scenarios, &mut |_| Continue::Yes);
    let squares: f64 = flight.outcomes.iter().map(|o| o.last.attitude[2].powi(2)).sum();
    let (found, expected) = (arcsec((squares / 400.0).sqrt()), 0.01 * 0.05f64.sqrt() * 3600.0);
    println!("azimuth sd {found:.3} arcsec, N sqrt(t) = {expected:.3} arcsec");
    assert!((found / expected - 1.0).abs() < 0.1);
}

/// One scenario gives bit for bit the same in any lane and company.
#[test]
fn lanes_do_not_mix() {
    let mission = Mission::new(site(), 0.01, 0.2 * HOUR, 60.0, swing()).unwrap();
    let scenarios: Vec<Scenario> =
        ErrorSource::all().into_iter().map(|s| Scenario { id: s.id(), errors: ImuErrors::single(s, 1e-4) }).collect();
    let together = run::fly(&mission, &mission.motion, &scenarios, &mut |_| Continue::Yes);
    for (i, scenario) in scenarios.iter().enumerate() {
        let alone = last(&mission, &mission.motion, scenario.errors);
        assert_eq!(alone, together.outcomes[i].last, "{}", scenario.id);
    }
}

/// An independent navigator (matrices, small substeps, no series, no lanes) of the same mission with large errors.
#[test]
fn independent_navigator_agrees() {
    use nalgebra::{Matrix3, Rotation3, Vector3};
    let mission = Mission::new(site(), 0.01, 600.0, 600.0, swing()).unwrap();
    let mut errors = ImuErrors::default();
    for (i, source) in ErrorSource::all().iter().enumerate() {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        let size = match source.kind {
            Kind::Bias => 1e-5,
            Kind::AccelerationSensitive => 1e-6,
            _ => 1e-3,
        };
        source.set(&mut errors, sign * size * (1.0 + i as f64 / 10.0));
    }
    let fast = last(&mission, &mission.motion, errors);
    // rates from differences of the attitude itself
    let Attitude { pitch, roll, yaw } = mission.motion.attitude;
    let attitude = |t: f64| {
        Rotation3::from_axis_angle(&Vector3::z_axis(), yaw.at(t))
            * Rotation3::from_axis_angle(&Vector3::x_axis(), pitch.at(t))
            * Rotation3::from_axis_angle(&Vector3::y_axis(), roll.at(t))
    };
    let earth_rate = Vector3::from(earth::earth_rate(site().latitude_rad));
    let gravity = Vector3::new(0.0, 0.0, earth::normal_gravity(site().latitude_rad, 0.0));
    let apply = |e: &crate::navigate::errors::TriadErrors, x: Vector3<f64>| {
        let k = Matrix3::from_fn(|i, j| e.matrix[i][j]);
        x + k * x + Vector3::from(e.bias) + Vector3::from(e.square).component_mul(&x.component_mul(&x))
    };
    let (h, n) = (1e-3, 600_000);
    let mut c = attitude(0.0).into_inner();
    let (mut v, mut latitude_rad, mut longitude_rad) = (Vector3::zeros(), site().latitude_rad, site().longitude_rad);
    for i in 0..n {
        let t = (i as f64 + 0.5) * h;
        let turn = (attitude(t - 0.5 * h).inverse() * attitude(t + 0.5 * h)).scaled_axis() / h;
        let middle = attitude(t);
        let specific = middle.inverse() * gravity;
        let drift = Matrix3::from_fn(|i, j| errors.drift[i][j]) * specific;
        let rate = apply(&errors.gyro, middle.inverse() * earth_rate + turn) + drift;
        let force = apply(&errors.accelerometer, specific);
        let frame = |v: &Vector3<f64>, latitude_rad: f64| {
            let transport = Vector3::from(earth::transport_rate(latitude_rad, 0.0, [v.x, v.y]));
            let earth = Vector3::from(earth::earth_rate(latitude_rad));
            (earth + transport, 2.0 * earth + transport)
        };
        let (own, _) = frame(&v, latitude_rad);
        let half = Rotation3::new(-own * 0.5 * h).into_inner() * c * Rotation3::new(rate * 0.5 * h).into_inner();
        let (_, coriolis) = frame(&v, latitude_rad);
        let mut change = half * force - coriolis.cross(&v);
        change.z = 0.0;
        let v_mid = v + change * 0.5 * h;
        let (own, coriolis) = frame(&v_mid, latitude_rad);
        let mut change = half * force - coriolis.cross(&v_mid);
        change.z = 0.0;
        c = Rotation3::new(-own * h).into_inner() * c * Rotation3::new(rate * h).into_inner();
        let v_new = v + change * h;
        let mean = 0.5 * (v + v_new);
        let radii = earth::Curvature::at(latitude_rad, 0.0);
        latitude_rad += h * mean.y / radii.meridian;
        longitude_rad += h * mean.x / (radii.prime_vertical * latitude_rad.cos());
        v = v_new;
    }
    let wrong = c * attitude(n as f64 * h).into_inner().transpose();
    let phi = -Rotation3::from_matrix_unchecked(wrong).scaled_axis();
    let radii = earth::Curvature::at(site().latitude_rad, 0.0);
    let position = [
        (longitude_rad - site().longitude_rad) * radii.prime_vertical * site().latitude_rad.cos(),
        (latitude_rad - site().latitude_rad) * radii.meridian,
    ];
    println!("lanes:       {fast:?}\nindependent: {phi:?} {v:?} {position:?}");
    for i in 0..3 {
        assert!((fast.attitude[i] - phi[i]).abs() < 1e-5 * phi.norm());
    }
    for i in 0..2 {
        assert!((fast.velocity[i] - v[i]).abs() < 1e-5 * v.norm());
        assert!((fast.position[i] - position[i]).abs() < 1e-5 * position[0].hypot(position[1]));
    }
}
