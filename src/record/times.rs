//! Times as people write them: ISO 8601 with and without a zone, `20.11.2026 09:14:03`, `2026/11/20 09:14`, `14:03:01.250`.

use jiff::{Timestamp, civil, tz::TimeZone};

/// Times of day are put on this day, 2002-01-01, so that all written times are seconds since 1970.
const SOME_DAY: f64 = 1_009_843_200.0;
const DAY: f64 = 86_400.0;

/// A written time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Moment {
    /// Seconds since 1970; one without a zone is taken as UTC.
    Instant(f64),
    /// Seconds of a day.
    OfDay(f64),
}

/// The time that a cell says; `None` where it says none. A year has four digits: `1.2.3` is no date.
pub(super) fn moment(cell: &[u8]) -> Option<Moment> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    if text.len() < 5 || text.len() > 64 || !text.as_bytes().first()?.is_ascii_digit() {
        return None;
    }
    let (date, rest) = text.find([' ', 'T', 't']).and_then(|k| text.split_at_checked(k)).unwrap_or((text, ""));
    if date.contains(':') {
        // hours and minutes alone are an angle or a duration as well
        let time: civil::Time = if date.matches(':').count() == 2 { text.parse().ok()? } else { return None };
        return Some(Moment::OfDay(time.duration_since(civil::Time::midnight()).as_secs_f64()));
    }
    let written = format!("{}{rest}", iso(date)?);
    // nanoseconds since 1970 have more digits than a double
    let seconds = |at: Timestamp| at.as_second() as f64 + f64::from(at.subsec_nanosecond()) / 1e9;
    if let Ok(instant) = written.parse::<Timestamp>() {
        return Some(Moment::Instant(seconds(instant)));
    }
    let there: civil::DateTime = written.parse().ok()?;
    Some(Moment::Instant(seconds(there.to_zoned(TimeZone::UTC).ok()?.timestamp())))
}

/// A date in the order of ISO 8601. Of numbers parted by slashes the day must show: it is above 12.
fn iso(date: &str) -> Option<String> {
    let parted = |mark: char| -> Option<[&str; 3]> { date.split(mark).collect::<Vec<_>>().try_into().ok() };
    let written = |y: &str, m: &str, d: &str| (y.len() == 4).then(|| format!("{y}-{m:0>2}-{d:0>2}"));
    if let Some([d, m, y]) = parted('.') {
        return written(y, m, d);
    }
    if let Some([a, b, c]) = parted('/') {
        let above = |text: &str| text.parse::<u32>().is_ok_and(|n| n > 12);
        return match (a.len(), above(a), above(b)) {
            (4, ..) => written(a, b, c),
            (_, true, false) => written(c, b, a),
            (_, false, true) => written(c, a, b),
            _ => None,
        };
    }
    let digits = date.len() == 8 && date.bytes().all(|b| b.is_ascii_digit());
    (digits || date.matches('-').count() == 2).then(|| date.to_string())
}

/// A column of times as it is read.
#[derive(Debug, Clone, Default)]
pub(super) struct Times {
    last: f64,
    midnights: f64,
}

impl Times {
    /// A written time in seconds since 1970; one of a day goes on over midnight.
    pub(super) fn seconds(&mut self, cell: &[u8]) -> Option<f64> {
        Some(match moment(cell)? {
            Moment::Instant(at) => at,
            Moment::OfDay(at) => {
                if at < self.last - 0.5 * DAY {
                    self.midnights += 1.0;
                }
                self.last = at;
                SOME_DAY + self.midnights * DAY + at
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ("3/31/2024 01:59:55", 1_711_850_395.0),
        ] {
            assert_eq!(moment(text.as_bytes()), Some(Moment::Instant(seconds)), "{text}");
        }
        assert_eq!(moment(b"14:03:01.250"), Some(Moment::OfDay(50_581.25)));
        for text in
            ["1.2.3", "1.2.34", "12", "3/4/2024 01:00:00", "12:30", "V", "2024-13-01T00:00:00", "31.03.24 01:59:55"]
        {
            assert_eq!(moment(text.as_bytes()), None, "{text}");
        }
        let mut times = Times::default();
        let all: Vec<f64> = ["23:59:59.5", "00:00:00.0"].iter().filter_map(|t| times.seconds(t.as_bytes())).collect();
        assert!(matches!(all[..], [a, b] if b - a == 0.5));
    }
}
