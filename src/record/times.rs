//! Times as people write them: ISO 8601 with and without a zone, `20.11.2026 09:14:03`, `2026/11/20 09:14`, `11/20/26 2:03:01 PM`, `20-Nov-2026 09:14:03`,
//! `14:03:01.250`, `14:03:01:250`, `03:01.2`.

use jiff::{Timestamp, civil, tz::TimeZone};

/// Times of day are put on this day, 2002-01-01, so that all written times are seconds since 1970.
const SOME_DAY: f64 = 1_009_843_200.0;
const DAY: f64 = 86_400.0;

/// A written time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Moment {
    /// Seconds since 1970; one without a zone is taken as UTC.
    Instant(f64),
    /// Seconds of a day, or of an hour, and the seconds of that.
    Of(f64, f64),
}

/// The time that a cell says; `None` where it says none. A date alone has four digits of the year: `1.2.03` is none. Of `05/11/2026` the day is taken to
/// stand first; [`Times`] knows better after another day.
pub(super) fn moment(cell: &[u8]) -> Option<Moment> {
    dated(cell, Slashes::DayFirst)
}

/// Which number of a date parted by slashes is the day, where both may be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Slashes {
    DayFirst,
    MonthFirst,
}

fn dated(cell: &[u8], order: Slashes) -> Option<Moment> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    if text.len() < 5 || text.len() > 64 || !text.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    // half past two in the afternoon
    let noon = ["AM", "PM"]
        .into_iter()
        .find(|half| text.get(text.len() - 2..).is_some_and(|end| end.eq_ignore_ascii_case(half)));
    let text = noon.and_then(|half| text.get(..text.len() - half.len())).unwrap_or(text).trim_end();
    let half_day = |hour: i8| match (noon, hour) {
        (None, _) => Some(0.0),
        (Some("AM"), 12) => Some(-0.5 * DAY),
        (Some("PM"), 1..=11) => Some(0.5 * DAY),
        (_, 1..=12) => Some(0.0),
        _ => None,
    };
    let named = with_month(text);
    let text = named.as_deref().unwrap_or(text);
    if !text.as_bytes().first()?.is_ascii_digit() {
        return None;
    }
    let (date, rest) = text.find([' ', 'T', 't', '_']).and_then(|k| text.split_at_checked(k)).unwrap_or((text, ""));
    // an hour may have one digit; a third colon stands before milliseconds, or in the zone
    let padded = |time: &str| -> String {
        let hour = if time.find(':') == Some(1) { "0" } else { "" };
        let third = time.match_indices(':').nth(2).and_then(|(k, _)| Some((time.get(..k)?, time.get(k + 1..)?)));
        match third.filter(|(_, behind)| behind.len() == 3 && behind.bytes().all(|b| b.is_ascii_digit())) {
            Some((before, behind)) => format!("{hour}{before}.{behind}"),
            None => format!("{hour}{time}"),
        }
    };
    if date.contains(':') {
        let (since, lap) = of_a_day(&padded(text))?;
        let hour = i8::try_from(crate::number::whole_i64(since / 3600.0)).unwrap_or(i8::MAX);
        return Some(Moment::Of(since + half_day(hour)?, lap));
    }
    let time = rest.trim_start_matches(['T', 't', ' ', '_']);
    // a zone may stand apart, and be named
    let universal = ["UTC", "GMT"].into_iter().find_map(|zone| time.strip_suffix(zone));
    let time = universal.map_or_else(|| time.to_string(), |time| format!("{time}Z"));
    let time =
        padded(&[" +", " -", " Z"].into_iter().fold(time, |time, apart| time.replace(apart, apart.trim_start())));
    let between = if time.is_empty() { "" } else { "T" };
    let written = format!("{}{between}{time}", iso(date, !time.is_empty(), order)?);
    // nanoseconds since 1970 have more digits than a double
    let seconds = |at: Timestamp| at.as_second() as f64 + f64::from(at.subsec_nanosecond()) / 1e9;
    if let Ok(instant) = written.parse::<Timestamp>() {
        return noon.is_none().then(|| Moment::Instant(seconds(instant)));
    }
    let there: civil::DateTime = written.parse().ok()?;
    Some(Moment::Instant(seconds(there.to_zoned(TimeZone::UTC).ok()?.timestamp()) + half_day(there.hour())?))
}

/// Seconds of `14:03:01.25`, also of a duration of more than a day; and of `03:01.2`, minutes and seconds, as spreadsheets show them. Hours and minutes
/// alone are an angle as well. With the seconds after which such times begin anew.
fn of_a_day(time: &str) -> Option<(f64, f64)> {
    let whole = |part: &str, most: u32| {
        let sound = !part.is_empty() && part.len() <= 6 && part.bytes().all(|b| b.is_ascii_digit());
        part.parse::<u32>().ok().filter(|number| sound && *number <= most).map(f64::from)
    };
    let second = |part: &str| {
        let (seconds, rest) = part.split_once(['.', ',']).unwrap_or((part, ""));
        let digits = rest.bytes().all(|b| b.is_ascii_digit());
        // a leap second
        let whole = whole(seconds, 60).filter(|_| digits)?;
        Some(whole + if rest.is_empty() { 0.0 } else { format!("0.{rest}").parse::<f64>().ok()? })
    };
    match time.split(':').collect::<Vec<_>>().as_slice() {
        [h, m, s] => Some((3600.0 * whole(h, 999_999)? + 60.0 * whole(m, 59)? + second(s)?, DAY)),
        [m, s] if s.contains(['.', ',']) => Some((60.0 * whole(m, 59)? + second(s)?, 3600.0)),
        _ => None,
    }
}

/// A date with the name of its month (`20-Nov-2026`, `Nov 20, 2026`), in the order of ISO 8601, with what stands behind it.
fn with_month(text: &str) -> Option<String> {
    if text.bytes().filter(u8::is_ascii_alphabetic).count() < 3 {
        return None;
    }
    const MONTHS: [&str; 12] = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
    let time = text.find(':').and_then(|k| text.get(..k)?.rfind([' ', 'T', '_'])).unwrap_or(text.len());
    let (date, rest) = text.split_at_checked(time)?;
    let parts: Vec<&str> = date.split([' ', '-', ',', '/', '.']).filter(|part| !part.is_empty()).collect();
    let place = parts.iter().position(|part| part.starts_with(|c: char| c.is_ascii_alphabetic()))?;
    let month = parts.get(place)?.to_ascii_lowercase();
    let number = MONTHS.iter().position(|known| month.starts_with(known))? + 1;
    let (day, year) = match (place, parts.as_slice()) {
        (1, [day, _, year]) if day.len() <= 2 => (day, year),
        (1, [year, _, day]) | (0, [_, day, year]) => (day, year),
        _ => return None,
    };
    let century = if year.len() == 2 { "20" } else { "" };
    Some(format!("{century}{year}-{number:02}-{day:0>2}{rest}"))
}

/// A date in the order of ISO 8601. Of numbers parted by slashes, or by hyphens with the year behind, the day is the one above 12, or else as `order` says. Beside a time of day the year may have
/// two digits, as in POSIX of 1969 to 2068.
fn iso(date: &str, timed: bool, order: Slashes) -> Option<String> {
    let parted = |mark: char| -> Option<[&str; 3]> { date.split(mark).collect::<Vec<_>>().try_into().ok() };
    let written = |y: &str, m: &str, d: &str| {
        let century = match (y.len(), y.parse::<u32>()) {
            (4, _) => "",
            (2, Ok(69..)) if timed => "19",
            (2, Ok(_)) if timed => "20",
            _ => return None,
        };
        Some(format!("{century}{y}-{m:0>2}-{d:0>2}"))
    };
    if let Some([d, m, y]) = parted('.') {
        return written(y, m, d);
    }
    // with hyphens the year stands first, or else it is as with slashes
    let hyphens = parted('-').filter(|[year, ..]| year.len() <= 2);
    if let Some([a, b, c]) = parted('/').or(hyphens) {
        let above = |text: &str| text.parse::<u32>().is_ok_and(|n| n > 12);
        return match (a.len(), above(a), above(b)) {
            (4, ..) => written(a, b, c),
            // of 26/11/20 either end may be the year
            (_, true, false) if c.len() == 4 => written(c, b, a),
            (_, false, true) => written(c, a, b),
            (1 | 2, false, false) if c.len() == 4 => match order {
                Slashes::DayFirst => written(c, b, a),
                Slashes::MonthFirst => written(c, a, b),
            },
            _ => None,
        };
    }
    let digits = date.len() == 8 && date.bytes().all(|b| b.is_ascii_digit());
    (digits || date.matches('-').count() == 2).then(|| date.to_string())
}

/// The two numbers before the year of a date parted by slashes.
fn two_numbers(cell: &[u8]) -> Option<(u32, u32)> {
    let text = std::str::from_utf8(cell).ok()?.trim();
    let date = text.get(..text.find([' ', 'T', 't', '_']).unwrap_or(text.len()))?;
    let [a, b, year]: [&str; 3] = date.split(['/', '-']).collect::<Vec<_>>().try_into().ok()?;
    let (first, second) = (a.parse().ok()?, b.parse().ok()?);
    (a.len() <= 2 && year.len() == 4).then_some((first, second))
}

/// Written times, since the first of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct WrittenTimes {
    times: Times,
    first: Option<f64>,
}

impl WrittenTimes {
    /// Seconds since the first time; `None` for what is none.
    pub(crate) fn since_first(&mut self, text: &str) -> Option<f64> {
        let at = self.times.seconds(text.as_bytes())?;
        Some(at - *self.first.get_or_insert(at))
    }
}

/// A column of times as it is read.
#[derive(Debug, Clone, Default)]
pub(super) struct Times {
    last: f64,
    laps: f64,
    /// The order of dates parted by slashes, once two of them differ in one number: that one is the day.
    order: Option<Slashes>,
    /// The last such date.
    date: Option<(u32, u32)>,
    /// What is added, so that times go on where the order shows.
    shift: f64,
}

impl Times {
    /// A written time in seconds since 1970; one of a day goes on over midnight.
    ///
    /// Of dates such as `05/11/2026` the day is taken to stand first until another date shows that it does not, by the one number in which it differs or by one above 12; times
    /// go on there. `None` where two such dates
    /// differ in both numbers, and nothing before has shown the order.
    pub(super) fn seconds(&mut self, cell: &[u8]) -> Option<f64> {
        if let Some(date) = two_numbers(cell) {
            return self.slashed(cell, date);
        }
        Some(match moment(cell)? {
            Moment::Instant(at) => at,
            Moment::Of(at, lap) => {
                if at < self.last - 0.5 * lap {
                    self.laps += lap;
                }
                self.last = at;
                SOME_DAY + self.laps + at
            }
        })
    }

    fn slashed(&mut self, cell: &[u8], date: (u32, u32)) -> Option<f64> {
        let instant = |cell: &[u8], order| match dated(cell, order)? {
            Moment::Instant(at) => Some(at),
            Moment::Of(..) => None,
        };
        let shown = match (date.0 > 12, date.1 > 12) {
            (true, false) => Some(Slashes::DayFirst),
            (false, true) => Some(Slashes::MonthFirst),
            _ => None,
        };
        if self.order.is_none() {
            self.order = match self.date {
                _ if shown.is_some() => shown,
                Some((a, b)) if a != date.0 && b == date.1 => Some(Slashes::DayFirst),
                Some((a, b)) if a == date.0 && b != date.1 => Some(Slashes::MonthFirst),
                Some(last) if last != date => return None,
                _ => None,
            };
            if let (Some(Slashes::MonthFirst), Some((a, b))) = (self.order, self.date) {
                // what was read before was one date, with the day first
                let year = cell.split(|b| matches!(b, b'/' | b'-')).nth(2)?.split(u8::is_ascii_whitespace).next()?;
                let before = format!("{a:02}/{b:02}/{} 00:00", String::from_utf8_lossy(year));
                let wrong = instant(before.as_bytes(), Slashes::DayFirst)?;
                self.shift = wrong - instant(before.as_bytes(), Slashes::MonthFirst)?;
            }
            self.date = Some(date);
        }
        // what is no date in the order that others have shown is none
        if shown.is_some() && shown != self.order {
            return None;
        }
        Some(instant(cell, self.order.unwrap_or(Slashes::DayFirst))? + self.shift)
    }
}
