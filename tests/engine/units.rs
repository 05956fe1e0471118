//! Units: parsed, converted, inferred from model lines; conversions by an independent script, and what must hold for any of them.

use crate::support::*;
use tumble::bench;
use tumble::campaign::{Inferred, Role};
use tumble::units::Unit;
use tumble::wire::{Source, read_bench, read_campaign, read_truth};

fn unit(text: &str) -> Unit {
    Unit::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[test]
fn conversions_are_those_of_an_independent_table() {
    let table = json("unit_conversions.json");
    let rows = table.as_array().expect("rows");
    assert!(rows.len() > 200);
    for row in rows {
        let (from, to) = (row["from"].as_str().expect("a unit"), row["to"].as_str().expect("a unit"));
        let found = unit(from).conversion(&unit(to)).map(|c| c.factor());
        match row["factor"].as_str() {
            None => assert_eq!(found, None, "{from} is no {to}"),
            Some(text) => {
                let factor: f64 = text.parse().expect("a number");
                let found = found.unwrap_or_else(|| panic!("{from} converts to {to}"));
                assert!((found / factor - 1.0).abs() < 2e-15, "{from} in {to}: {found:e}, not {factor:e}");
            }
        }
    }
}

/// As loggers in German, French and Chinese write rates, temperatures, times and pressures: sizes from the definitions of the units (a turn is 360 degrees).
#[test]
fn units_of_other_languages_convert() {
    let alike = [
        ("U/min", "deg/s", 6.0),
        ("Umdrehungen/Minute", "deg/s", 6.0),
        ("Upm", "deg/s", 6.0),
        ("U/s", "deg/s", 360.0),
        ("mV/(U/min)", "mV/(deg/s)", 1.0 / 6.0),
        ("tr/min", "deg/s", 6.0),
        ("tours/minute", "deg/s", 6.0),
        ("转/分", "deg/s", 6.0),
        ("圈/秒", "deg/s", 360.0),
        ("rpm", "deg/s", 6.0),
        ("rev/min", "deg/s", 6.0),
        ("Grad/sek", "deg/s", 1.0),
        ("Grad/Stunde", "deg/h", 1.0),
        ("degrés/seconde", "deg/s", 1.0),
        ("degr\u{e9}/heure", "deg/h", 1.0),
        ("度/小时", "deg/h", 1.0),
        ("°/s", "deg/s", 1.0),
        ("deg/sec", "deg/s", 1.0),
        ("Bogensekunden", "arcsec", 1.0),
        ("角分", "arcsec", 60.0),
        ("Cel", "degC", 1.0),
        ("CEL", "degC", 1.0),
        ("°C", "degC", 1.0),
        ("摄氏度", "degC", 1.0),
        ("jours", "h", 24.0),
        ("Tage", "h", 24.0),
        ("heures", "s", 3600.0),
        ("Sek", "s", 1.0),
        ("mbar", "Pa", 100.0),
        ("毫巴", "hPa", 1.0),
        ("千帕", "hPa", 10.0),
        ("微伏", "V", 1e-6),
        ("毫安", "A", 1e-3),
    ];
    for (theirs, ours, factor) in alike {
        let found = unit(theirs).conversion(&unit(ours)).unwrap_or_else(|| panic!("{theirs} converts to {ours}"));
        assert!((found.factor() / factor - 1.0).abs() < 2e-15, "{theirs} in {ours}: {}", found.factor());
    }
    // a voltage's symbol over its unit is no unit
    assert!(Unit::parse("U/mV").is_err());
    // a shaft's 1/min may be turns or radians
    for bare in ["1/min", "min-1"] {
        assert_eq!(unit(bare).conversion(&unit("deg/s")), None, "{bare}");
    }
}

/// Units of all coefficients of the built-in benches, read off the published model equations by hand.
#[test]
fn every_coefficient_of_a_built_in_bench_has_its_unit() {
    let expected: &[(&str, &[(&str, &str)])] = &[
        ("gyro-turntable", &[("V0", "V"), ("kI", "V/(deg/s)"), ("kII kIO kIS kOS", "V/(deg/s)^2")]),
        ("accelerometer-plumb-plane", &[("V0", "V"), ("kI", "V/g")]),
        ("accelerometer-dividing-head", &[("K0", "V"), ("K1 KP KO", "V/g"), ("K2 KIP KIO", "V/g^2"), ("K3", "V/g^3")]),
        (
            "imu-three-axis-table",
            &[
                ("Kgx Kgy Kgz", "pulse/s/(deg/s)"),
                ("Egxy Egxz Egyx Egyz Egzx Egzy Eaxy Eaxz Eayx Eayz Eazx Eazy", "1"),
                ("Dx0 Dy0 Dz0 Ax0 Ay0 Az0", "pulse/s"),
                ("Kax Kay Kaz", "pulse/s/g"),
                ("Kxx Kyy Kzz", "pulse/s/g^2"),
            ],
        ),
        (
            "gyro-skew-triad",
            &[
                ("D1 D2 D3", "pulse/s"),
                ("E1x E1y E1z E2x E2y E2z E3x E3y E3z", "pulse/s/(deg/h)"),
                ("G1x G1y G1z G2x G2y G2z G3x G3y G3z", "pulse/s/g"),
                ("P1x P1y P1z P2x P2y P2z P3x P3y P3z", "pulse/s/g^2"),
                ("DI1 DI2 DI3 DS1 DS2 DS3", "deg/h/g"),
            ],
        ),
        (
            "cube-mirror",
            &[(
                "oA mark cHA_mark colA base cHA_B heading cHA_M pitch cVA_M compA iA oB cHB_A colB cube roll cHB_N cVB_N compB iB \
                 d_heading d_pitch d_roll",
                "arcsec",
            )],
        ),
    ];
    for (id, groups) in expected {
        let text = bench::built_in(id).expect("a bench").text;
        let bench = read_bench(&Source { name: (*id).into(), text: text.into() }).expect("a bench");
        let units = Inferred::new(&bench, &["face".to_string()], &[]);
        assert!(units.conflicts().is_empty(), "{id}: {:?}", units.conflicts());
        for (names, wanted) in *groups {
            for name in names.split_whitespace() {
                let found = units.unit(name).unwrap_or_else(|| panic!("{id}: no unit of {name}"));
                assert!(
                    found.conversion(&unit(wanted)).is_some_and(|c| c.is_none()),
                    "{id}: {name} in {}",
                    found.symbol()
                );
            }
        }
    }
}

/// The units of coefficients in lines of many kinds; `-` where the line leaves a unit open.
#[test]
fn units_follow_from_the_line() {
    let cases = [
        // line, sensor unit, rate unit, coefficients and their units
        ("V0 + D_S*a_S + kIS*w_I*a_S", "mV", "rad/s", "V0 mV, D_S mV/g, kIS mV/(rad/s*g)"),
        ("K*(w_I + E*w_S) + B", "LSB", "deg/s", "K LSB/(deg/s), E 1, B LSB"),
        ("K*(1 + kT*(temperature_c - T0))*a_I", "V", "deg/s", "K V/g, kT 1/degC, T0 degC"),
        (
            "b + d*time_s + q*time_s^2 + r*exp(-time_s/tau)",
            "deg/h",
            "deg/s",
            "b deg/h, d deg/h/s, q deg/h/s^2, r deg/h, tau s",
        ),
        ("s1*sin(2*gamma + phi) + n*gamma", "V", "deg/s", "s1 V, phi rad, n V/rad"),
        ("A*sin(f*time_s)", "V", "deg/s", "A V, f rad/s"),
        ("A*sin(2*pi*f*time_s)", "V", "deg/s", "A V, f turn/s"),
        ("k*sqrt(abs(a_I)) + c", "V", "deg/s", "k V/g^0.5, c V"),
        ("p*q*a_I", "V", "deg/s", "p -, q -"),
        ("heading + atan(t)*180/pi", "deg", "deg/s", "heading deg, t 1"),
        ("k*atan(t)*7/pi", "deg", "deg/s", "k -, t 1"),
        ("a + b*x", "", "deg/s", "a -, b -"),
        ("a + b*x", "mm", "deg/s", "a mm, b -"),
        ("a + b*x", "Grad", "deg/s", "a Grad, b -"),
        ("a + b*(x - 20)", "degC", "deg/s", "a degC, b -"),
        ("a*(1 - 2*x) + b*x", "degC", "deg/s", "a degC, b degC"),
        ("K*(w_I - gamma_deg_s)", "V", "deg/s", "K V/(deg/s)"),
    ];
    for (line, sensor, rate, expected) in cases {
        let text = serde_json::json!({ "id": "b", "units": { "rate": rate },
            "chain": [{ "joint": "gamma", "about": "z" }],
            "sensors": { "Y": { "unit": sensor, "axes": { "I": "x", "S": "y" }, "model": line } } });
        let bench = read_bench(&Source { name: "b".into(), text: text.to_string() }).expect("a bench");
        let columns = ["time_s", "temperature_c", "x", "gamma_deg_s"].map(str::to_string);
        let units = Inferred::new(&bench, &columns, &[]);
        for pair in expected.split(", ") {
            let (name, wanted) = pair.split_once(' ').expect("a name and a unit");
            let found = units.unit(name);
            match (wanted, found) {
                ("-", None) => {}
                (wanted, Some(found)) if wanted != "-" => {
                    let wanted = units.parse(wanted).expect("a unit");
                    let same = found.conversion(&wanted).is_some_and(|c| c.is_none());
                    let dimension = found.dimension() == wanted.dimension();
                    assert!(same && dimension, "{line}: {name} in {}, not {}", found.symbol(), wanted.symbol());
                    assert_eq!(units.parse(found.symbol()).expect("its own symbol").dimension(), found.dimension());
                }
                (wanted, found) => panic!("{line}: {name} in {:?}, not {wanted}", found.map(Unit::symbol)),
            }
        }
    }
}

fn campaign_text(section: &str) -> String {
    format!(
        r#"{{ "bench": "gyro-turntable", {section},
            "readings": [ {{"alpha_deg": 0, "beta_deg": [0, 90], "gamma_deg_s": [20, -20]}} ] }}"#
    )
}

#[test]
fn numbers_of_a_campaign_are_converted() {
    let campaign = parse(&campaign_text(
        r#""known": { "kI": { "value": -167.4297, "u": 1.0, "unit": "V/(rad/s)" }, "dtheta_y1": { "value": 2, "unit": "arcmin" } },
           "estimate": { "V0": { "prior": 12, "prior_u": 3, "unit": "mV" }, "dtheta_y2": {}, "kII": { "start": 5, "unit": "uV/(deg/s)^2" } },
           "constraints": [ { "of": { "V0": 1 }, "between": [-20, 20], "unit": "mV" },
                            { "of": { "dtheta_y2": 1 }, "between": [null, 100], "unit": "urad" } ],
           "derived": { "ratio": "V0/kI", "twice": "2*dtheta_y2", "bias": { "line": "V0/kI", "unit": "deg/h" },
                        "error": { "line": "kI/2.9 - 1", "unit": "ppm" },
                        "azimuth": { "line": "dtheta_y2/2", "unit": "arcsec" } }"#,
    ));
    let known = |id: &str| match &campaign.parameters[campaign.parameter_index(id).expect("a parameter")].role {
        Role::Known(known) => (known.value, known.u),
        other => panic!("{other:?}"),
    };
    // pi/180 of the value: 167.4297 V/(rad/s) is 2.92219953062635... V/(deg/s) (mpmath)
    assert_within(known("kI").0, -2.922_199_530_626_35, 1e-13, "kI");
    assert_within(known("kI").1, std::f64::consts::PI / 180.0, 1e-17, "u of kI");
    assert_within(known("dtheta_y1").0, 120.0 * ARCSEC, 1e-18, "a tilt in arcmin");
    let v0 = &campaign.parameters[campaign.parameter_index("V0").expect("V0")];
    assert!(matches!(v0.role, Role::Estimated { prior: Some(p), .. } if p.value == 0.012 && p.u == 0.003));
    assert_eq!(v0.unit, "V");
    let k2 = &campaign.parameters[campaign.parameter_index("kII").expect("kII")];
    assert!(matches!(k2.role, Role::Estimated { start: Some(start), .. } if start == 5e-6));
    let bounds: Vec<(f64, f64)> = campaign
        .constraints
        .iter()
        .map(|c| match c {
            tumble::campaign::Constraint::Linear { lower, upper, .. } => (*lower, *upper),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(bounds, [(-0.02, 0.02), (f64::NEG_INFINITY, 1e-4)]);
    let of = |id: &str| campaign.derived.iter().find(|d| d.id == id).and_then(|d| campaign.unit_of(&d.line));
    assert!(of("ratio").expect("a unit").conversion(&unit("deg/s")).is_some_and(|c| c.is_none()));
    assert!(of("twice").expect("a unit").dimension().is_angle());
    let unit_of =
        |id: &str| campaign.derived.iter().find(|d| d.id == id).map(|d| (d.unit.as_str(), d.line.to_string()));
    assert_eq!(unit_of("bias"), Some(("deg/h", "V0/kI*3600".to_string())));
    assert_eq!(unit_of("error"), Some(("ppm", "(kI/2.9 - 1)*1000000".to_string())));
    assert_eq!(unit_of("azimuth").map(|(unit, _)| unit), Some("arcsec"));
    let truth = r#"{ "values": { "kI": { "value": -167.4297, "unit": "V/(rad/s)" } },
        "noise": { "V": { "sd": 0.5, "unit": "mV" } },
        "effects": [ { "regressor": "a_S", "value": 3, "unit": "mV/g" }, { "regressor": "tilt:dtheta_z2", "value": 10, "unit": "arcsec" } ] }"#;
    let truth = read_truth(&Source { name: "t".into(), text: truth.into() }, &campaign).expect("a truth");
    assert_within(truth.point[campaign.parameter_index("kI").expect("kI")], -2.922_199_530_626_35, 1e-13, "true kI");
    assert_eq!((truth.noise[0].sd, truth.effects[0].value), (5e-4, 3e-3));
    assert_within(truth.effects[1].value, 10.0 * ARCSEC, 1e-19, "a hidden tilt");
}

#[test]
fn what_does_not_fit_is_refused_with_the_unit_that_would() {
    let refused = |section: &str, path: &str, expected: &str| {
        let text = campaign_text(section);
        let error = read_campaign(&Source { name: "c".into(), text }, &mut |_| unreachable!()).expect_err(section);
        assert_eq!(error.place().path, path, "{error}");
        assert!(error.expectation().is_some_and(|e| e.contains(expected)), "{error}");
        assert!(error.place().line > 0, "{error}");
    };
    let v0 = r#""estimate": { "V0": {} }"#;
    refused(&format!(r#""known": {{ "kI": {{ "value": 1, "unit": "V/g" }} }}, {v0}"#), "known.kI.unit", "V/(deg/s)");
    refused(&format!(r#""known": {{ "kI": {{ "value": 1, "unit": "furlongs" }} }}, {v0}"#), "known.kI.unit", "arcsec");
    refused(
        &format!(r#""known": {{ "dtheta_y1": {{ "value": 1, "unit": "V" }} }}, {v0}"#),
        "known.dtheta_y1.unit",
        "rad",
    );
    refused(r#""estimate": { "V0": { "prior": 1, "prior_u": 1, "unit": "mg" } }"#, "estimate.V0.unit", "V");
    refused(&format!(r#"{v0}, "derived": {{ "x": {{ "line": "V0/kI", "unit": "g" }} }}"#), "derived.x.unit", "deg/s");
    refused(
        &format!(r#"{v0}, "constraints": [ {{ "of": {{ "V0": 1 }}, "equals": 1, "unit": "arcsec" }} ]"#),
        "constraints[0].unit",
        "V",
    );
    let campaign = parse(&campaign_text(v0));
    for (text, path) in [
        (r#"{ "values": { "kI": { "value": 1, "unit": "mV" } } }"#, "values.kI.unit"),
        (r#"{ "noise": { "V": { "sd": 1, "unit": "g" } } }"#, "noise.V.unit"),
        (r#"{ "effects": [ { "regressor": "a_S", "value": 1, "unit": "mV" } ] }"#, "effects[0].unit"),
    ] {
        let error = read_truth(&Source { name: "t".into(), text: text.into() }, &campaign).expect_err(text);
        assert_eq!(error.place().path, path, "{error}");
    }
}

#[test]
fn a_temperature_in_kelvin_is_another_number_in_degrees_celsius() {
    let text = |unit: &str| {
        format!(
            r#"{{ "bench": {{ "id": "t", "sensors": {{ "y": {{ "unit": "V", "model": "a + b*(temperature_c - T0)" }} }} }},
                "known": {{ "T0": {{ "value": 293.15, "unit": "{unit}", "u": 0.5 }} }}, "estimate": {{ "a": {{}}, "b": {{}} }},
                "readings": [ {{"temperature_c": 20, "y": 1}}, {{"temperature_c": 30, "y": 2}} ] }}"#
        )
    };
    let campaign = parse(&text("K"));
    let known = campaign.parameters.iter().find(|p| p.id == "T0").expect("T0");
    let tumble::campaign::Role::Known(own) = &known.role else { panic!("{known:?}") };
    // 293.15 K is 20 degC, and an uncertainty of 0.5 K is one of 0.5 degC
    assert!((own.value - 20.0).abs() < 1e-12 && own.u == 0.5 && known.unit == "degC", "{known:?}");
    assert_eq!(parse(&text("degC")).parameters.iter().find(|p| p.id == "b").expect("b").unit, "V/degC");
}

/// A unit that the line leaves open is carried as it is given, and tells the others.
#[test]
fn a_stated_unit_tells_what_the_line_leaves_open() {
    let text = r#"{ "bench": { "id": "line", "sensors": { "y": { "unit": "mm", "model": "p*q*time_s" } } },
        "known": { "p": { "value": 2, "unit": "mm/V" } }, "estimate": { "q": { "start": 1 } },
        "readings": [ {"time_s": 1, "y": 1}, {"time_s": 2, "y": 2} ] }"#;
    let campaign = parse(text);
    let of = |id: &str| &campaign.parameters.iter().find(|p| p.id == id).expect("a parameter").unit;
    assert_eq!(of("p"), "mm/V");
    assert!(unit(of("q")).conversion(&unit("V/s")).is_some_and(|c| c.is_none()), "{}", of("q"));
}

/// A pure number may have a size: mg/g is 0.001. The same accelerometer, offset 5 mg and scale factor 1.002, in the units in which loggers write it.
#[test]
fn derived_quantities_know_the_size_of_a_pure_number() {
    for (sensor, size) in [("g", 1.0), ("mg", 1e3), ("ug", 1e6), ("m/s^2", 9.80665), ("Gal", 980.665)] {
        let reading = |gamma: f64| {
            let value = size * (0.005 + 1.002 * gamma.to_radians().sin());
            format!(r#"{{"theta_deg": {gamma}, "A": {value}, "A_u": {}}}"#, 1e-6 * size)
        };
        let readings: Vec<String> = [0.0, 30.0, 90.0, 150.0, 180.0, 270.0].map(reading).to_vec();
        let text = format!(
            r#"{{ "bench": {{ "id": "head", "units": {{ "force": "g" }}, "chain": [{{"joint": "theta", "about": "x"}}],
                  "sensors": {{ "A": {{ "unit": "{sensor}", "axes": {{"I": "y"}}, "model": "K0 + K1*a_I" }} }} }},
                "estimate": {{ "K0": {{}}, "K1": {{}} }},
                "derived": {{ "bias": {{ "line": "K0/K1", "unit": "ug" }}, "scale": {{ "line": "K1", "unit": "1" }},
                              "error": {{ "line": "K1/{size} - 1", "unit": "ppm" }} }},
                "readings": [{}] }}"#,
            readings.join(",")
        );
        let fit = fitted(&parse(&text));
        let value = |id: &str| fit.derived.iter().find(|own| own.id == id).and_then(|own| own.value).expect("a value");
        assert_within(value("bias"), 5000.0 / 1.002, 1e-4, sensor);
        assert_within(value("scale"), 1.002, 1e-10, sensor);
        assert_within(value("error"), 2000.0, 1e-3, sensor);
    }
    // terms of unlike size do not add to one of either
    let text = r#"{ "bench": { "id": "two", "sensors": { "y": { "unit": "deg/h", "model": "p" }, "z": { "unit": "deg/s", "model": "r" } } },
        "estimate": { "p": {}, "r": {} }, "derived": { "sum": { "line": "p + r", "unit": "deg/h" } },
        "readings": [ {"y": 1, "z": 1}, {"y": 2, "z": 2} ] }"#;
    let error =
        read_campaign(&Source { name: "c".into(), text: text.into() }, &mut |_| unreachable!()).expect_err("units");
    assert!(error.to_string().contains("is not known"), "{error}");
}
