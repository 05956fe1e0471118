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
