//! Tables with titles and units of their own: what is unambiguous is taken, what is not is answered with the columns found.

use std::path::Path;
use tumble::{Campaign, fit};

const BENCH: &str = r#"{ "id": "head", "chain": [ { "joint": "theta", "about": "y" } ],
    "sensors": { "A": { "unit": "V", "model": "K0 + K1*a_x + K2*a_x^2" } } }"#;

/// A = 0.002 + 1.3 sin-like exact values at quarter and eighth turns, in any dress.
fn table(degrees: &str, volts: &str, scale_angle: f64, scale_volt: f64, comma: bool) -> String {
    let mut text = format!("{degrees};{volts};Bemerkung\n");
    for k in 0..8 {
        let theta = 45.0 * f64::from(k);
        let force = -theta.to_radians().sin();
        let line = format!("{};{};", theta * scale_angle, (0.002 + 1.3 * force + 1e-5 * force * force) * scale_volt);
        text.push_str(&(if comma { line.replace('.', ",") } else { line } + "gut\n"));
    }
    text
}

fn campaign(folder: &Path, table: &str, columns: &str) -> tumble::Result<Campaign> {
    std::fs::write(folder.join("table.csv"), table).expect("a table");
    let text = format!(
        r#"{{ "bench": {BENCH}, "estimate": {{ "K0": {{}}, "K1": {{}}, "K2": {{}} }}, "columns": {{ {columns} }}, "readings": "table.csv" }}"#
    );
    std::fs::write(folder.join("c.campaign.json"), text).expect("a campaign");
    Campaign::from_path(folder.join("c.campaign.json"))
}

fn solved(campaign: &Campaign) -> Vec<f64> {
    fit(campaign, &Default::default())
        .expect("a fit")
        .parameters
        .iter()
        .map(|own| own.value.expect("a value"))
        .collect()
}

#[test]
fn titles_and_units_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let map = r#""theta_deg": "Winkel", "A": "Spannung""#;
    let radians = std::f64::consts::PI / 180.0;
    let cases = [
        (table("theta_deg", "A", 1.0, 1.0, false), ""),
        (table("theta_deg", "A (mV)", 1.0, 1000.0, false), ""),
        (table("Winkel (Grad)", "Spannung (V)", 1.0, 1.0, true), map),
        (table("Winkel (rad)", "Spannung [mV]", radians, 1000.0, true), map),
        (
            table("Winkel (rad)", "Spannung [mV]", radians, 1000.0, true),
            r#""theta_deg": "Winkel (rad)", "A": "Spannung [mV]""#,
        ),
    ];
    for (table, columns) in cases {
        let found = solved(&campaign(folder.path(), &table, columns).expect(columns));
        for (value, truth) in found.iter().zip([0.002, 1.3, 1e-5]) {
            assert!((value - truth).abs() < 1e-12, "{columns}: {value} {truth}");
        }
    }
}

#[test]
fn what_is_ambiguous_is_answered_with_the_columns_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = |table: &str, columns: &str| campaign(folder.path(), table, columns).expect_err(columns).to_string();
    let good = table("Winkel (Grad)", "Spannung", 1.0, 1.0, false);
    let missing = told(&good, r#""theta_deg": "Angle", "A": "Spannung""#);
    assert!(
        missing.contains("no column 'Angle'") && missing.contains("'Winkel (Grad)', 'Spannung', 'Bemerkung'"),
        "{missing}"
    );
    let length = told(&table("Winkel (mm)", "Spannung", 1.0, 1.0, false), r#""theta_deg": "Winkel", "A": "Spannung""#);
    assert!(length.contains("Winkel (mm)") && length.contains("deg"), "{length}");
    let twice = told(&good, r#""theta_deg": "Spannung", "A": "Spannung""#);
    assert!(twice.contains("is given for two keys"), "{twice}");
    let both = told(&table("theta_deg", "A", 1.0, 1.0, false), r#""theta_deg": "Bemerkung""#);
    assert!(both.contains("two columns are 'theta_deg'"), "{both}");
    let inline = Campaign::from_json(&format!(
        r#"{{ "bench": {BENCH}, "estimate": {{ "K0": {{}} }}, "columns": {{ "A": "B" }}, "readings": [ {{ "theta_deg": 0, "A": 1 }} ] }}"#
    ));
    assert!(inline.expect_err("inline").to_string().contains("\"columns\""));
}

/// A quantity over its unit (ISO 80000-1), although its symbol is a unit as well (kelvin, ampere, tesla); a unit before the words, in a row above the
/// titles, behind a dot or a `per`.
#[test]
fn units_are_read_wherever_they_stand() {
    let folder = tempfile::tempdir().expect("a folder");
    let radians = std::f64::consts::PI / 180.0;
    for (angle, volts, map) in [
        ("K/rad", "A/mV", r#""theta_deg": "K/rad""#),
        ("[rad] Winkel", "A (mV, channel 2)", r#""theta_deg": "Winkel""#),
        ("angle.rad", "A [mV]", r#""theta_deg": "angle.rad""#),
        ("rad;mV;\nangle", "A", r#""theta_deg": "angle""#),
    ] {
        let found = solved(&campaign(folder.path(), &table(angle, volts, radians, 1000.0, false), map).expect(angle));
        for (value, truth) in found.iter().zip([0.002, 1.3, 1e-5]) {
            assert!((value - truth).abs() < 1e-12, "{angle} {volts}: {value} {truth}");
        }
    }
    for (title, in_deg_s) in [("rate_rad_per_s", 180.0 / std::f64::consts::PI), ("rate_dph", 1.0 / 3600.0)] {
        let bench = r#"{ "id": "line", "sensors": { "V": { "model": "a + b*w_deg_s" } } }"#;
        let rows: String = (0..4).map(|k| format!("{k},{}\n", 1.0 + 0.5 * in_deg_s * f64::from(k))).collect();
        std::fs::write(folder.path().join("table.csv"), format!("{title},V\n{rows}")).expect("a table");
        let text = format!(
            r#"{{ "bench": {bench}, "estimate": {{ "a": {{}}, "b": {{}} }}, "columns": {{ "w_deg_s": "{title}" }}, "readings": "table.csv" }}"#
        );
        std::fs::write(folder.path().join("c.campaign.json"), text).expect("a campaign");
        let found = solved(&Campaign::from_path(folder.path().join("c.campaign.json")).expect(title));
        assert!((found[1] - 0.5).abs() < 1e-12, "{title}: {found:?}");
    }
}

/// A unit that is not known is no reason to take the numbers as they are; words in brackets that are no unit are a remark.
#[test]
fn an_unknown_unit_in_a_title_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let map = r#""theta_deg": "Winkel", "A": "Spannung""#;
    for (angle, volts, unit) in [("Winkel (Grd)", "Spannung (V)", "Grd"), ("Winkel (deg)", "Spannung [mWolt]", "mWolt")]
    {
        let error = campaign(folder.path(), &table(angle, volts, 1.0, 1.0, false), map).expect_err(unit).to_string();
        assert!(error.contains(&format!("'{unit}' is not a known unit")) && error.contains("table.csv"), "{error}");
    }
    // words that may say a unit are none that is passed over
    let error =
        campaign(folder.path(), &table("Winkel (deg)", "Spannung (in mV)", 1.0, 1.0, false), map).expect_err("a unit");
    assert!(error.to_string().contains("'in mV' is not a known unit"), "{error}");
    let remark = table("Winkel (degrees)", "Spannung (channel 1 of 4)", 1.0, 1.0, false);
    assert!((solved(&campaign(folder.path(), &remark, map).expect("a remark"))[1] - 1.3).abs() < 1e-12);
    // a turn a minute is 6 deg/s
    let to = tumble::units::Unit::parse("rpm")
        .expect("rpm")
        .conversion(&tumble::units::Unit::parse("deg/s").expect("deg/s"));
    assert_eq!(to.expect("a rate").apply(10.0), 60.0);
}

/// Written times are seconds since the first of them, in the unit of their key.
#[test]
fn written_times_in_a_table_of_readings() {
    let folder = tempfile::tempdir().expect("a folder");
    for (key, title, per_second, times) in [
        ("time_s", "time", 1.0, ["2026-11-20T23:59:30Z", "2026-11-21T00:00:00Z", "2026-11-21T00:01:00Z"]),
        ("time_s", "Zeit", 1.0, ["20.11.2026 09:14:00", "20.11.2026 09:14:30", "20.11.2026 09:15:30"]),
        ("time_min", "t", 1.0 / 60.0, ["09:14:00.5", "09:14:30.5", "09:15:30.5"]),
        ("t", "t", 1.0, ["05/11/2026 09:14:00", "05/11/2026 09:14:30", "05/11/2026 09:15:30"]),
    ] {
        let value = |seconds: f64| 2.0 + 0.5 * seconds * per_second;
        let row = |(time, seconds): (&&str, f64)| format!("{time},{}\n", value(seconds));
        let rows: String = times.iter().zip([0.0, 30.0, 90.0]).map(row).collect();
        std::fs::write(folder.path().join("table.csv"), format!("{title},V\n{rows}")).expect("a table");
        let text = format!(
            r#"{{ "bench": {{ "id": "line", "sensors": {{ "V": {{ "model": "a + b*{key}" }} }} }}, "estimate": {{ "a": {{}}, "b": {{}} }},
                "columns": {{ "{key}": "{title}" }}, "readings": "table.csv" }}"#
        );
        std::fs::write(folder.path().join("t.campaign.json"), text).expect("a campaign");
        let found = solved(&Campaign::from_path(folder.path().join("t.campaign.json")).expect(key));
        assert!((found[0] - 2.0).abs() < 1e-9 && (found[1] - 0.5).abs() < 1e-9, "{title}: {found:?}");
    }
}

/// Instants in Parquet are seconds since the first of them in a table of readings, as those in text are; with devices (`--by`) as well.
#[test]
fn instants_are_the_same_in_every_format() {
    use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as Physical};
    use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
    use parquet::schema::types::Type;
    use std::sync::Arc;
    let folder = tempfile::tempdir().expect("a folder");
    let seconds = [0_i64, 30, 90, 210];
    let value = |seconds: i64| 2.0 + 0.5 * seconds as f64;
    // 2026-11-20T09:14:00Z
    let start = 1_795_166_040_i64;
    let text: String =
        seconds.iter().map(|s| format!("A,2026-11-20T09:{:02}:{:02}Z,{}\n", 14 + s / 60, s % 60, value(*s))).collect();
    std::fs::write(folder.path().join("t.csv"), format!("serial,time_s,V\n{text}")).expect("a table");
    let field = |title: &str, kind: Physical, logical: Option<LogicalType>| {
        let own = Type::primitive_type_builder(title, kind).with_repetition(Repetition::REQUIRED);
        Arc::new(own.with_logical_type(logical).build().expect("a field"))
    };
    let fields = vec![
        field("serial", Physical::BYTE_ARRAY, Some(LogicalType::String)),
        field("time_s", Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MILLIS))),
        field("V", Physical::DOUBLE, None),
    ];
    let schema = Type::group_type_builder("table").with_fields(fields).build().expect("a schema");
    let file = std::fs::File::create(folder.path().join("t.parquet")).expect("a file");
    let mut writer =
        parquet::file::writer::SerializedFileWriter::new(file, Arc::new(schema), Default::default()).expect("a writer");
    let mut group = writer.next_row_group().expect("a group");
    let mut column = group.next_column().expect("a column").expect("one more");
    column.typed::<ByteArrayType>().write_batch(&vec![ByteArray::from("A"); 4], None, None).expect("values");
    column.close().expect("a column");
    let mut column = group.next_column().expect("a column").expect("one more");
    let times: Vec<i64> = seconds.iter().map(|s| 1000 * (start + s)).collect();
    column.typed::<Int64Type>().write_batch(&times, None, None).expect("values");
    column.close().expect("a column");
    let mut column = group.next_column().expect("a column").expect("one more");
    column.typed::<DoubleType>().write_batch(&seconds.map(value), None, None).expect("values");
    column.close().expect("a column");
    group.close().expect("a group");
    writer.close().expect("a file");
    for table in ["t.csv", "t.parquet"] {
        let text = format!(
            r#"{{ "bench": {{ "id": "line", "sensors": {{ "V": {{ "model": "a + b*time_s" }} }} }}, "estimate": {{ "a": {{}}, "b": {{}} }},
                "readings": "{table}" }}"#
        );
        std::fs::write(folder.path().join("t.campaign.json"), text).expect("a campaign");
        let found = solved(&Campaign::from_path(folder.path().join("t.campaign.json")).expect(table));
        assert!((found[0] - 2.0).abs() < 1e-9 && (found[1] - 0.5).abs() < 1e-9, "{table}: {found:?}");
        let run = assert_cmd::Command::cargo_bin("tumble")
            .expect("the program")
            .current_dir(folder.path())
            .args(["fit", "t.campaign.json", "--by", "serial"])
            .output()
            .expect("a run");
        let out = String::from_utf8(run.stdout).expect("UTF-8");
        let mut lines = out.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let (titles, row) = (lines.next().expect("titles"), lines.next().expect("a device"));
        for (name, truth) in [("a", 2.0), ("b", 0.5)] {
            let place = titles.iter().position(|own| *own == name).expect(name);
            let found: f64 = row[place].parse().unwrap_or_else(|_| panic!("{table}: {out}"));
            assert!((found - truth).abs() < 1e-9, "{table} {name}: {found}");
        }
    }
}

/// What a title says of its unit is one question: a table, devices, rows, means, `reduce --for` and `apply` have one answer, that of V = 0.003 V + 0.02 V/(deg/s) w + 1e-4 V/degC T; and `noise`
/// says it.
#[test]
fn a_title_says_its_unit_through_every_door() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let run = |arguments: &[&str]| {
        let mut program = assert_cmd::Command::cargo_bin("tumble").expect("the program");
        let output = program.current_dir(at).args(arguments).output().expect("a run");
        assert_ne!(output.status.code(), Some(1), "{arguments:?} {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let write = |name: &str, text: String| std::fs::write(at.join(name), text).expect("a file");
    let rates = [180.0, -180.0, 360.0, -360.0, 180.0, -180.0, 360.0, -360.0];
    let celsius = [10.0, 30.0, 50.0, 20.0, 60.0, 0.0, 5.0, 45.0];
    let volts = |k: usize| 0.003 + 0.02 * rates[k] + 1e-4 * celsius[k];
    let positions: Vec<String> = rates
        .iter()
        .enumerate()
        .map(|(k, rate)| format!(r#"{{ "position": "s{k}", "gamma_deg_s": {rate} }}"#))
        .collect();
    let positions = positions.join(", ");
    let kelvin: &dyn Fn(f64) -> f64 = &|t| t + 273.15;
    for (volt, size, temperature, of) in [
        ("V_mV", 1e3, "temp_K", kelvin),
        ("V, mV", 1e3, "temp_degF", &|t| 1.8 * t + 32.0),
        ("V mV", 1e3, "Temp (K)", kelvin),
        ("mV", 1e3, "K", kelvin),
        ("output_uv", 1e6, "T_c", &|t| t),
        ("V/mV", 1e3, "Temp/K", kelvin),
        ("Output/mV", 1e3, "temp K", kelvin),
    ] {
        let columns = format!(r#""columns": {{ "V": "{volt}", "T_c": "{temperature}" }}"#);
        let campaign = |name: &str, more: &str, readings: &str| {
            let text = format!(
                r#"{{ "bench": {{ "id": "g", "units": {{ "rate": "deg/s" }}, "chain": [ {{ "joint": "gamma", "about": "z" }} ],
                    "sensors": {{ "V": {{ "unit": "V", "axes": {{ "I": "z" }}, "model": "V0 + K*w_I + cT*T_c" }} }} }},
                    "estimate": {{ "V0": {{}}, "K": {{}}, "cT": {{}} }}, {more} "readings": {readings} }}"#
            );
            write(name, text);
        };
        let (mut table, mut log) =
            (format!("serial;gamma_deg_s;{temperature};{volt}\n"), format!("time_s;{volt};{temperature};lab\n"));
        for k in 0..8 {
            table += &format!("A;{};{};{}\n", rates[k], of(celsius[k]), size * volts(k));
            for j in 0..200 {
                let value = volts(k) + if j % 2 == 0 { 1e-6 } else { -1e-6 };
                log +=
                    &format!("{:.2};{};{};s{k}\n", f64::from(200 * k as u32 + j) / 50.0, size * value, of(celsius[k]));
            }
        }
        write("table.csv", table);
        write("log.csv", log);
        campaign("table.json", &format!("{columns},"), r#""table.csv""#);
        campaign("devices.json", &format!(r#"{columns}, "by": "serial","#), r#""table.csv""#);
        let samples = |more: &str| {
            format!(r#"{{ "samples": "log.csv", {more} "by": "lab", {columns}, "positions": [ {positions} ] }}"#)
        };
        campaign("rows.json", "", &samples(r#""as": "rows","#));
        campaign("means.json", "", &samples(""));
        campaign("schedule.json", "", &format!("[ {positions} ]"));
        let titles = [format!("V={volt}"), format!("T_c={temperature}")];
        // a title with a comma in it is no list of titles
        if !volt.contains(',') {
            run(&[
                "reduce",
                "log.csv",
                "--for",
                "schedule.json",
                "--by",
                "lab",
                "--columns",
                &titles.join(","),
                "--to",
                "reduced.json",
            ]);
            let report: serde_json::Value =
                serde_json::from_str(&run(&["fit", "reduced.json", "--json", "-"])).expect("a report");
            assert!((report["parameters"][1]["value"].as_f64().expect("K") - 0.02).abs() < 1e-8, "{volt}");
        }
        let check = |door: &str, found: &[f64]| {
            for (value, truth) in found.iter().zip([0.003, 0.02, 1e-4]) {
                // a mean of 1e-6 V in alternation, over whole turns
                assert!((value - truth).abs() < 3e-7, "{door} {volt} {temperature}: {found:?}");
            }
        };
        for door in ["table.json", "rows.json", "means.json"] {
            let report = run(&["fit", door, "--json", if door == "table.json" { "fit.json" } else { "-" }]);
            let report = if door == "table.json" {
                std::fs::read_to_string(at.join("fit.json")).expect("a report")
            } else {
                report
            };
            let report: serde_json::Value = serde_json::from_str(&report).expect("a report");
            let value = |k: usize| report["parameters"][k]["value"].as_f64().expect("a value");
            check(door, &[value(0), value(1), value(2)]);
        }
        let devices = run(&["fit", "devices.json"]);
        let lines: Vec<Vec<&str>> = devices.lines().map(|line| line.split(',').collect()).collect();
        let cell = |name: &str| {
            let place = lines[0].iter().position(|title| *title == name).expect(name);
            lines[1][place].parse::<f64>().expect(name)
        };
        check("devices.json", &[cell("V0"), cell("K"), cell("cT")]);
        let corrected = run(&["apply", "fit.json", "log.csv", "--column", &titles[0], "--column", &titles[1]]);
        for (k, line) in corrected.lines().skip(1).step_by(200).enumerate() {
            let rate: f64 = line.rsplit(',').next().expect("a cell").parse().expect("a rate");
            assert!((rate - rates[k]).abs() < 1e-4, "{volt} {temperature}: {line}");
        }
    }
    let mut log = String::from("time_s,w_rad_s,a_g,w_mV,x\n");
    for k in 0..400_u32 {
        let value = f64::from(k.wrapping_mul(2_654_435_761) >> 8);
        log += &format!("{:.2},{value},{value},{value},{value}\n", f64::from(k) / 100.0);
    }
    write("noise.csv", log);
    let units = |more: &[&str]| {
        let out = run(&[&["noise", "noise.csv", "--json", "-"], more].concat());
        let report: serde_json::Value = serde_json::from_str(&out).expect("a report");
        let columns = report["columns"].as_array().expect("columns").iter();
        columns.map(|column| column["unit"].as_str().expect("a unit").to_string()).collect::<Vec<_>>()
    };
    assert_eq!(units(&[]), ["rad/s", "g", "mV", "unit"]);
    assert_eq!(units(&["--unit", "deg/s"]), ["rad/s", "deg/s", "deg/s", "deg/s"]);
}

/// A title that no model line can use is no candidate of a diagnosis, and is named as not tried; with a name for it in `columns` it is one.
#[test]
fn titles_that_are_no_names_are_not_tried() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = String::from("theta_deg;A;Run #\n");
    for k in 0..12 {
        let theta = 30.0 * f64::from(k);
        text += &format!("{theta};{};{}\n", 0.002 - 1.3 * theta.to_radians().sin() + 1e-3 * f64::from(k % 5), k % 5);
    }
    for (columns, untried) in [("", vec!["Run #".to_string()]), (r#""run": "Run #""#, vec![])] {
        let campaign = campaign(folder.path(), &text, columns).expect("a campaign");
        let settings = tumble::diagnosis::Settings::default();
        let effects = tumble::wire::built_in_effects().expect("the catalogue");
        let diagnosis = tumble::diagnosis::diagnose(&campaign, &effects, &settings).expect("a diagnosis");
        let report = tumble::report::diagnose_report(&campaign, &diagnosis, &settings);
        assert_eq!(report.untried_columns, untried);
        // what was put into the readings is found once it has a name
        assert_eq!(report.effects.iter().any(|effect| effect.regressor == "run"), untried.is_empty());
    }
}
