//! Numbers that are known in closed form or worked by hand.

#[test]
fn a_cause_has_its_name() {
    use crate::navigate::cause::{Cause, Change};
    assert_eq!(Cause::Reference(2, Some(Change::Ramp)).id(), "reference:phi_up_arcsec:ramp");
}

#[test]
fn means_of_changes() {
    use crate::navigate::cause::Change;
    assert_eq!(Change::Step(3.0).mean(2.0, 4.0), 0.5);
    // 2/pi over half a wave
    let half = Change::Wave { period: 4.0, phase: 0.0 }.mean(0.0, 2.0);
    assert!((half - std::f64::consts::FRAC_2_PI).abs() < 1e-15);
}

#[test]
fn normal_gravity_at_the_equator_and_the_pole() {
    use crate::navigate::earth::normal_gravity;
    assert!((normal_gravity(0.0, 0.0) - 9.780_325_335_9).abs() < 1e-10);
    assert!((normal_gravity(90_f64.to_radians(), 0.0) - 9.832_184_9).abs() < 1e-6);
}

#[test]
fn radii_at_the_equator() {
    let equator = crate::navigate::earth::Curvature::at(0.0, 0.0);
    assert!((equator.meridian - 6_335_439.327).abs() < 1e-3);
    assert!((equator.prime_vertical - 6_378_137.0).abs() < 1e-9);
}

#[test]
fn sources_with_the_start() {
    use crate::navigate::errors::ErrorSource;
    assert_eq!(ErrorSource::catalogue().len(), 46);
    assert_eq!(ErrorSource::catalogue()[41].id(), "start_attitude_up");
}

#[test]
fn sources_in_their_order() {
    use crate::navigate::errors::ErrorSource;
    assert_eq!(ErrorSource::all().len(), 39);
    assert_eq!(ErrorSource::all()[32].id(), "gyro_acceleration_sensitive_xz");
    assert_eq!(ErrorSource::first_order().len(), 24);
    assert_eq!(ErrorSource::all()[7].id(), "gyro_installation_xz");
}

#[test]
fn schuler_and_the_earth() {
    use crate::navigate::{linear, mission::Site};
    let site = Site { latitude_rad: 45.7796_f64.to_radians(), longitude_rad: 0.0, altitude_m: 0.0 };
    let [earth, slow, fast] = linear::frequencies(site).unwrap();
    let minutes = std::f64::consts::TAU / (0.5 * (slow + fast)) / 60.0;
    assert!((minutes - 84.4).abs() < 0.1);
    assert!((earth / 7.292115e-5 - 1.0).abs() < 1e-9);
}

#[test]
fn a_tilt_is_felt_as_gravity() {
    use crate::navigate::{linear, mission::Site};
    let site = Site { latitude_rad: 45_f64.to_radians(), longitude_rad: 0.0, altitude_m: 0.0 };
    let f = linear::dynamics(&linear::at_rest(site));
    assert!((f[3][1] + 9.806_2).abs() < 1e-4); // a tilt about north is felt as a westward force
}

#[test]
fn a_position_is_in_the_last_channels() {
    use crate::navigate::{measured::channels, run::NavigationError};
    let error = NavigationError { position: [3.0, 4.0], ..Default::default() };
    assert_eq!(channels(&error)[5..], [3.0, 4.0]);
}

#[test]
fn a_square_is_integrated_exactly() {
    use crate::navigate::quadrature::Quadrature;
    let rule = Quadrature::new(60);
    let third: f64 = rule.nodes.iter().zip(rule.weights.iter()).map(|(x, w)| x.powi(2) * w[59]).sum();
    let exact = (1.0 - (59.0_f64 / 60.0).powi(3)) / 3.0;
    assert!((third - exact).abs() < 1e-16);
}

#[test]
fn a_perfect_unit_stays() {
    use crate::navigate::{
        mission::{Mission, Site},
        motion::Motion,
        run::{self, Continue, Scenario},
    };
    let site = Site { latitude_rad: 0.8, longitude_rad: 0.0, altitude_m: 0.0 };
    let mission = Mission::new(site, 0.01, 600.0, 60.0, Motion::default()).unwrap();
    let perfect = Scenario { id: "none".into(), errors: Default::default() };
    let flight = run::fly(&mission, &mission.motion, &[perfect], &mut |_| Continue::Yes);
    assert!(flight.outcomes[0].position.max < 1e-6);
}

#[test]
fn groups_of_sources() {
    use crate::navigate::{
        errors::{ErrorSource, ImuErrors},
        study::{FlownTogether, scenarios},
    };
    let mut errors = ImuErrors::default();
    for id in ["gyro_bias_x", "gyro_bias_y", "accelerometer_bias_x"] {
        ErrorSource::named(id).unwrap().set(&mut errors, 1e-6);
    }
    let ids: Vec<String> = scenarios(&errors, FlownTogether::Groups).into_iter().map(|s| s.id).collect();
    assert_eq!(ids, ["all", "gyro_bias", "accelerometer_bias", "perfect_unit"]);
}
