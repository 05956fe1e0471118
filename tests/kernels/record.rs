//! Cells of tables and packed arrays.

#[path = "../../src/record/clock.rs"]
pub(crate) mod clock;
#[path = "../../src/record/number.rs"]
mod number;
#[path = "../../src/record/times.rs"]
mod times;
#[path = "../../src/record/unpacked.rs"]
mod unpacked;

use number::{leading, number};
use std::io::Write;
use times::{Moment, Times, WrittenTimes, moment};
use tumble::record::{Column, Record, listed};
use unpacked::unpacked;

#[test]
fn numbers_are_those_of_the_standard_library() {
    for text in ["0", "-1", "3.14159", "1e3", "-2.5E-3", "33108", "0.1", "123456789.123456789", "1e400", "4.9e-324"] {
        let expected: f64 = text.parse().expect("a number");
        assert_eq!(number(text.as_bytes(), b'.'), Some(expected), "{text}");
        assert_eq!(number(text.replace('.', ",").as_bytes(), b','), Some(expected), "{text}");
    }
    assert_eq!(number(b"9007199254740993", b'.'), Some(9007199254740992.0));
    assert!(number(b"", b'.').is_some_and(f64::is_nan) && number(b" NaN ", b'.').is_some_and(f64::is_nan));
    for text in ["x", "1.2.3", "1,2", "1e", "--1", "inf", "12 34", "."] {
        assert!(!number(text.as_bytes(), b'.').is_some_and(f64::is_finite), "{text}");
    }
    assert_eq!(leading(b"12.5;7", b'.'), Some((12.5, 4)));
}

/// Digits are taken eight at a time: every number of them before and behind the mark, and what stands behind the number.
#[test]
fn digits_of_every_number() {
    let mut state = 1_u64;
    let mut digits = |count: usize| -> String {
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            char::from(b'0' + (state >> 33).to_le_bytes()[0] % 10)
        };
        (0..count).map(|_| next()).collect()
    };
    for whole in 0..24 {
        for part in 0..24 {
            for (sign, power) in [("", ""), ("-", "e-7"), ("+", "E12")] {
                let text = format!("{sign}{}.{}{power}", digits(whole), digits(part));
                for end in ["", ",", ";1234567", "/99999999", ":", "\n12345678", " ", "\u{e9}"] {
                    let expected =
                        if whole + part > 0 { Some((text.parse().expect("a number"), text.len())) } else { None };
                    assert_eq!(leading(format!("{text}{end}").as_bytes(), b'.'), expected, "{text}{end}");
                }
                let text = format!("{sign}{}{power}", digits(whole + 1));
                assert_eq!(
                    leading(text.as_bytes(), b'.'),
                    Some((text.parse().expect("a number"), text.len())),
                    "{text}"
                );
            }
        }
    }
}

/// Seconds since 1970 by `date -u -d TIME +%s`.
#[test]
fn written_times() {
    for (text, seconds) in [
        ("2024-03-31T01:59:55.250", 1_711_850_395.25),
        ("2024-03-31 01:59:55,25", 1_711_850_395.25),
        ("2024-03-31T01:59:55.25Z", 1_711_850_395.25),
        ("2024-03-31T03:59:55.25+02:00", 1_711_850_395.25),
        ("31.03.2024 01:59:55.25", 1_711_850_395.25),
        ("31.3.2024 01:59:55", 1_711_850_395.0),
        ("2024/03/31 01:59:55", 1_711_850_395.0),
        ("31/03/2024 01:59:55", 1_711_850_395.0),
        ("31.03.24 01:59:55", 1_711_850_395.0),
        ("3/31/2024 01:59:55", 1_711_850_395.0),
        ("31.03.2024 1:59:55:250", 1_711_850_395.25),
        // either number may be the day: the first one, until another date shows that it is not
        ("3/4/2024 01:00:00", 1_712_106_000.0),
    ] {
        assert_eq!(moment(text.as_bytes()), Some(Moment::Instant(seconds)), "{text}");
    }
    assert_eq!(moment(b"14:03:01.250"), Some(Moment::Of(50_581.25, 86_400.0)));
    for text in ["1.2.3", "1.2.34", "12", "3/4/24 01:00:00", "14:03:01:25", "12:30", "V", "2024-13-01T00:00:00"] {
        assert_eq!(moment(text.as_bytes()), None, "{text}");
    }
    let mut times = Times::default();
    let all: Vec<f64> = ["23:59:59.5", "00:00:00.0"].iter().filter_map(|t| times.seconds(t.as_bytes())).collect();
    assert!(matches!(all[..], [a, b] if b - a == 0.5));
    let since = |texts: &[&str]| {
        let mut times = WrittenTimes::default();
        texts.iter().map(|text| times.since_first(text)).collect::<Vec<_>>()
    };
    let day = 86_400.0;
    assert_eq!(
        since(&["3/4/2024 23:00:00", "4/4/2024 01:00:00", "4/6/2024 01:00:00"]),
        [0.0, 7200.0, 61.0 * day + 7200.0].map(Some)
    );
    assert_eq!(
        since(&["3/4/2024 23:00:00", "3/5/2024 01:00:00", "4/5/2024 01:00:00"]),
        [0.0, 7200.0, 31.0 * day + 7200.0].map(Some)
    );
    assert_eq!(since(&["3/4/2024 23:00:00", "4/5/2024 01:00:00"]), [Some(0.0), None]);
}

/// A megabyte of zeros packs into a thousand bytes; it is not unpacked further than the limit.
#[test]
fn a_small_file_does_not_fill_the_memory() {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(&[0; 1_000_000]).unwrap();
    let packed = packer.finish().unwrap();
    assert!(packed.len() < 2_000);
    assert_eq!(unpacked(&packed, 1_000_000).unwrap().len(), 1_000_000);
    assert_eq!(unpacked(&packed, 999_999).unwrap_err().to_string(), "more than 999999 bytes when it is unpacked");
    assert!(unpacked(&packed[..500], 1_000_000).is_err());
}
