//! Units: how they are written, what cancels, products, and what must hold for any of them.

use crate::units::Unit;
use proptest::prelude::*;
use tumble::error::Fault;

fn unit(text: &str) -> Unit {
    Unit::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}
#[test]
fn what_cancels_cancels_exactly() {
    for (from, to, value, expected) in [
        ("mV/g", "V/g", 1299.0, 1.299),
        ("mV/(deg/s)", "V/(deg/s)", -2922.0, -2.922),
        ("deg/h", "arcsec/s", 15.041067, 15.041067),
        ("deg", "arcsec", 0.5, 1800.0),
        ("ppm", "1", 35.0, 35e-6),
        ("ug/g^2", "mg/g^2", 7.0, 7e-3),
        ("g", "m/s^2", 1.0, 9.80665),
    ] {
        let found = unit(from).conversion(&unit(to)).expect("a conversion").apply(value);
        assert_eq!(found, expected, "{value} {from} in {to}");
    }
}

/// "Grad" is the German degree; a "grad" may be that or a gon, and is neither.
#[test]
fn a_grad_is_not_guessed() {
    let error = Unit::parse("grad").expect_err("two meanings");
    assert!(error.to_string().contains("no unit is called 'grad'"), "{error}");
    let full = |text: &str| unit(text).conversion(&unit("turn")).map(|c| c.apply(1.0));
    assert_eq!((full("Grad"), full("gon")), (Some(1.0 / 360.0), Some(1.0 / 400.0)));
}

/// One of each unit as people spell it, in SI units (of temperatures: of zero); factors by hand from the definitions.
#[test]
fn units_as_people_spell_them() {
    let degree = std::f64::consts::PI / 180.0;
    for (texts, si, expected) in [
        (&["rad s-1", "rad s^-1", "rad·s⁻¹", "rad/sec", "RAD/s", "radians per second", "rad.s-1"][..], "rad/s", 1.0),
        (
            &["deg/s", "°/s", "º/s", "˚/s", "dps", "DPS", "Deg/s", "degrees/second", "度/秒", "deg s-1", "Grad/s"],
            "rad/s",
            degree,
        ),
        (&["mdps", "mdeg/s", "millidegrees per second"], "rad/s", 1e-3 * degree),
        (&["m/s2", "m s-2", "m/s²", "m·s⁻²", "m/s/s", "m/sec^2", "m.s-2"], "m/s^2", 1.0),
        (&["ms", "msec", "milliseconds", "毫秒", "millisec."], "s", 1e-3),
        (&["us", "µs", "usec", "microseconds"], "s", 1e-6),
        (&["min", "Min", "mins", "minutes", "min."], "s", 60.0),
        (&["h", "hr", "hours", "Stunden"], "s", 3600.0),
        (&["d", "day", "days"], "s", 86_400.0),
        (&["hPa", "HPA", "mbar", "mBar", "millibar"], "Pa", 100.0),
        (&["mmHg"], "Pa", 133.322387415),
        (&["Torr"], "Pa", 101_325.0 / 760.0),
        (&["psi"], "Pa", 4.4482216152605 / 0.0254 / 0.0254),
        (&["mV", "millivolts", "mVolt"], "V", 1e-3),
        (&["K", "Kelvin", "kelvin", "degK", "deg K"], "K", 1.0),
    ] {
        for text in texts {
            let found = unit(text).conversion_for(&unit(si), text).unwrap_or_else(|error| panic!("{error}")).apply(1.0);
            assert!((found / expected - 1.0).abs() < 1e-14, "{text}: {found}");
        }
    }
    for (texts, zero) in [
        (&["degC", "°C", "℃", "C", "deg C", "° C", "Deg. C", "degrees Celsius", "celsius", "摄氏度", "ºC"][..], 273.15),
        (&["degF", "°F", "℉", "F", "deg F", "Fahrenheit"], 459.67 / 1.8),
        (&["K", "mK"], 0.0),
    ] {
        for text in texts {
            let found =
                unit(text).conversion_for(&unit("K"), text).unwrap_or_else(|error| panic!("{error}")).apply(0.0);
            assert!((found - zero).abs() < 1e-12, "{text}: {found}");
        }
    }
    // a prefix is not a spelling, and the number of a channel no power
    for text in ["MS", "mF", "V1", "s2", "Deg/s/Furlong", "rad s--1"] {
        let second = Unit::parse(text).ok().and_then(|own| own.conversion(&unit("s")).map(|own| own.apply(1.0)));
        assert!(Unit::parse(text).is_err() || (text == "MS" && second == Some(1e6)), "{text}");
    }
}

#[test]
fn faults_have_their_place() {
    for (text, fault, span) in [
        ("furlong", Fault::UnknownName, (0, 7)),
        ("V/(deg/sesc)", Fault::UnknownName, (7, 4)),
        ("V/(rad*/s)", Fault::Syntax, (7, 1)),
        ("V/(deg/s", Fault::Syntax, (8, 1)),
        ("V)", Fault::Syntax, (1, 1)),
        ("", Fault::Syntax, (0, 1)),
        ("2 V", Fault::Syntax, (0, 1)),
        ("V^x", Fault::Syntax, (2, 1)),
        ("V^99", Fault::Syntax, (2, 1)),
    ] {
        let error = Unit::parse(text).expect_err(text);
        assert_eq!((error.fault(), error.place().span), (fault, Some(span)), "{text}: {error}");
    }
    // a blank between two units is a product (SI brochure, 5.4.7)
    let dimension = |text: &str| Unit::parse(text).expect(text).dimension().clone();
    assert_eq!(dimension("rad s^-1"), dimension("rad*s^-1"));
    assert!(Unit::parse(&"(".repeat(150)).is_err());
    assert!(Unit::parse(&"V*".repeat(500)).is_err());
}

fn factors() -> impl Strategy<Value = Vec<(&'static str, i32)>> {
    let names = &[
        "V", "mV", "LSB", "pulse", "deg", "arcsec", "urad", "turn", "s", "h", "min", "g", "mg", "ug", "K", "ppm", "%",
        "Hz", "mm",
    ][..];
    prop::collection::vec((prop::sample::select(names), prop::sample::select(&[-3, -2, -1, 1, 2, 3][..])), 1..5)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    /// There and back; the printed symbol of a product reads as the same unit.
    #[test]
    fn a_conversion_comes_back(list in factors(), prefix in prop::sample::select(&["mV", "arcsec", "h", "ug"][..]), value in -1e6..1e6_f64) {
        let parts: Vec<(Unit, f64)> = list.iter().map(|(name, power)| (unit(name), f64::from(*power))).collect();
        let product = Unit::product(&parts);
        let read = unit(product.symbol());
        prop_assert!(read.conversion(&product).is_some_and(|c| c.is_none()), "{}", product.symbol());
        prop_assert_eq!(read.dimension(), product.dimension());
        let text: Vec<String> = list.iter().map(|(name, power)| format!("{name}^{power}")).collect();
        let written = unit(&text.join("*"));
        let other = unit(&format!("({})/{prefix}*{prefix}", text.join("*")));
        for (a, b) in [(&product, &written), (&written, &other)] {
            let there = a.conversion(b).expect("one dimension").apply(value);
            let back = b.conversion(a).expect("one dimension").apply(there);
            prop_assert!((back - value).abs() <= 1e-14 * value.abs(), "{value} {back}");
        }
    }
}

/// Names of data sheets, by their definitions.
#[test]
fn names_of_data_sheets() {
    for (text, same, factor) in [
        ("dps", "deg/s", 1.0),
        ("mdps", "deg/s", 1e-3),
        ("mdps/LSB", "deg/s/LSB", 1e-3),
        ("deg/hr", "deg/h", 1.0),
        ("deg/sqrt(hr)", "deg/sqrt(h)", 1.0),
        ("r/min", "deg/s", 6.0),
        ("mg", "g", 1e-3),
        ("ug", "g", 1e-6),
    ] {
        let found = unit(text).conversion(&unit(same)).unwrap().factor();
        assert!((found / factor - 1.0).abs() < 1e-15, "{text}: {found}");
    }
}

#[test]
fn product() -> tumble::Result<()> {
    let (volt, rate) = (Unit::parse("V")?, Unit::parse("deg/s")?);
    assert_eq!(Unit::product(&[(volt, 1.0), (rate, -2.0)]).symbol(), "V/(deg/s)^2");
    Ok(())
}

#[test]
fn reduced() -> tumble::Result<()> {
    let (drift, scale) = (Unit::parse("pulse/s/g")?, Unit::parse("pulse/s/(deg/h)")?);
    assert_eq!(Unit::reduced(&[(drift, 1.0), (scale, -1.0)]).symbol(), "deg/(g*h)");
    Ok(())
}
