//! What loggers do, drawn at random: clocks that are rounded or bare, samples that stick, stops that are near each other, standstills that are missing.

use crate::readings::{normal, uniform};
use crate::samples::{tumble, write};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use serde_json::{Value, json};

/// Half a window of motion between levels that stand for `stop` samples each, noise 0.02.
fn stops(levels: &[f64], stop: usize, random: &mut Pcg64Mcg) -> Vec<f64> {
    let mut all = Vec::new();
    for (k, level) in levels.iter().enumerate() {
        if k > 0 {
            all.extend((0..150).map(|i| {
                let share = f64::from(i) / 150.0;
                let before = levels[k - 1];
                before
                    + share * (level - before)
                    + 0.8 * (12.0 * share * std::f64::consts::PI).sin()
                    + 0.02 * normal(random)
            }));
        }
        all.extend((0..stop).map(|_| level + 0.02 * normal(random)));
    }
    all
}

fn table(title: &str, step: f64, values: &[f64]) -> String {
    let rows = values.iter().enumerate().map(|(k, v)| format!("{:.4},{v:.5}\n", step * k as f64));
    format!("{title}\n{}", rows.collect::<String>())
}

/// Alternating levels of an accelerometer, whose line is `b + k*g`, named by numbers.
fn campaign(readings: Value) -> String {
    let campaign = json!({
        "bench": { "id": "line", "sensors": { "y": { "model": "b + k*g" } } },
        "estimate": { "b": {}, "k": {} },
        "readings": readings
    });
    campaign.to_string()
}

/// One standstill was shaken: its positions are not those of the next ones, whatever they are called.
#[test]
fn a_standstill_that_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let levels: Vec<f64> = (0..8).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let mut values = stops(&levels, 600, &mut random);
    let whole = table("time_s,y", 0.01, &values);
    values.iter_mut().take(600).enumerate().for_each(|(k, v)| *v += (0.3 * k as f64).sin());
    let shaken = table("time_s,y", 0.01, &values);
    for name in [|k: usize| format!("{}", k + 1), |k: usize| format!("{k}"), |k: usize| format!("p{k}")] {
        let positions: Vec<Value> = (0..8).map(|k| json!({ "position": name(k), "g": levels[k] })).collect();
        write(folder.path(), "c.campaign.json", &campaign(json!({ "samples": "log.csv", "positions": positions })));
        write(folder.path(), "log.csv", &whole);
        let (code, out, error) = tumble(folder.path(), &["fit", "c.campaign.json"]);
        assert_eq!(code, 0, "{out}{error}");
        write(folder.path(), "log.csv", &shaken);
        let (code, _, error) = tumble(folder.path(), &["fit", "c.campaign.json"]);
        assert!(code == 1 && error.contains("8 positions, the record 7 segments"), "{error}");
    }
}

/// Stops that differ by less than two standard deviations of a sample may be taken for one with a jerk; the steps between them are said.
#[test]
fn stops_near_each_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64Mcg::seed_from_u64(8);
    for step in [0.03, 0.0] {
        let levels: Vec<f64> = (0..9).map(|k| step * f64::from(k)).collect();
        write(folder.path(), "log.csv", &table("time_s,y", 0.01, &stops(&levels, 700, &mut random)));
        let (_, out, error) = tumble(folder.path(), &["reduce", "log.csv", "--json", "-"]);
        let report: Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {error}"));
        let segments = report["segments"].as_array().expect("segments");
        let notes: Vec<String> = segments.iter().map(|segment| segment["notes"].to_string()).collect();
        let said = notes.iter().map(|own| own.matches("another position").count()).sum::<usize>();
        // eight steps, each between segments or said; without steps none is said
        let found = if step > 0.0 { segments.len() - 1 + said } else { said };
        assert_eq!(found, if step > 0.0 { 8 } else { 0 }, "{notes:?}");
    }
}

fn parameter<'a>(report: &'a Value, id: &str) -> &'a Value {
    report["parameters"].as_array().and_then(|all| all.iter().find(|own| own["id"] == id)).expect("a parameter")
}

/// Times that are rounded to about the sampling interval are those of even samples: nothing is missing. Rows that are missing are.
#[test]
fn rounded_times() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64Mcg::seed_from_u64(9);
    for k in 0..12 {
        let tick = if k % 2 == 0 { 0.001 } else { 0.01 };
        let (rate, begin) = (1.0 / (tick * uniform(&mut random, 1.03, 1.5)), uniform(&mut random, 0.0, 100.0));
        let lost = if k < 8 { 0.0 } else { uniform(&mut random, 0.02, 0.08) };
        let mut text = String::from("time_s,y\n");
        for i in 0..8000 {
            if uniform(&mut random, 0.0, 1.0) < lost {
                continue;
            }
            // of rows that are lost, the others stand at whole ticks
            let step = if lost > 0.0 { tick } else { 1.0 / rate };
            let time = ((begin + step * f64::from(i)) / tick).round() * tick;
            text.push_str(&format!("{time:.4},{:.5}\n", normal(&mut random)));
        }
        write(folder.path(), "log.csv", &text);
        write(folder.path(), "all.csv", "start_s,end_s\n0,1\n");
        let (_, out, error) = tumble(folder.path(), &["reduce", "log.csv", "--times", "all.csv", "--json", "-"]);
        let report: Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {error}"));
        let (found, gaps) = (report["interval_s"].as_f64(), report["gaps"].as_u64().expect("gaps"));
        let expected = if lost > 0.0 { 1.0 / tick } else { rate };
        assert!((found.expect("an interval") * expected - 1.0).abs() < 0.002, "{rate} Hz, {tick} s: {found:?}");
        assert_eq!(gaps > 0, lost > 0.0, "{rate} Hz, {tick} s, {lost} lost: {gaps} gaps");
    }
}

/// Steps that are those of no logger in seconds need a unit.
#[test]
fn hours_and_days_need_their_unit() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64Mcg::seed_from_u64(10);
    for unit in [3600.0, 86_400.0] {
        let rows: String = (0..2000)
            .map(|k| format!("{:.12},{:.4}\n", 60.0 + 0.01 * f64::from(k) / unit, normal(&mut random)))
            .collect();
        write(folder.path(), "log.csv", &format!("time,y\n{rows}"));
        let (code, _, error) = tumble(folder.path(), &["noise", "log.csv"]);
        assert!(code == 1 && error.contains("too short for seconds"), "{error}");
    }
}

/// Rows of a record at a rail, frozen or held say nothing more: the line is that of the other rows, with an uncertainty that holds.
#[test]
fn dead_rows_are_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let mut inside = [0; 4];
    for trial in 0..24 {
        let kind = trial % 4;
        let from = (uniform(&mut random, 0.1, 0.4) * 6000.0) as usize;
        let mut text = String::from("time_s,x,y\n");
        let mut last = 0.0;
        for i in 0..6000 {
            let x = if (i / 750) % 2 == 0 { 1.0 } else { -1.0 } * (1.0 + (i / 1500) as f64);
            let value = 0.3 + 2.0 * x + 0.05 * normal(&mut random);
            last = match kind {
                0 if (from..from + 1800).contains(&i) => last,
                1 => value.min(6.31),
                2 if i % 4 > 0 => last,
                _ => value,
            };
            text.push_str(&format!("{:.2},{x},{last:.6}\n", 0.01 * i as f64));
        }
        write(folder.path(), "log.csv", &text);
        let question = json!({
            "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} },
            "readings": { "samples": "log.csv", "as": "rows" }
        });
        write(folder.path(), "c.campaign.json", &question.to_string());
        let (_, out, error) = tumble(folder.path(), &["fit", "c.campaign.json", "--json", "-"]);
        let report: Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {error}"));
        let of = |id: &str, truth: f64| {
            let own = parameter(&report, id);
            (own["value"].as_f64().expect("a value") - truth) / own["u"].as_f64().expect("u")
        };
        let errors = [of("a", 0.3), of("b", 2.0)];
        inside[kind] += errors.iter().filter(|own| own.abs() < 1.96).count();
        assert!(errors.iter().all(|own| own.abs() < 5.0), "{kind}: {errors:?}");
        assert_eq!(error.contains("left out"), kind < 3, "{kind}: {error}");
    }
    println!("frozen, railed, held, sound: {inside:?} of 12 intervals hold each");
    assert!(inside.iter().all(|own| *own >= 8), "{inside:?}");
}

/// Seconds since the first sample, whatever the column is called.
#[test]
fn times_from_the_first_sample() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64Mcg::seed_from_u64(12);
    let values: Vec<f64> =
        (0..2000).map(|k| if k < 1000 { 1.01 } else { -0.99 } + 0.01 * normal(&mut random)).collect();
    let times = json!([{ "start_s": 0.5, "end_s": 9.5, "position": "up" }, { "start_s": 10.5, "end_s": 19.5, "position": "down" }]);
    let positions = json!([{ "position": "up", "g": 1 }, { "position": "down", "g": -1 }]);
    for title in ["time_s", "time"] {
        let rows: String =
            values.iter().enumerate().map(|(k, v)| format!("{:.2},{v:.5}\n", 20.0 + 0.01 * k as f64)).collect();
        write(folder.path(), "log.csv", &format!("{title},y\n{rows}"));
        for rows in [true, false] {
            let mut readings = json!({ "samples": "log.csv", "times": times, "positions": positions });
            if rows {
                readings["as"] = "rows".into();
            }
            write(folder.path(), "c.campaign.json", &campaign(readings));
            let (_, out, error) = tumble(folder.path(), &["fit", "c.campaign.json", "--json", "-"]);
            let report: Value = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {error}"));
            let k = parameter(&report, "k")["value"].as_f64().expect("a value");
            assert!((k - 1.0).abs() < 0.002, "{title}, rows {rows}: {k}");
        }
    }
}

/// `9,999` beside `101` may be thousands; `0,999` and `9,9` are decimals, and so is a column of nothing else.
#[test]
fn commas_of_thousands() {
    let folder = tempfile::tempdir().expect("a folder");
    for (cells, is_read) in [
        (["9,999", "-9,833", "101"], false),
        (["9,999", "-9,833", "10,1"], true),
        (["9,999", "-9,833", "1,010"], true),
        (["0,999", "-9,833", "101"], true),
    ] {
        let rows: String = (0..30).map(|k| format!("{k}\t{}\n", cells[k % 3])).collect();
        write(folder.path(), "log.tsv", &format!("time_s\tV\n{rows}"));
        let (code, _, error) = tumble(folder.path(), &["noise", "log.tsv"]);
        assert_eq!(!error.contains("is not a number"), is_read, "{cells:?} {code}: {error}");
    }
}

/// A column that was set, and does not scatter, has the uncertainty of its last digit, not of the steps between its levels; the sensor beside it keeps its own.
#[test]
fn set_values_have_the_uncertainty_of_their_digits() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let rows: String = (0..2400)
        .map(|k| {
            let rate = [0.0, 30.0, 60.0, -30.0][k / 600];
            format!("{:.2},p{},{rate},{:.4}\n", 0.01 * k as f64, k / 600, 0.02 * rate + 1e-3 * normal(&mut random))
        })
        .collect();
    write(folder.path(), "log.csv", &format!("time_s,position,rate,V\n{rows}"));
    let (code, _, error) = tumble(folder.path(), &["reduce", "log.csv", "--by", "position", "--json", "r.json"]);
    assert_eq!(code, 0, "{error}");
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("r.json")).expect("a report")).expect("JSON");
    assert_eq!(report["assumed_resolution"], json!({ "rate": 1.0 }));
    for segment in report["segments"].as_array().expect("segments") {
        let u = |column: &str| {
            let mean =
                segment["means"].as_array().expect("means").iter().find(|m| m["column"] == column).expect("the column");
            mean["u"].as_f64().expect("u")
        };
        // half a digit either way: 1/sqrt 12
        assert!((u("rate") - 12f64.sqrt().recip()).abs() < 0.05, "{segment}");
        assert!(u("V") < 2e-4, "{segment}");
    }
}

/// The report of `noise`, and what is said beside it.
fn noise(text: &str, more: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "log.txt", text);
    let (_, out, error) = tumble(folder.path(), &[&["noise", "log.txt", "--json", "-"], more].concat());
    (
        serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {error}")),
        error.split_whitespace().collect::<Vec<_>>().join(" "),
    )
}

/// Times that are not called so are found by a word of their name and values that rise, or by values that rise evenly; which ones is said. All of 100 Hz.
#[test]
fn columns_of_times_by_other_names() {
    let mut random = Pcg64Mcg::seed_from_u64(12);
    let values: Vec<f64> = (0..1200).map(|_| normal(&mut random)).collect();
    let ticks = |first: u64, step: u64| move |k: u64| format!("{}", (first + step * k) % (1 << 32));
    let seconds = |k: u64| format!("{:.6}", 0.01 * k as f64);
    let day = |k: u64| format!("2026-11-20T09:14:{:06.3}Z", 0.01 * k as f64);
    type Cell = Box<dyn Fn(u64) -> String>;
    // where the counter begins anew at 2^32, it does so in the middle
    let cases: Vec<(&str, &str, Cell)> = vec![
        ("X_Value", "even steps of 0.010000", Box::new(seconds)),
        ("seconds_elapsed", "'seconds_elapsed' is taken", Box::new(seconds)),
        ("__time", "'__time' is taken", Box::new(seconds)),
        ("LogTime [ms]", "'LogTime [ms]' is taken", Box::new(ticks(0, 10))),
        ("TimeUS", "'TimeUS' is taken", Box::new(ticks(0, 10_000))),
        ("SampleTimeFine", "anew at 2^32 1 time", Box::new(ticks((1 << 32) - 60_000, 100))),
        ("SampleTimeFine", "a logger in us", Box::new(ticks(500, 10_000))),
        ("time_us", "anew at 2^32 1 time", Box::new(ticks((1 << 32) - 6_000_000, 10_000))),
        ("loggedAt", "", Box::new(day)),
    ];
    for (title, said, cell) in cases {
        let rows: String = values.iter().enumerate().map(|(k, v)| format!("{k},{},{v:.4}\n", cell(k as u64))).collect();
        let (report, notes) = noise(&format!("No,{title},y\n{rows}"), &["--columns", "y"]);
        let interval = report["interval_s"].as_f64().expect("an interval");
        assert!((interval - 0.01).abs() < 1e-6, "{title}: {interval}; {notes}");
        assert!(notes.contains(said) && !notes.contains("gap"), "{title}: {notes}");
    }
    // numbers of rows, an angle, and values that scatter are no times
    for title in ["No,n", "No,angle_deg", "No,V", "No,settling_time"] {
        let is_angle = title.ends_with("deg");
        let cell = |k: usize, v: f64| match title {
            "No,n" => k.to_string(),
            _ if is_angle => (0.5 * k as f64).to_string(),
            _ => v.to_string(),
        };
        let rows: String = values.iter().enumerate().map(|(k, v)| format!("{k},{},{v}\n", cell(k, *v))).collect();
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path(), "log.csv", &format!("{title},y\n{rows}"));
        let (code, _, error) = tumble(folder.path(), &["noise", "log.csv"]);
        assert!(code == 1 && error.contains("no column of times"), "{title}: {error}");
    }
}

/// A mark that may be a decimal one or part thousands is said; cells that are no numbers are no silent nothing.
#[test]
fn what_is_doubtful_of_numbers_is_said() {
    let rows = |cell: &dyn Fn(usize) -> String, delimiter: char| -> String {
        (0..200).map(|k| format!("{k}{delimiter}{}\n", cell(k * 7919 % 41))).collect()
    };
    for (delimiter, mark, is_said) in [('\t', ',', true), (';', '.', true), (';', ',', true), (',', '.', false)] {
        let text = format!("time_s{delimiter}V\n{}", rows(&|k| format!("21{mark}{:03}", 100 + k), delimiter));
        assert_eq!(noise(&text, &[]).1.contains("read as the decimal mark"), is_said, "{delimiter:?} {mark:?}");
        let text = format!("time_s{delimiter}V\n{}", rows(&|k| format!("0{mark}{:03}", 100 + k), delimiter));
        assert!(!noise(&text, &[]).1.contains("read as the decimal mark"), "{delimiter:?} {mark:?}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    for cell in ["V", "%", "x1F"] {
        write(folder.path(), "log.csv", &format!("time_s,V\n{}", rows(&|k| format!("{k}{cell}"), ',')));
        let (code, _, error) = tumble(folder.path(), &["noise", "log.csv"]);
        assert!(
            code == 1 && error.contains("holds numbers") && error.contains(&format!("'0{cell}' in 'V'")),
            "{error}"
        );
    }
}

/// A channel that is sampled in some of the rows alone, and one whose rows stand among those of another, have their own sampling interval: white noise of standard
/// deviation s at intervals of T has N = s sqrt(T).
#[test]
fn slower_channels_among_the_rows() {
    let mut random = Pcg64Mcg::seed_from_u64(13);
    let (mut every_tenth, mut between) = (String::from("time_s,V,T\n"), String::from("time_s,V,T\n"));
    for k in 0..8000 {
        let (time, v) = (0.01 * f64::from(k), 0.02 * normal(&mut random));
        let slow = format!("{:.6}", 0.5 * normal(&mut random));
        every_tenth += &format!("{time:.3},{v:.6},{}\n", if k % 10 == 0 { &slow } else { "" });
        between += &format!("{time:.3},{v:.6},\n");
        if k % 4 == 0 {
            between += &format!("{:.3},,{slow}\n", time + 0.003);
        }
    }
    for (text, slow) in [(every_tenth, 0.1_f64), (between, 0.04)] {
        let (report, notes) = noise(&text, &[]);
        for (column, (sd, interval)) in [(0.02_f64, 0.01_f64), (0.5, slow)].into_iter().enumerate() {
            let own = &report["columns"][column];
            let all = own["coefficients"].as_array().expect("coefficients");
            let n = all.iter().find(|own| own["id"] == "N").and_then(|own| own["value"].as_f64());
            let expected = sd * interval.sqrt();
            // the standard deviation of 800 samples is known to 2.5 %, and four of them
            assert!((n.expect("N") / expected - 1.0).abs() < 0.1, "{own} {expected}; {notes}");
        }
        assert!(notes.contains("this is its sampling interval"), "{notes}");
    }
}

/// A unit that is not known is said, and one of a title stays whatever the others are.
#[test]
fn units_of_noise() {
    let rows: String = (0..200).map(|k| format!("{k},{},{}\n", k * 7919 % 41, k * 7907 % 43)).collect();
    let text = format!("time_s,V (foo),a [m/s^2]\n{rows}");
    let (report, notes) = noise(&text, &["--unit", "deg/s"]);
    assert!(notes.contains("'foo' in the title 'V (foo)' is not a known unit"), "{notes}");
    assert_eq!(report["columns"][1]["unit"], "m/s^2");
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "log.csv", &text);
    let (code, _, error) = tumble(folder.path(), &["noise", "log.csv", "--unit", "bar/foo"]);
    assert!(code == 1 && error.contains("--unit"), "{error}");
}

/// A column of labels is one of texts where some rows have none, and no channel.
#[test]
fn labels_that_are_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = |cell: &str| -> String {
        (0..600)
            .map(|k| {
                format!("{:.2},{},{}\n", 0.01 * f64::from(k), if k % 200 < 100 { cell } else { "" }, k * 7919 % 41)
            })
            .collect()
    };
    for (cell, is_channel) in [("p", false), ("7", true)] {
        write(folder.path(), "log.csv", &format!("t,label,a\n{}", rows(cell)));
        write(folder.path(), "times.csv", "start_s,end_s\n0,0.9\n");
        let (code, out, error) = tumble(folder.path(), &["reduce", "log.csv", "--times", "times.csv", "--json", "-"]);
        assert!(code == 0 && out.contains("\"a\"") && out.contains("\"label\"") == is_channel, "{cell}: {error} {out}");
    }
}
