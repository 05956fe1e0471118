//! What loggers really write: absent cells, lost samples, dead stretches, times in many forms, damaged files. Truths are stated in the tests.

use crate::support::*;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::io::Cursor;
use std::path::Path;
use tumble::record::{As, Block, ClockFrom, Record};
use tumble::wire::{Recipe, Reduced, SegmentsBy};

fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

fn open(text: &str) -> Record {
    Record::of_text("log.csv", text).unwrap_or_else(|e| panic!("{e}"))
}

fn recipe(segments: SegmentsBy) -> Recipe {
    Recipe { segments, guard: None, least: None, columns: Vec::new(), clock: ClockFrom::default(), encoder: None }
}

fn still() -> Recipe {
    recipe(SegmentsBy::Still { window: 0.5, threshold: 4.0 })
}

fn reduced(text: &str, recipe: &Recipe) -> Reduced {
    recipe.reduce(&mut open(text), None).unwrap_or_else(|error| panic!("{error}"))
}

/// 100 Hz: each level for 15 s, shaken for 2 s before the next; rows as (time, value).
fn positions(levels: &[f64], seed: u64) -> Vec<(f64, f64)> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut rows = Vec::new();
    for level in levels {
        for k in 0..1700 {
            let value = level + normal(&mut random) * if k < 1500 { 1e-3 } else { 0.3 };
            rows.push((rows.len() as f64 / 100.0, value));
        }
    }
    rows
}

fn table(rows: &[(f64, f64)]) -> String {
    let cell = |v: f64| if v.is_nan() { String::new() } else { format!("{v:.6}") };
    rows.iter().fold("time_s,V\n".to_string(), |text, (t, v)| text + &format!("{t:.2},{}\n", cell(*v)))
}

/// Each segment's mean is the level it was made with.
#[track_caller]
fn check(found: &Reduced, levels: &[f64]) {
    let means: Vec<(f64, f64)> = found.reduction.means.iter().map(|m| (m[0].value, m[0].uncertainty.u)).collect();
    assert_eq!(means.len(), levels.len(), "{means:?} {:?} {:?}", found.reduction.rejected, found.notes);
    for ((mean, u), level) in means.iter().zip(levels) {
        assert!((mean - level).abs() < 5.0 * u && *u < 2e-4, "{mean} +- {u}, not {level}");
    }
}

const LEVELS: [f64; 6] = [1.0, 2.0, 3.0, -1.0, 0.5, 2.5];

/// Rows that count in no channel, as another one is read at a fifth of the rate, are said.
#[test]
fn rows_without_one_value_are_counted() {
    let mut text = "time_s,V,B\n".to_string();
    for (k, (time, value)) in positions(&LEVELS, 2).into_iter().enumerate() {
        let slow = if k % 5 == 0 { "1.5" } else { "" };
        text += &format!("{time:.2},{value:.6},{slow}\n");
    }
    let notes = reduced(&text, &still()).notes.join("; ");
    // 6 levels of 1,700 rows
    assert!(notes.contains("8160 of 10200 rows have no value in one of the columns (B: 8160)"), "{notes}");
    let one = Recipe { columns: vec![("V".into(), "V".into())], ..still() };
    assert!(!reduced(&text, &one).notes.join("; ").contains("no value"));
}

/// Absent cells do not move what comes after them, by times and by the row's number alike.
#[test]
fn absent_cells_keep_their_time() {
    let mut rows = positions(&LEVELS, 1);
    rows[1900..2500].iter_mut().for_each(|row| row.1 = f64::NAN);
    let list = (0..6).map(|k| (k.to_string(), 17.0 * f64::from(k) + 0.5, 17.0 * f64::from(k) + 14.5)).collect();
    let mut by = recipe(SegmentsBy::Times { list, from: "a list".into() });
    check(&reduced(&table(&rows), &by), &LEVELS);
    by.clock.rate = Some(100.0);
    let text = table(&rows).replace("time_s", "row");
    by.columns = vec![("V".into(), "V".into())];
    check(&reduced(&text, &by), &LEVELS);
}

/// A logger that loses some samples in a hundred loses no position; what is missing is said. Seconds that are missing end a stretch.
#[test]
fn lost_samples_are_bridged() {
    let levels: Vec<f64> = (0..60).map(|k| f64::from(k * 7 % 11) / 2.0).collect();
    for (share, seed) in [(0.02, 2), (0.05, 3)] {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut rows = positions(&levels, seed);
        rows.retain(|_| (random.next_u32() as f64) / f64::from(u32::MAX) > share);
        let found = reduced(&table(&rows), &still());
        check(&found, &levels);
        let said = |notes: &[String]| notes.iter().any(|note| note.contains("gaps bridged"));
        assert!(
            found.reduction.segments.iter().all(|segment| said(&segment.notes)),
            "{:?}",
            found.reduction.segments[0]
        );
    }
    let mut rows = positions(&[1.0, 2.0], 4);
    rows.drain(600..900);
    let found = reduced(&table(&rows), &still());
    assert_eq!(found.reduction.segments.len(), 3, "{:?}", found.reduction.segments);
}

/// A logger that froze, and a channel at its rail, are no positions, hide none, and are named.
#[test]
fn dead_stretches_are_left_out() {
    let mut rows = positions(&LEVELS, 5);
    let end = rows.len();
    let mut frozen: Vec<(f64, f64)> = (0..2500).map(|k| (f64::from(k) / 100.0, 0.0)).collect();
    frozen.extend((0..end).map(|k| (25.0 + k as f64 / 100.0, rows[k].1)));
    let found = reduced(&table(&frozen), &still());
    check(&found, &LEVELS);
    let why =
        |found: &Reduced| found.reduction.rejected.iter().map(|r| r.reason.clone()).collect::<Vec<_>>().join("; ");
    assert!(why(&found).contains("V is stuck"), "{}", why(&found));
    // the converter ends at 2.4: the levels 3 and 2.5 cannot be seen
    rows.iter_mut().for_each(|row| row.1 = row.1.min(2.4));
    let found = reduced(&table(&rows), &still());
    check(&found, &[1.0, 2.0, -1.0, 0.5]);
    assert!(why(&found).contains("V is saturated"), "{}", why(&found));
    // a rail that is touched within a position: those samples are left out, and said
    let mut rows = positions(&[1.0, 2.0], 6);
    rows[700..705].iter_mut().for_each(|row| row.1 = 5.0);
    let found =
        reduced(&table(&rows), &recipe(SegmentsBy::Times { list: vec![("a".into(), 0.0, 15.0)], from: "a".into() }));
    assert!((found.reduction.means[0][0].value - 1.0).abs() < 1e-4);
    assert!(found.reduction.segments[0].notes.iter().any(|n| n.contains("5 samples left out: V is saturated")));
    // what is coarse, held or set stays as it is: a temperature in tenths, a setpoint
    let coarse = |k: usize| (20.0 + (k / 400) as f64 * 0.1, [0.0, 90.0, 45.0][k / 1000 % 3]);
    let lines = (0..6000).map(|k| format!("{:.2},{:.1},{}\n", k as f64 / 100.0, coarse(k).0, coarse(k).1));
    let by = SegmentsBy::Times { list: vec![("a".into(), 0.0, 59.0)], from: "a".into() };
    let found = reduced(&("time_s,temperature,set\n".to_string() + &lines.collect::<String>()), &recipe(by));
    assert!(found.trace.dead.is_empty() && found.reduction.segments[0].notes.is_empty());
}

/// Noise that is cut at a rail has no mean: what is left of it is half a standard deviation away, whatever its scatter says.
#[test]
fn a_mean_beside_a_rail_is_left_out() {
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let rows: Vec<(f64, f64)> = (0..2000)
        .map(|k| {
            let level = if k < 1000 { 0.5 } else { 1.2 };
            (f64::from(k) / 100.0, (level + 0.01 * normal(&mut random)).min(1.205))
        })
        .collect();
    let list = vec![("low".to_string(), 0.0, 9.995), ("high".to_string(), 10.0, 19.995)];
    let found = reduced(&table(&rows), &recipe(SegmentsBy::Times { list, from: "a".into() }));
    let [mean] = found.reduction.means.as_slice() else { panic!("{:?}", found.reduction.segments) };
    // 1e-2/sqrt(1000)
    assert!((mean[0].value - 0.5).abs() < 4.0 * 3.2e-4, "{mean:?}");
    let at_rail = rows.iter().filter(|(_, value)| *value == 1.205).count();
    let reason = &found.reduction.rejected[0].reason;
    assert!(reason.contains("V is saturated") && reason.contains(&format!("({at_rail} of 1000 samples)")), "{reason}");
}

/// Times that scatter by half an interval, and by a whole one where they were sorted afterwards: no row is missing, and the interval is (last - first)/(n - 1). Rows that are missing are found.
#[test]
fn times_that_scatter_have_no_gaps() {
    for (share, sorted, seed) in [(0.0, false, 1), (0.3, false, 2), (0.5, false, 3), (1.0, true, 4)] {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        let mut times: Vec<f64> = (0..20_000).map(|k| (1.0 + f64::from(k) + share * uniform()) / 100.0).collect();
        if sorted {
            times.sort_by(f64::total_cmp);
        }
        let read = |times: &[f64]| {
            let text = times.iter().fold("time_s,V\n".to_string(), |text, time| text + &format!("{time:.9},1\n"));
            let (interval, _, gaps) = clock(&text).expect("a clock");
            (interval, gaps)
        };
        let (interval, gaps) = read(&times);
        let expected = (times[19_999] - times[0]) / 19_999.0;
        assert!((interval - expected).abs() < 1e-12 && gaps == 0, "{share}: {interval} {expected} {gaps}");
        // nine rows are missing at ten places: with the steps there, 0.01 s times 19,900 steps less what the scatter leaves
        let mut row = 0;
        times.retain(|_| {
            row += 1;
            !(row % 2000 > 1000 && row % 2000 < 1010)
        });
        let (interval, gaps) = read(&times);
        assert!((interval - 0.01).abs() < 1e-5 && gaps == 10, "{share}: {interval} {gaps}");
    }
}

/// The mean step of the clock, its notes, and how many gaps it has.
fn clock(text: &str) -> Result<(f64, Vec<String>, u64), String> {
    let mut record = open(text);
    let from = ClockFrom::default();
    let time = from.column(&record).map_err(|e| e.to_string())?;
    let mut clock = from.ticks(&record, time).map_err(|e| e.to_string())?;
    record.select(&[(time.ok_or("no clock")?, As::Time)]);
    let mut block = Block::default();
    while record.next(&mut block).map_err(|e| e.to_string())? {
        let times = block.columns.first().map(Vec::as_slice);
        clock.stretches(times, block.rows(), None, None).map_err(|e| e.to_string())?;
    }
    Ok((clock.interval().map_err(|e| e.to_string())?, clock.notes(), clock.jumps().1))
}

/// Two hundred rows at 100 Hz, however their times are written.
#[test]
fn times_as_people_write_them() {
    let rows = |title: &str, time: &dyn Fn(u64) -> String| {
        (0..200).fold(format!("{title}\n"), |text, k| text + &format!("{},{}.25\n", time(k), k % 7))
    };
    let second = |k: u64| format!("{:02}.{:02}", 55 + k / 100 % 5, k % 100);
    let toa5 = "\"TOA5\",\"CR1000\",\"Station\",\"1234\"\n\"TIMESTAMP\",\"V\"\n\"TS\",\"mV\"\n\"\",\"Avg\"";
    for (text, unit) in [
        (rows("timestamp,V", &|k| format!("2024-03-31T01:59:{}", second(k))), None),
        (rows("timestamp,V", &|k| format!("2024-03-31T01:59:{}+02:00", second(k))), None),
        (rows("Zeit,V", &|k| format!("20.11.2026 09:14:{}", second(k))), None),
        (
            rows("time,V", &|k| {
                if k < 100 { format!("23:59:59.{:02}", k) } else { format!("00:00:00.{:02}", k - 100) }
            }),
            None,
        ),
        (rows("timestamp,V", &|k| format!("{}", 1_700_000_000.0 + k as f64 / 100.0)), None),
        (rows("timestamp,V", &|k| (1_700_000_000_000 + 10 * k).to_string()), Some("ms")),
        (rows("timestamp,V", &|k| (1_700_000_000_000_000 + 10_000 * k).to_string()), Some("us")),
        (rows("timestamp,V", &|k| (1_700_000_000_000_000_000 + 10_000_000 * k).to_string()), Some("ns")),
        (rows("timestamp,V", &|k| (1_200_000_000 + 10_000 * k).to_string()), Some("us")),
        (rows("timestamp,gyro_rad[0]", &|k| (50_000 + 10_000 * k).to_string()), Some("us")),
        (
            rows("#timestamp [ns],w_RS_S_x [rad s^-1]", &|k| (1_403_636_579_758_555_392 + 10_000_000 * k).to_string()),
            None,
        ),
        (rows("t,V", &|k| format!("{}", k as f64 / 100.0)), None),
        (rows("Time,V", &|k| format!("11/20/26 9:14:{} AM", second(k))), None),
        (rows("time,V", &|k| format!("{:02}:59:{}.{:02} pm", 11 + k / 500, 55 + k / 100, k % 100)), None),
        (rows("time,V", &|k| format!("20.11.26 9:14:{}", second(k))), None),
        (rows("datetime,V", &|k| format!("11/20/2026 12:00:{} AM", second(k))), None),
        (rows("timestamp_ms,V", &|k| (10 * k).to_string()), None),
        (rows("t/ms,U/mV", &|k| (10 * k).to_string()), None),
        (rows("Date,Time,V", &|k| format!("20.11.2026,09:14:{}", second(k))), None),
        (rows(toa5, &|k| format!("\"2024-01-01 10:00:{:02}.{:02}\"", k / 100, k % 100)), None),
        // months by name, hyphens, zones apart, durations, minutes as spreadsheets show them
        (rows("time,V", &|k| format!("20-Nov-2026 09:14:{}", second(k))), None),
        (rows("time,V", &|k| format!("\"Nov 20, 2026 09:14:{}\"", second(k))), None),
        (rows("time,V", &|k| format!("20 November 2026 09:14:{}", second(k))), None),
        (rows("time,V", &|k| format!("20-11-2026 09:14:{}", second(k))), None),
        (rows("time,V", &|k| format!("2026-11-20_09:14:{}", second(k))), None),
        (rows("time,V", &|k| format!("2026-11-20 09:14:{} +08:00", second(k))), None),
        (rows("time,V", &|k| format!("2026-11-20 09:14:{} UTC", second(k))), None),
        (rows("time,V", &|k| format!("25:14:{}", second(k))), None),
        (rows("time,V", &|k| if k < 100 { format!("59:59.{k:02}") } else { format!("00:00.{:02}", k - 100) }), None),
        // a title says how times are written
        (rows("time (ISO 8601),V", &|k| format!("2026-11-20T09:14:{}", second(k))), None),
        (rows("Time [hh:mm:ss],V", &|k| format!("09:14:{}", second(k))), None),
        (rows("t_min,V", &|k| format!("{}", k as f64 / 6000.0)), None),
        (rows("time_sec,V", &|k| format!("{}", k as f64 / 100.0)), None),
        (rows("Elapsed Time (msec),V", &|k| (10 * k).to_string()), None),
        (rows("时间(毫秒),V", &|k| (10 * k).to_string()), None),
        // days of spreadsheets and of MATLAB: the day of 2026-11-20
        (rows("time,V", &|k| format!("{:.10}", 46_346.5 + k as f64 / 8_640_000.0)), Some("days")),
        (rows("time,V", &|k| format!("{:.10}", 740_306.5 + k as f64 / 8_640_000.0)), Some("days")),
    ] {
        let (step, notes, gaps) = clock(&text).unwrap_or_else(|error| panic!("{error}\n{text:.200}"));
        // a day's number since the year 0 has 1.2e-10 days in its last digit, of which 200 steps leave a two-hundredth
        assert!((step - 0.01).abs() < 2e-7 && gaps == 0, "{step} {notes:?}\n{text:.200}");
        assert_eq!(notes.iter().any(|n| n.contains("has no unit")), unit.is_some(), "{notes:?}");
        assert!(unit.is_none_or(|unit| notes[0].contains(&format!("in {unit},"))), "{notes:?}");
    }
    let toa5 = open(&rows(toa5, &|k| format!("\"2024-01-01 10:00:00.{k:03}\"")));
    assert_eq!((toa5.columns()[1].name.as_str(), toa5.columns()[1].unit.as_deref()), ("V", Some("mV")));
    let px4 = open("timestamp,gyro_rad[0],gyro_rad[1]\n50000,1,2\n60000,1,2\n");
    assert!(px4.columns().iter().all(|own| own.unit.is_none()));
    for text in [
        "t,V\n1.2.3,1\n1.2.4,2\n1.2.5,3\n",
        "timestamp,V\nnever,1\nnow,2\n",
        // which number is the day, or the year, does not show; no clock of twelve hours has a thirteenth
        "time,V\n05/11/2026 09:14:00,1\n06/12/2026 09:14:01,2\n",
        "time,V\n26/11/20 09:14:00,1\n26/11/20 09:14:01,2\n",
        "time,V\n13:14:00 AM,1\n13:14:01 AM,2\n",
    ] {
        assert!(clock(text).is_err(), "{text}");
    }
    // a morning goes over into an afternoon, and midnight begins a day
    let over = |before: &str, after: &str| clock(&format!("time,V\n{before},1\n{after},2\n")).map(|(step, ..)| step);
    // the number that differs is the day, and either may be it while none does
    for (before, after) in [
        ("05/11/2026 23:59:59", "06/11/2026 00:00:00"),
        ("11/05/2026 23:59:59", "11/06/2026 00:00:00"),
        ("05/11/2026 09:14:00", "05/11/2026 09:14:01"),
        ("1/2/2026 11:59:59 PM", "1/3/2026 12:00:00 AM"),
        ("02/12/2026 23:59:59", "02/13/2026 00:00:00"),
        ("12-31-2026 23:59:59", "01-01-2027 00:00:00"),
        ("09:14:00:250", "09:14:01:250"),
        ("20.11.2026 09:14:59:999", "20.11.2026 09:15:00:999"),
    ] {
        assert_eq!(over(before, after), Ok(1.0), "{before} {after}");
    }
    // later dates stand in the order that showed
    let days = clock("time,V\n11/05/2026 00:00:00,1\n11/06/2026 00:00:00,1\n11/07/2026 00:00:00,2\n");
    assert_eq!(days.map(|(step, ..)| step), Ok(86_400.0));
    // a number above 12 shows the order as well, for the dates before it and behind it
    for dates in [["02/11/2026", "02/12/2026", "02/13/2026"], ["02/12/2026", "02/13/2026", "02/14/2026"]] {
        let rows: String = dates.iter().map(|date| format!("{date} 00:00:00,1\n")).collect();
        assert_eq!(clock(&format!("time,V\n{rows}")).map(|(step, ..)| step), Ok(86_400.0), "{dates:?}");
    }
    assert!(clock("time,V\n02/11/2026 00:00:00,1\n03/11/2026 00:00:00,1\n02/13/2026 00:00:00,2\n").is_err());
    for (before, after) in
        [("11:59:59 AM", "12:00:00 PM"), ("12:59:59 PM", "1:00:00 PM"), ("11:59:59 PM", "12:00:00 AM")]
    {
        assert_eq!(over(before, after), Ok(1.0), "{before} {after}");
    }
    // seconds or milliseconds: read as seconds, and said
    let (step, notes, _) = clock(&rows("time,V", &|k| (123_456 + 10 * k).to_string())).expect("a clock");
    assert!(step == 10.0 && notes[0].contains("read as seconds, with steps of 10;"), "{notes:?}");
}

/// A delimiter behind every cell, carriage returns, lines above the names, columns of texts: the same means as of the plain table.
#[test]
fn tables_as_loggers_write_them() {
    let plain = table(&positions(&LEVELS, 7));
    let lines = |of: &dyn Fn(usize, &str) -> String| {
        plain.lines().enumerate().map(|(k, line)| of(k, line) + "\n").collect::<String>()
    };
    for text in [
        lines(&|_, line| format!("{line},")),
        lines(&|_, line| format!("{line},,,")),
        lines(&|k, line| format!("{line}{}", if k == 0 { "" } else { "," })),
        plain.replace('\n', "\r"),
        format!("Report,\n,3\n{plain}"),
        lines(&|k, line| format!("{},{line}", ["device", "WT901(aa:bb)"][k.min(1)])),
        plain.replace(',', ";").replace('.', ",").replace('\n', ";\r\n"),
        // a word below; a break of the other kind within a quoted cell
        format!("{plain}End of file\n"),
        lines(&|k, line| format!("{line},{}", ["remark", "\"two\nlines\""][k.min(1)]))
            .replace("two\nlines", "two\u{1}lines")
            .replace('\n', "\r")
            .replace('\u{1}', "\n"),
        // empty cells at the beginning of a line of units, and a delimiter behind the names alone, between tabs
        lines(&|k, line| format!("{line}{}", if k == 0 { "\t\n\t(V)\t" } else { "" }).replace(',', "\t")),
    ] {
        check(&reduced(&text, &still()), &LEVELS);
    }
    // the mark of a remark is the name of numbers of rows, also above a line of units
    for text in ["#;t;V\n1;0;1,5\n2;1;2,5\n", "#\tt\tV\t\n\t(s)\t(mV)\t\n1\t0\t1.5\t\n2\t1\t2.5\t\n"] {
        let numbered = Record::of_stream("log.csv", Cursor::new(text)).expect("a table");
        let names: Vec<&str> = numbered.columns().iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["No", "t", "V"]);
    }
    let of_text = Record::of_stream("log.csv", Cursor::new(b"a,b,remark\n1,2,\n3,4,\n".to_vec())).expect("a table");
    assert_eq!(of_text.columns().len(), 3);
    // a cell behind the last column is one too many, but below a name that is empty
    let mut record = open("t,V,\n0,1,\n1,2,\n2,3,4\n");
    record.select(&[(1, As::Number)]);
    let mut block = Block::default();
    assert!(record.next(&mut block).is_ok_and(|more| more) && block.columns[0] == [1.0, 2.0, 3.0]);
    let mut record = open("t,V\n0,1,\n1,2,\n2,3,4\n");
    record.select(&[(1, As::Number)]);
    assert!(record.next(&mut block).is_ok_and(|more| more) && block.columns[0] == [1.0, 2.0]);
    assert!(record.next(&mut block).is_err());
}

/// Times that are coarser than the samples, stand twice or change places neither end the record nor stretch it.
#[test]
fn times_that_are_not_quite_in_order() {
    let text = |time: &dyn Fn(u64) -> f64| {
        (0..2000).fold("t,V\n".to_string(), |text, k| text + &format!("{:.3},1\n", time(k)))
    };
    // whole seconds, a hundred rows each
    let (step, notes, gaps) = clock(&text(&|k| (k / 100) as f64)).expect("a clock");
    assert!(
        (step - 0.01).abs() < 2e-4 && gaps == 0 && notes[0].contains("several rows have one time"),
        "{step} {notes:?}"
    );
    // a row in fifty has the time of the row before; two of them change places
    let twice = |k: u64| if k % 50 == 7 { k - 1 } else { k } as f64 / 100.0;
    let (step, _, gaps) = clock(&text(&twice)).expect("a clock");
    assert!((step - 0.01).abs() < 1e-4 && gaps <= 40, "{step} {gaps}");
    let back = |k: u64| match k % 100 {
        7 => k as f64 / 100.0 + 0.012,
        _ => k as f64 / 100.0,
    };
    let (step, notes, _) = clock(&text(&back)).expect("a clock");
    assert!((step - 0.01).abs() < 3e-4 && notes.iter().all(|note| !note.contains("goes back")), "{step} {notes:?}");
}

/// `""` is a quote, and a quoted cell may have several lines; a quote inside a cell is a character.
#[test]
fn quoted_cells() {
    let text = "serial,x,\"Ausgang\n(mV)\"\n\"6\"\" rotor\",1,1.01\n\"two\nlines, one comma\",2,2.02\n6\" plain,3,3.03\n\"at the\nend\",4,4.04";
    let mut record = open(text);
    assert_eq!(record.columns()[2].title, "Ausgang\n(mV)");
    record.select(&[(0, As::Label), (1, As::Number), (2, As::Number)]);
    let mut block = Block::default();
    assert!(record.next(&mut block).expect("rows"));
    assert_eq!(block.columns[1..], [vec![1.0, 2.0, 3.0, 4.0], vec![1.01, 2.02, 3.03, 4.04]]);
    assert_eq!(record.labels(), ["6\" rotor", "two\nlines, one comma", "6\" plain", "at the\nend"]);
    // over the end of a block of a megabyte
    let wide = "x".repeat(900_000);
    let text = format!("a,b\n1,\"{wide}\n{wide}\"\n2,\"{wide}\"\n3,c\n");
    let mut record = open(&text);
    record.select(&[(0, As::Number), (1, As::Label)]);
    let mut all = Vec::new();
    while record.next(&mut block).expect("rows") {
        all.extend_from_slice(&block.columns[0]);
    }
    assert!(all == [1.0, 2.0, 3.0] && record.labels()[0].len() == 1_800_001);
}

/// Many columns are no other work than many rows.
#[test]
fn twenty_thousand_columns() {
    let line = |of: &dyn Fn(usize) -> String| (0..20_000).map(of).collect::<Vec<_>>().join(",") + "\n";
    let text: String =
        line(&|k| format!("c_{k}")) + &(0..20).map(|row| line(&|k| (row * 20_000 + k).to_string())).collect::<String>();
    let mut record = open(&text);
    record.select(&[(19_999, As::Number), (0, As::Number)]);
    let mut block = Block::default();
    let mut all = Vec::new();
    while record.next(&mut block).expect("rows") {
        all.extend(block.columns[0].iter().copied().zip(block.columns[1].iter().copied()));
    }
    let expected: Vec<(f64, f64)> =
        (0..20).map(|row| (20_000.0 * row as f64 + 19_999.0, 20_000.0 * row as f64)).collect();
    assert_eq!(all, expected);
}

fn column(path: &Path, kinds: &[As]) -> Result<(Block, Vec<String>), String> {
    let mut record = Record::at(path).map_err(|e| e.to_string())?;
    record.select(&kinds.iter().enumerate().map(|(k, own)| (k, *own)).collect::<Vec<_>>());
    let mut block = Block::default();
    record.next(&mut block).map_err(|e| e.to_string())?;
    Ok((block, record.labels().to_vec()))
}

/// Files that say more than they hold are errors; one cell far away is one cell.
#[test]
fn damaged_files_ask_for_no_memory() {
    let at = data("damaged");
    let (block, _) = column(&at.join("stray_corner.xlsx"), &[As::Number, As::Number]).expect("a table");
    assert!(block.rows() == 200 && block.columns[0][199] == 1.99 && block.columns[1][199] == 1.03);
    for (name, words) in [("loop.xls", "damaged"), ("big.h5", "more than the file can hold")] {
        let error = column(&at.join(name), &[As::Number]).expect_err(name);
        assert!(error.contains(words), "{name}: {error}");
    }
    let (block, _) = column(&at.join("far-cell.xlsx#Notes"), &[As::Number]).expect("a table");
    assert_eq!(block.columns[0], [1.0]);
}

/// A log that says it has 2^64 fields of a format without one.
#[test]
fn nothing_many_times() {
    let mut log = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec();
    let messages: [(u8, &[u8]); 3] = [(b'F', b"a:"), (b'F', b"b:a[18446744073709551615] x;"), (b'A', b"\0\0\0b")];
    for (kind, data) in messages {
        log.extend((data.len() as u16).to_le_bytes());
        log.push(kind);
        log.extend(data);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.ulg");
    std::fs::write(&path, log).expect("a file");
    let error = column(&path, &[As::Number]).expect_err("no fields");
    assert!(error.contains("'a', which has no field"), "{error}");
}

/// A byte of a chunk that changed, which no other check sees.
#[test]
fn the_checksums_of_a_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("log.mcap");
    let sound = std::fs::read(data("records/ros1.mcap")).expect("a log");
    let mut found = 0;
    for at in (200..sound.len() / 2).step_by(97) {
        let mut bytes = sound.clone();
        bytes[at] ^= 1;
        std::fs::write(&path, &bytes).expect("a file");
        match column(&path, &[As::Number; 7]) {
            Err(error) => found += usize::from(error.contains("checksum")),
            Ok((block, _)) => {
                std::fs::write(&path, &sound).expect("a file");
                assert_eq!(block, column(&path, &[As::Number; 7]).expect("the log").0, "byte {at}");
            }
        }
    }
    assert!(found > 0, "no checksum was looked at");
}

/// Formats that are known and not read have their names.
#[test]
fn formats_have_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    for (bytes, words) in [
        (&b"#ROSBAG V2.0\n\x45\0\0\0"[..], "ROS 1"),
        (b"SQLite format 3\0\x10\0", "SQLite"),
        (b"ULog\x01\x12\x35\x01\0\0\0\0", "ULog"),
        (b"TDSm\x0e\0\0\0\x69\x12\0\0", "TDMS"),
        (b"ARROW1\0\0\xff\xff\xff\xff", "Arrow"),
        (b"FEA1\0\0\0\0\0\0\0\0", "Arrow"),
        (b"{\"t\":0,\"V\":1}\n", "JSON"),
        (b"[{\"t\":0,\"V\":1}]", "JSON"),
        (b"\x28\xb5\x2f\xfd\x04\x00\x00\x00", "zstd"),
    ] {
        let path = folder.path().join("log");
        std::fs::write(&path, bytes).expect("a file");
        let error = column(&path, &[As::Number]).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}

/// Durations of Arrow, which are plain numbers for Parquet, are seconds; what is plain for Arrow too stays as it is.
#[test]
fn durations_of_arrow() {
    let path = data("records/durations.parquet");
    let mut record = Record::open("durations.parquet", std::fs::File::open(path).expect("a file")).expect("a record");
    let units = [("t_s", 1.0), ("t_ms", 1e-3), ("t_us", 1e-6), ("t_ns", 1e-9), ("plain", 1.0), ("in.d", 1e-3)];
    assert_eq!(record.columns().iter().map(|own| own.title.as_str()).collect::<Vec<_>>(), units.map(|(own, _)| own));
    record.select(&(0..units.len()).map(|k| (k, As::Number)).collect::<Vec<_>>());
    let mut block = Block::default();
    assert!(record.next(&mut block).expect("rows"));
    for (k, (title, seconds)) in units.into_iter().enumerate() {
        assert_eq!(record.columns()[k].unit.as_deref(), (title != "plain").then_some("s"), "{title}");
        let expected: Vec<f64> = (0..100).map(|row| f64::from(row) * seconds).collect();
        assert_eq!(block.columns[k], expected, "{title}");
    }
}

/// Every logical type of Parquet is what it says, as a number and as a label, or is named.
#[test]
fn logical_types_of_parquet() {
    use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, TimeUnit, Type as Physical};
    use parquet::data_type::*;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::types::Type;
    use std::sync::Arc;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("types.parquet");
    let decimal = |scale, precision| LogicalType::decimal(scale, precision);
    let of = |name: &'static str, kind: Physical, logical: Option<LogicalType>| {
        Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED).with_logical_type(logical)
    };
    let fields = vec![
        of("a", Physical::INT32, Some(decimal(4, 9))).with_precision(9).with_scale(4).build(),
        of("b", Physical::INT64, Some(decimal(2, 18))).with_precision(18).with_scale(2).build(),
        of("c", Physical::FIXED_LEN_BYTE_ARRAY, Some(decimal(10, 38)))
            .with_length(16)
            .with_precision(38)
            .with_scale(10)
            .build(),
        of("d", Physical::FIXED_LEN_BYTE_ARRAY, Some(LogicalType::Float16)).with_length(2).build(),
        of("e", Physical::INT32, Some(LogicalType::Date)).build(),
        of("f", Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))).build(),
        of("g", Physical::INT64, Some(LogicalType::integer(64, false))).build(),
        // 256 bits, as Arrow's widest decimal has them
        of("w", Physical::FIXED_LEN_BYTE_ARRAY, Some(decimal(2, 76)))
            .with_length(32)
            .with_precision(76)
            .with_scale(2)
            .build(),
        of("h", Physical::INT32, None)
            .with_converted_type(ConvertedType::DECIMAL)
            .with_precision(9)
            .with_scale(3)
            .build(),
    ];
    let fields = fields.into_iter().map(|field| Arc::new(field.expect("a field"))).collect();
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build().expect("a schema"));
    for pack in [Compression::UNCOMPRESSED, Compression::LZ4, Compression::LZ4_RAW, Compression::SNAPPY] {
        let properties = WriterProperties::builder().set_compression(pack).build();
        let file = std::fs::File::create(&path).expect("a file");
        let mut writer = SerializedFileWriter::new(file, schema.clone(), Arc::new(properties)).expect("a writer");
        let mut group = writer.next_row_group().expect("a group");
        macro_rules! column {
            ($type:ty, $values:expr) => {{
                let mut column = group.next_column().expect("a column").expect("one more");
                column.typed::<$type>().write_batch(&$values, None, None).expect("values");
                column.close().expect("a column");
            }};
        }
        column!(Int32Type, [12_345, -5]);
        column!(Int64Type, [-123_456_789_012_345_678_i64, 7]);
        let fixed = |bytes: Vec<u8>| FixedLenByteArray::from(bytes);
        column!(
            FixedLenByteArrayType,
            [fixed((-31_415_926_536_i128).to_be_bytes().to_vec()), fixed(1_i128.to_be_bytes().to_vec())]
        );
        // -2 and 2^-24, the least number of binary16
        column!(FixedLenByteArrayType, [fixed(0xC000_u16.to_le_bytes().to_vec()), fixed(1_u16.to_le_bytes().to_vec())]);
        column!(Int32Type, [19_810, 0]);
        column!(Int64Type, [1_711_850_395_250_000_i64, 0]);
        column!(Int64Type, [-1_i64, i64::MIN]);
        let wide = |value: i128| [vec![if value < 0 { 0xFF } else { 0 }; 16], value.to_be_bytes().to_vec()].concat();
        column!(FixedLenByteArrayType, [fixed(wide(-12_345)), fixed(wide(678))]);
        column!(Int32Type, [1, -2_500]);
        group.close().expect("a group");
        writer.close().expect("a file");
        let (block, _) = column(&path, &[As::Number; 9]).expect("numbers");
        #[allow(
            clippy::excessive_precision,
            clippy::approx_constant,
            reason = "decimal numbers as the file states them"
        )]
        let expected = [
            [1.2345, -0.0005],
            [-1_234_567_890_123_456.78, 0.07],
            [-3.1415926536, 1e-10],
            [-2.0, 2_f64.powi(-24)],
            [19_810.0 * 86_400.0, 0.0],
            [1_711_850_395.25, 0.0],
            [18_446_744_073_709_551_615.0, 9_223_372_036_854_775_808.0],
            [-123.45, 6.78],
            [0.001, -2.5],
        ];
        for (found, expected) in block.columns.iter().zip(expected) {
            assert_eq!(found[..], expected, "{pack:?}");
        }
        let (_, labels) = column(&path, &[As::Label; 9]).expect("labels");
        for text in [
            "1.2345",
            "-0.0005",
            "-1234567890123456.78",
            "-3.1415926536",
            "0.0000000001",
            "2024-03-28",
            "1970-01-01",
            "2024-03-31T01:59:55.25",
            "18446744073709551615",
            "9223372036854775808",
            "-2.500",
        ] {
            assert!(labels.iter().any(|own| own == text), "{text}: {labels:?}");
        }
    }
    let field = Type::primitive_type_builder("i", Physical::FIXED_LEN_BYTE_ARRAY).with_length(12);
    let field = field.with_converted_type(ConvertedType::INTERVAL).with_repetition(Repetition::REQUIRED).build();
    let schema = Type::group_type_builder("table").with_fields(vec![Arc::new(field.expect("a field"))]).build();
    let file = std::fs::File::create(&path).expect("a file");
    let mut writer =
        SerializedFileWriter::new(file, Arc::new(schema.expect("a schema")), Default::default()).expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    let mut own = group.next_column().expect("a column").expect("one more");
    own.typed::<FixedLenByteArrayType>()
        .write_batch(&[FixedLenByteArray::from(vec![0; 12])], None, None)
        .expect("a value");
    own.close().expect("a column");
    group.close().expect("a group");
    writer.close().expect("a file");
    let error = column(&path, &[As::Number]).expect_err("an interval");
    assert!(error.contains("INTERVAL"), "{error}");
}
