//! The table of units: names, dimensions and sizes. A new unit is a new line here.
#![allow(clippy::indexing_slicing, reason = "evaluated when this is compiled: an index that is none would not build")]

use super::dimension::{ANGLE, BASES, COUNT, CURRENT, LENGTH, MASS, ONE, Scale, TEMPERATURE, TIME};

/// Dimension and size of a unit.
pub(super) struct Entry {
    pub base: [f64; BASES],
    pub scale: Scale,
    /// Is it a number of events for each second, which a counter shows as well?
    pub hertz: bool,
}

const fn is(powers: &[(usize, f64)]) -> [f64; BASES] {
    let mut base = [0.0; BASES];
    let mut k = 0;
    while k < powers.len() {
        base[powers[k].0] = powers[k].1;
        k += 1;
    }
    base
}

const NUMBER: [f64; BASES] = [0.0; BASES];
const IN_TIME: [f64; BASES] = is(&[(TIME, 1.0)]);
const AN_ANGLE: [f64; BASES] = is(&[(ANGLE, 1.0)]);
const A_COUNT: [f64; BASES] = is(&[(COUNT, 1.0)]);
const ACCELERATION: [f64; BASES] = is(&[(LENGTH, 1.0), (TIME, -2.0)]);
const PRESSURE: [f64; BASES] = is(&[(MASS, 1.0), (LENGTH, -1.0), (TIME, -2.0)]);
const FLUX_DENSITY: [f64; BASES] = is(&[(MASS, 1.0), (TIME, -2.0), (CURRENT, -1.0)]);

const fn ten(power: f64) -> Scale {
    Scale { ten: power, ..ONE }
}

const fn sixty(power: f64, degree: f64) -> Scale {
    Scale { sixty: power, degree, ..ONE }
}

const fn other(factor: f64, degree: f64) -> Scale {
    Scale { other: factor, degree, ..ONE }
}

const GRAVITY: Scale = Scale { gravity: 1.0, ..ONE };

/// Name, dimension, size, whether it takes SI prefixes (n u m k M), and the suffixes of column names with this unit (`supply_mv`).
const TABLE: &[(&str, [f64; BASES], Scale, bool, &str)] = &[
    // electrical outputs, and what is counted
    ("V", is(&[(MASS, 1.0), (LENGTH, 2.0), (TIME, -3.0), (CURRENT, -1.0)]), ONE, true, "v mv uv"),
    ("A", is(&[(CURRENT, 1.0)]), ONE, true, "ma"),
    ("ohm", is(&[(MASS, 1.0), (LENGTH, 2.0), (TIME, -3.0), (CURRENT, -2.0)]), ONE, true, ""),
    ("LSB", A_COUNT, ONE, false, ""),
    ("count", A_COUNT, ONE, false, ""),
    ("counts", A_COUNT, ONE, false, ""),
    ("digit", A_COUNT, ONE, false, ""),
    ("digits", A_COUNT, ONE, false, ""),
    ("pulse", A_COUNT, ONE, false, ""),
    ("pulses", A_COUNT, ONE, false, ""),
    ("Hz", is(&[(TIME, -1.0)]), ONE, true, "hz khz"),
    // angles
    ("rad", AN_ANGLE, ONE, true, "rad mrad urad"),
    ("deg", AN_ANGLE, sixty(0.0, 1.0), true, "deg"),
    ("arcmin", AN_ANGLE, sixty(-1.0, 1.0), false, "arcmin"),
    ("arcsec", AN_ANGLE, sixty(-2.0, 1.0), false, "arcsec"),
    ("turn", AN_ANGLE, other(360.0, 1.0), false, ""),
    ("turns", AN_ANGLE, other(360.0, 1.0), false, "turns"),
    ("rev", AN_ANGLE, other(360.0, 1.0), false, ""),
    ("gon", AN_ANGLE, other(0.9, 1.0), false, ""),
    // a turn a minute
    ("rpm", is(&[(ANGLE, 1.0), (TIME, -1.0)]), Scale { other: 360.0, degree: 1.0, sixty: -1.0, ..ONE }, false, "rpm"),
    ("rps", is(&[(ANGLE, 1.0), (TIME, -1.0)]), other(360.0, 1.0), false, ""),
    ("dps", is(&[(ANGLE, 1.0), (TIME, -1.0)]), sixty(0.0, 1.0), true, "dps mdps"),
    ("dph", is(&[(ANGLE, 1.0), (TIME, -1.0)]), sixty(-2.0, 1.0), false, "dph"),
    ("radps", is(&[(ANGLE, 1.0), (TIME, -1.0)]), ONE, false, "radps rads"),
    // time
    ("s", IN_TIME, ONE, true, "s sec ms us ns"),
    ("min", IN_TIME, sixty(1.0, 0.0), false, "min"),
    ("h", IN_TIME, sixty(2.0, 0.0), false, "h"),
    ("day", IN_TIME, Scale { sixty: 2.0, other: 24.0, ..ONE }, false, ""),
    // acceleration: g is standard gravity, so mg and ug are thousandths and millionths of it
    ("g", ACCELERATION, GRAVITY, true, "g mg ug"),
    ("Gal", ACCELERATION, ten(-2.0), true, ""),
    // temperature: intervals
    ("K", is(&[(TEMPERATURE, 1.0)]), ONE, true, "k mk"),
    ("degC", is(&[(TEMPERATURE, 1.0)]), ONE, false, "c degc"),
    ("degF", is(&[(TEMPERATURE, 1.0)]), other(5.0 / 9.0, 0.0), false, "f degf"),
    // pure numbers
    ("1", NUMBER, ONE, false, "here"),
    ("%", NUMBER, ten(-2.0), false, ""),
    ("ppm", NUMBER, ten(-6.0), false, "ppm"),
    ("ppb", NUMBER, ten(-9.0), false, ""),
    // lengths, and other quantities that a test records
    ("m", is(&[(LENGTH, 1.0)]), ONE, true, "m mm um"),
    ("cm", is(&[(LENGTH, 1.0)]), ten(-2.0), false, "cm"),
    ("kg", is(&[(MASS, 1.0)]), ONE, false, ""),
    ("N", is(&[(MASS, 1.0), (LENGTH, 1.0), (TIME, -2.0)]), ONE, true, ""),
    ("Pa", PRESSURE, ONE, true, "pa kpa"),
    ("hPa", PRESSURE, ten(2.0), false, "hpa"),
    ("bar", PRESSURE, ten(5.0), true, "bar mbar"),
    ("psi", PRESSURE, other(6894.757293168361, 0.0), false, "psi"),
    ("atm", PRESSURE, other(101_325.0, 0.0), false, ""),
    ("Torr", PRESSURE, other(101_325.0 / 760.0, 0.0), false, ""),
    ("mmHg", PRESSURE, other(133.322387415, 0.0), false, ""),
    ("W", is(&[(MASS, 1.0), (LENGTH, 2.0), (TIME, -3.0)]), ONE, true, ""),
    ("T", FLUX_DENSITY, ONE, true, "ut nt"),
    ("gauss", FLUX_DENSITY, ten(-4.0), true, "gauss"),
];

const PLURALS: &[&str] = &["counts", "digits", "pulses", "turns"];

const PREFIXES: &[(&str, f64)] = &[
    ("nano", -9.0),
    ("micro", -6.0),
    ("milli", -3.0),
    ("n", -9.0),
    ("u", -6.0),
    ("\u{b5}", -6.0),
    ("\u{3bc}", -6.0),
    ("m", -3.0),
    ("k", 3.0),
    ("M", 6.0),
];

/// The table's name of what may be written otherwise, in whichever case where that has three letters and more: fewer may be a prefix and a unit (`mS`, `MS`).
pub(crate) fn plain(name: &str) -> &str {
    let known = spelled(name).unwrap_or(name);
    if known != name || TABLE.iter().any(|(entry, ..)| *entry == name) || name.chars().count() < 3 {
        return known;
    }
    let lower = name.to_lowercase();
    let entry = TABLE.iter().map(|(entry, ..)| *entry).find(|entry| entry.to_lowercase() == lower);
    entry.or_else(|| spelled(&lower)).unwrap_or(name)
}

fn spelled(name: &str) -> Option<&'static str> {
    SPELLED.iter().find(|(words, _)| words.contains(&name)).map(|spelling| spelling.1)
}

/// The name with a slash in it that a text begins with.
pub(super) fn slashed(text: &str) -> Option<&'static str> {
    let ends = |name: &str| text.strip_prefix(name).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric));
    SPELLED.iter().flat_map(|(words, _)| words.iter().copied()).find(|name| name.contains('/') && ends(name))
}

/// Other spellings.
const SPELLED: &[(&[&str], &str)] = &[
    // (the signs of an ordinal and of a ring are written for that of a degree)
    (&["\u{b0}", "\u{ba}", "\u{2da}", "degree", "degrees", "degs", "degr\u{e9}", "degr\u{e9}s", "Grad", "度"], "deg"),
    (&["\u{2032}", "arcminute", "arcminutes", "bogenminute", "bogenminuten", "角分"], "arcmin"),
    (&["\u{2033}", "arcsecond", "arcseconds", "bogensekunde", "bogensekunden", "角秒"], "arcsec"),
    (&["\u{b0}C", "\u{ba}C", "\u{2da}C", "\u{2103}", "C", "celsius", "cel", "摄氏度"], "degC"),
    (&["\u{b0}F", "\u{ba}F", "\u{2da}F", "\u{2109}", "F", "fahrenheit", "华氏度"], "degF"),
    (&["degK", "kelvin", "开尔文"], "K"),
    (&["gn"], "g"),
    (&["radian", "radians", "弧度"], "rad"),
    (
        &[
            "r",
            "revs",
            "revolution",
            "revolutions",
            "umdr",
            "umdrehung",
            "umdrehungen",
            "tr",
            "tour",
            "tours",
            "转",
            "圈",
        ],
        "rev",
    ),
    // (the German Umdrehung; U alone is a voltage, as in `U/mV`)
    (&["U/min", "upm"], "rpm"),
    (&["U/s"], "rps"),
    (&["sec", "secs", "second", "seconds", "sek", "sekunde", "sekunden", "seconde", "secondes", "秒"], "s"),
    (&["毫秒"], "ms"),
    (&["微秒"], "us"),
    (&["mins", "minute", "minutes", "minuten", "分", "分钟"], "min"),
    (&["hr", "hrs", "hour", "hours", "stunde", "stunden", "std", "heure", "heures", "时", "小时"], "h"),
    (&["d", "days", "tag", "tage", "jour", "jours", "日", "天"], "day"),
    (&["volt", "volts", "伏", "伏特"], "V"),
    (&["毫伏"], "mV"),
    (&["微伏"], "uV"),
    (&["ampere", "amperes", "安", "安培"], "A"),
    (&["毫安"], "mA"),
    (&["\u{3a9}", "\u{2126}", "ohms", "欧", "欧姆"], "ohm"),
    (&["pascal", "帕"], "Pa"),
    (&["百帕"], "hPa"),
    (&["千帕"], "kPa"),
    (&["巴"], "bar"),
    (&["毫巴"], "mbar"),
    (&["赫", "赫兹"], "Hz"),
    (&["LSBs", "lsb", "lsbs"], "LSB"),
];

/// The entry of a name; `None` where the table does not have it.
pub(super) fn find(name: &str) -> Option<Entry> {
    let of = |base: &str, power: f64| {
        let entry = TABLE.iter().find(|(entry, _, _, prefixed, _)| *entry == base && (*prefixed || power == 0.0))?;
        Some(Entry { base: entry.1, scale: entry.2.times(ten(power), 1.0), hertz: entry.0 == "Hz" })
    };
    let prefixed = |name: &str| {
        let split = |(prefix, power): &(&str, f64)| Some((name.strip_prefix(prefix)?.to_string(), *power));
        PREFIXES.iter().filter_map(split).find_map(|(stem, power)| of(plain(&stem), power))
    };
    of(name, 0.0).or_else(|| prefixed(name)).or_else(|| of(plain(name), 0.0)).or_else(|| prefixed(plain(name)))
}

/// The unit from the suffix of a column's name: `temperature_c`, `gamma_deg_s`, `force_m_s2`.
pub(crate) fn of_column(name: &str) -> Option<String> {
    let lower = name.to_ascii_lowercase();
    let (stem, last) = lower.rsplit_once('_')?;
    let of = |end: &str| {
        let named = TABLE.iter().find(|(.., ends)| ends.split(' ').any(|other| other == end && !end.is_empty()))?;
        // the letter before a unit is its prefix
        let prefix = end.strip_suffix(&named.0.to_ascii_lowercase()).unwrap_or_default();
        Some(format!("{prefix}{}", named.0))
    };
    let time = match last {
        "s" => Some("s"),
        "s2" => Some("s^2"),
        "h" => Some("h"),
        _ => None,
    };
    // `rate_rad_per_s`
    let stem = stem.strip_suffix("_per").unwrap_or(stem);
    let above = stem.rsplit('_').next().and_then(of).filter(|unit| find(unit).is_some_and(|e| e.base != IN_TIME));
    match (above, time) {
        (Some(above), Some(time)) => Some(format!("{above}/{time}")),
        _ => of(last),
    }
}

/// Zero of a scale of temperature above 0 K, in its degrees.
pub(super) fn zero(name: &str) -> f64 {
    match plain(name) {
        "degC" => 273.15,
        "degF" => 459.67,
        _ => 0.0,
    }
}

/// The names of the table, as messages list them.
pub fn names() -> String {
    let all: Vec<&str> = TABLE.iter().map(|(name, ..)| *name).filter(|name| !PLURALS.contains(name)).collect();
    format!(
        "products, quotients and powers of {}, with n u m k M before V A ohm Hz rad deg dps s g Gal K m N Pa bar W T gauss",
        all.join(" ")
    )
}
