//! `tumble new`: from tables that no example has to campaigns that run, asked of options and at a terminal.

use assert_cmd::Command;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

fn tumble(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::cargo_bin("tumble").expect("the program");
    let output = command.current_dir(folder).args(arguments).output().expect("a run");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

/// The report of a fit that was accepted.
fn report(folder: &Path, campaign: &str) -> Value {
    let (code, out, told) = tumble(folder, &["fit", campaign, "--json", "-"]);
    assert_eq!(code, 0, "{told}");
    serde_json::from_str(&out).expect("a report")
}

fn estimate(report: &Value, id: &str) -> (f64, f64) {
    let own = report["parameters"].as_array().expect("parameters").iter().find(|p| p["id"] == id).expect("a parameter");
    (own["value"].as_f64().expect("a value"), own["u"].as_f64().expect("a u"))
}

const LATITUDE_DEG: f64 = 52.1;
const EARTH_RATE_DEG_S: f64 = 15.041067 / 3600.0;

/// A German spreadsheet of a gyro of 20 mV/(deg/s) and 2.5 mV on a rate table, at rest too, to the last digit that it shows.
fn rates(folder: &Path) {
    let mut table = String::from("Messung;Drehrate (°/s);Ausgang [mV]\n");
    for (k, rate) in [0.0, 10.0, -10.0, 25.0, -25.0, 50.0, -50.0, 100.0, -100.0, 150.0, -150.0].iter().enumerate() {
        let input = rate + EARTH_RATE_DEG_S * LATITUDE_DEG.to_radians().sin();
        writeln!(table, "{};{rate};{:.6}", k + 1, 2.5 + 20.0 * input).expect("written");
    }
    std::fs::write(folder.join("Drehtisch.csv"), table.replace('.', ",")).expect("a table");
}

#[test]
fn a_table_becomes_a_campaign_that_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    rates(folder);
    // what is missing is named, nothing is asked, nothing is written
    for (given, option) in [
        (&["new", "Drehtisch.csv"][..], "--bench"),
        (&["new", "Drehtisch.csv", "--bench", "gyro-rate-steps"], "--latitude"),
        (&["new", "Drehtisch.csv", "--bench", "own"], "--chain"),
        (&["new", "Drehtisch.csv", "--bench", "own", "--chain", "none"], "--model"),
        (&["new", "Drehtisch.csv", "--bench", "gyro-turntable", "--latitude", "52.1"], "--columns gamma_deg=TITLE"),
    ] {
        let (code, _, told) = tumble(folder, given);
        assert!(code == 1 && told.contains(option), "{given:?}: {told}");
    }
    let (_, _, told) = tumble(folder, &["new", "Drehtisch.csv"]);
    assert!(told.contains("gyro-rate-steps"), "{told}");
    assert_eq!(std::fs::read_dir(folder).expect("a folder").count(), 1);

    let given = ["new", "Drehtisch.csv", "--bench", "gyro-rate-steps", "--latitude", "52.1"];
    let (code, out, told) = tumble(folder, &given);
    assert_eq!(code, 0, "{out}{told}");
    assert!(out.contains("next: tumble fit Drehtisch.campaign.json"), "{out}");
    let report = report(folder, "Drehtisch.campaign.json");
    // six digits of mV are shown: half of the last is 5e-10 V, over ten readings of up to 150 deg/s
    let ((k, _), (v0, _)) = (estimate(&report, "K"), estimate(&report, "V0"));
    assert!((k - 0.02).abs() < 5e-10 && (v0 - 0.0025).abs() < 5e-9, "{k} {v0}");

    // it belongs to its user now: it is not replaced, and editors find its schema beside it
    let before = std::fs::read_to_string(folder.join("Drehtisch.campaign.json")).expect("a campaign");
    let (code, _, told) = tumble(folder, &given);
    assert!(code == 1 && told.contains("is not replaced"), "{told}");
    assert_eq!(std::fs::read_to_string(folder.join("Drehtisch.campaign.json")).expect("a campaign"), before);
    let file: Value = serde_json::from_str(&before).expect("JSON");
    let schema = folder.join(file["$schema"].as_str().expect("a schema"));
    let schema: Value = serde_json::from_str(&std::fs::read_to_string(schema).expect("the schema")).expect("JSON");
    assert!(jsonschema::validator_for(&schema).expect("a schema").is_valid(&file));
    assert_eq!(file["columns"]["V"], "Ausgang [mV]");
}

/// Readings at rest between steps of rate need an angle, in a column that the others leave empty: the error says so. What the same table then
/// becomes has the identities that a certificate needs.
#[test]
fn a_table_becomes_a_certificate() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    rates(folder);
    let table = std::fs::read_to_string(folder.join("Drehtisch.csv")).expect("a table");
    // at rest the Earth's rate alone is in the reading
    let rest = format!("{:.6}", 2.5 + 20.0 * EARTH_RATE_DEG_S * LATITUDE_DEG.to_radians().sin()).replace('.', ",");
    let start = "new Ruhe.csv --bench gyro-rate-steps --latitude 52.1 --serial 7";
    let given = |more: &str| -> Vec<String> { format!("{start} {more}").split(' ').map(str::to_string).collect() };
    let run = |given: &[String]| tumble(folder, &given.iter().map(String::as_str).collect::<Vec<_>>());
    let rows =
        table.lines().enumerate().map(|(k, line)| format!("{line};{}\n", if k == 0 { "Winkel (°)" } else { "" }));
    std::fs::write(folder.join("Ruhe.csv"), rows.collect::<String>() + &format!("11;0,0;{rest};0\n")).expect("a table");
    for wrong in ["12.03.2026", "2026-02-30"] {
        let (code, _, told) = run(&given(&format!("--date {wrong}")));
        assert!(code == 1 && told.contains("this is not a day"), "{wrong}: {told}");
    }
    let (code, out, told) = run(&given("--date 2026-03-12"));
    assert_eq!(code, 0, "{out}{told}");
    let lab = "new lab --id C-1 --country DE --issued 2026-11-20 --laboratory Lab --city Bremen --person A --customer B --customer-city Jena";
    assert_eq!(tumble(folder, &lab.split(' ').collect::<Vec<_>>()).0, 0);
    let (code, _, told) = tumble(folder, &["fit", "Ruhe.campaign.json", "--dcc", "c.xml", "--lab", "lab.json"]);
    assert_eq!(code, 0, "{told}");
    let certificate = std::fs::read_to_string(folder.join("c.xml")).expect("a certificate");
    assert!(certificate.contains("2026-03-12") && certificate.contains("<dcc:value>7</dcc:value>"), "{certificate}");
}

/// What is known is taken with its unit and u; what the readings do not determine is said, and is exit code 2.
#[test]
fn what_is_known_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    rates(folder);
    let own = ["new", "Drehtisch.csv", "--latitude", "52.1", "--bench", "own", "--chain", "turn:z"];
    let columns = ["--columns", "turn_deg_s=Drehrate,V=Ausgang", "--model", "V [mV] = V0 + s*k*w_z"];
    let (code, out, told) = tumble(folder, &[&own[..], &columns, &["--start", "k=15", "--start", "s=1"]].concat());
    assert!(code == 2 && out.contains("NOT DETERMINED") && out.contains("s, k"), "{out}{told}");
    assert!(out.contains("with --known k=15 these readings determine all others"), "{out}{told}");
    let named = ["--known", "s=1+-0.0005", "--start", "k=15 mV/(deg/s)", "--to", "known.campaign.json"];
    std::fs::write(folder.join("known.bench.json"), "{}").expect("a file");
    let (code, out, told) = tumble(folder, &[&own[..], &columns, &named].concat());
    assert_eq!(code, 1, "the bench of the same name stays: {out}{told}");
    assert!(!folder.join("known.campaign.json").exists(), "{out}{told}");
    // under another name both are new
    let other = [&own[..], &columns, &named[..4], &["--to", "other.campaign.json"]].concat();
    let (code, out, told) = tumble(folder, &other);
    assert!(code == 0 && folder.join("other.bench.json").exists(), "{out}{told}");
    let bench = ["new", "Drehtisch.csv", "--bench", "Drehtisch.bench.json", "--latitude", "52.1"];
    let (code, out, told) =
        tumble(folder, &[&bench[..], &["--columns", "turn_deg_s=Drehrate,V=Ausgang"], &named].concat());
    assert_eq!(code, 0, "{out}{told}");
    let report = report(folder, "known.campaign.json");
    let (k, u) = estimate(&report, "k");
    // GUM 5.1: k = 20/s, so that u(k) = 20 u(s)/s; the table's own digits are 1e6 times smaller
    assert!((k - 20.0).abs() < 1e-6 && (u - 0.01).abs() < 1e-6, "{k} {u}");
    for wrong in ["q=1", "s", "s=high", "s=1+-x", "V0=1 kg"] {
        let given = [&bench[..], &["--columns", "turn_deg_s=Drehrate,V=Ausgang", "--to", "x.json", "--known", wrong]];
        let (code, _, told) = tumble(folder, &given.concat());
        assert!(code == 1 && told.contains("error"), "{wrong}: {told}");
    }
}

/// A telephone laid down in fourteen attitudes: 100 samples a second, offsets and scale errors as phones have them.
#[test]
fn a_loggers_record_becomes_a_campaign_that_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (bias, scale) = ([0.12, -0.08, 0.21], [1.004, 0.997, 1.011]);
    let mut seed = 1_u64;
    let mut noise = move || {
        // sum of twelve uniform numbers less six: sd 1
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    };
    let mut attitudes: Vec<[f64; 3]> = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut up = [0.0; 3];
            up[axis] = sign;
            attitudes.push(up);
        }
    }
    for corner in 0..8 {
        attitudes.push([0, 1, 2].map(|k| if corner >> k & 1 == 0 { 1.0 } else { -1.0 } / 3.0_f64.sqrt()));
    }
    let mut table = String::from("timestamp (s),ax (m/s^2),ay (m/s^2),az (m/s^2)\n");
    for k in 0..attitudes.len() * 500 {
        let (up, moving) = (attitudes[k / 500], k % 500 >= 400);
        write!(table, "{:.2}", k as f64 * 0.01).expect("written");
        for axis in 0..3 {
            let swing = if moving { 3.0 * (k as f64 * 0.3).sin() } else { 0.0 };
            let read = (9.81 * up[axis] + swing) / scale[axis] + bias[axis] + 0.01 * noise();
            write!(table, ",{read:.5}").expect("written");
        }
        table.push('\n');
    }
    std::fs::write(folder.join("phone.csv"), table).expect("a record");
    let given =
        ["new", "phone.csv", "--samples", "still", "--bench", "accelerometer-triad-norm", "--position", "norm=9.81"];
    let start = ["--start", "s_x=1", "--start", "s_y=1", "--start", "s_z=1"];
    let (code, out, told) = tumble(folder, &[&given[..], &start].concat());
    assert_eq!(code, 0, "{out}{told}");
    // the record is read for the names, for the fit and for the check, and says once what was made of it
    assert_eq!(told.matches("14 readings reduced").count(), 1, "{told}");
    let report = report(folder, "phone.campaign.json");
    assert_eq!(report["fit"]["readings"], 14);
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        for (id, truth) in [(format!("b_{axis}"), bias[k]), (format!("s_{axis}"), scale[k])] {
            let (value, u) = estimate(&report, &id);
            assert!((value - truth).abs() < 4.0 * u && u < 1e-3, "{id}: {value} {u}");
        }
    }
}

#[test]
fn a_lab_file_is_one_that_certificates_take() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let (code, _, told) = tumble(folder, &["new", "lab", "--id", "C-1"]);
    assert!(code == 1 && told.contains("--country"), "{told}");
    let given = "new lab --id C-1 --country DE --issued 2026-11-20 --laboratory Lab --city Bremen --person A --customer B --customer-city Jena";
    let given: Vec<&str> = given.split(' ').collect();
    let (code, out, told) = tumble(folder, &given);
    assert_eq!(code, 0, "{out}{told}");
    let campaign = root("data/campaigns/li2012-table1.campaign.json");
    let text = std::fs::read_to_string(campaign).expect("a campaign");
    let text = text.replacen('{', r#"{ "unit": { "serial": "7" }, "date": "2026-11-19","#, 1);
    std::fs::write(folder.join("c.json"), text).expect("written");
    let (code, _, told) = tumble(folder, &["fit", "c.json", "--dcc", "c.xml", "--lab", "lab.json"]);
    assert!(code == 0 && folder.join("c.xml").exists(), "{told}");
    assert_eq!(tumble(folder, &given).0, 1);
}

fn root(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// At a terminal everything is asked for, a wrong answer once more; `script` of util-linux makes the terminal.
#[cfg(target_os = "linux")]
#[test]
fn a_person_is_asked() {
    use std::io::Write as _;
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    rates(folder);
    let program = assert_cmd::cargo::cargo_bin("tumble");
    let asked = format!("{} new Drehtisch.csv", program.display());
    let mut script = Command::new("script");
    script.args(["-qec", &asked, "/dev/null"]).current_dir(folder);
    let spawned = script.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let Ok(mut child) = spawned else {
        println!("no `script` here: not tried");
        return;
    };
    // no record, after a column of labels that is not there; one device; a bench that is not there, one that is; the three columns, the first of them after texts
    // that mean nothing, the second once as a joint that the bench has not; a latitude; known values, some of them malformed; a serial number, and no day
    let answers = "labels\n\nserial\n\nno-bench\ngyro-rate-steps\nnumber of the row\n-\nbeta_deg_s\n\n\nnorth\n52.1\nA=0\nK2=none\nK=1 kg\n\nG-7\n\n";
    child.stdin.take().expect("a terminal").write_all(answers.as_bytes()).expect("answers");
    let output = child.wait_with_output().expect("an end");
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && told.contains("there is no bench 'no-bench'"), "{told}");
    assert!(told.contains("ground--(gamma z)--[V]") && told.contains("this is not a latitude"), "{told}");
    // each wrong answer is named where it is given, with what may stand there
    let plain = told.replace("\u{1b}[31m", "").replace("\u{1b}[36m", "").replace("\u{1b}[0m", "");
    let said = plain.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
    for wrong in [
        "the table has no column 'labels' help: expected one of",
        "the table has no column 'serial'",
        "readings on this bench have no 'number of the row' help: expected one of position, n, time_s, gamma_deg, gamma_deg_s",
        "readings on this bench have no 'beta_deg_s'",
        "the unit of K has another dimension",
    ] {
        assert!(said.contains(wrong), "{wrong}: {said}");
    }
    let report = report(folder, "Drehtisch.campaign.json");
    assert!((estimate(&report, "K").0 - 0.02).abs() < 5e-10);
    assert_eq!(report["assumed_zero"], serde_json::json!(["A"]));
    let file = std::fs::read_to_string(folder.join("Drehtisch.campaign.json")).expect("a campaign");
    let file: Value = serde_json::from_str(&file).expect("JSON");
    assert_eq!((&file["unit"]["serial"], file.get("date")), (&Value::from("G-7"), None));
}

/// Many devices in one table, one cell of one of them empty: that device is malformed, and the campaign is written.
#[test]
fn one_empty_cell_of_one_device_stops_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let mut table = String::from("serial,gamma_deg_s,V\n");
    for device in 0..400 {
        for rate in [10.0, -10.0, 50.0, -50.0, 100.0, -100.0] {
            let shown = if device == 123 && rate == 50.0 { String::new() } else { rate.to_string() };
            writeln!(table, "S-{device:03},{shown},{:.6}", 0.0025 + 0.02 * rate).expect("written");
        }
    }
    std::fs::write(folder.join("line.csv"), table).expect("a table");
    let given =
        ["new", "line.csv", "--bench", "gyro-rate-steps", "--latitude", "0", "--known", "A=0", "--by", "serial"];
    let (code, out, told) = tumble(folder, &given);
    assert_eq!(code, 0, "{out}{told}");
    let out = out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(out.contains("400 devices, 1 of them malformed (the first: 'S-123'"), "{out}");
    let (code, rows, told) = tumble(folder, &["fit", "line.campaign.json", "--to", "fits.csv"]);
    assert!(code != 1, "{rows}{told}");
    let rows = std::fs::read_to_string(folder.join("fits.csv")).expect("rows");
    assert_eq!(rows.lines().filter(|row| row.contains("malformed")).count(), 1, "{rows}");
    let (code, _, told) =
        tumble(folder, &["new", "line.csv", "--bench", "gyro-rate-steps", "--by", "device", "--to", "z.json"]);
    assert!(code == 1 && told.contains("no column 'device'"), "{told}");
}

/// Units at the end of a title, without brackets, count where the column is named; `in` says one anywhere.
#[test]
fn units_without_brackets_convert() {
    for (rate, output) in [
        ("Rate rpm", "U_uV"),
        ("rate_rad_s", "U uV"),
        ("Drehrate in °/s", "U in V"),
        ("rate_mdps", "U (mV)"),
        ("Rate deg/s", "Output [V] mean"),
        ("角速度（°/s）", "输出【V】"),
        ("Rate, table (deg/s)", "Output V"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let (of_rate, of_output) = match (rate, output) {
            ("Rate rpm", _) => (1.0 / 6.0, 1e3),
            ("rate_rad_s", _) => (std::f64::consts::PI / 180.0, 1e3),
            ("rate_mdps", _) => (1e3, 1.0),
            _ => (1.0, 1e-3),
        };
        let row = |deg_s: f64| format!("{};{}\n", deg_s * of_rate, (2.5 + 20.0 * deg_s) * of_output);
        let rows: String = [-100.0, -50.0, -20.0, 20.0, 50.0, 100.0].map(row).concat();
        std::fs::write(folder.join("t.csv"), format!("{rate};{output}\n{rows}")).expect("a table");
        let columns = format!("turn_deg_s={rate},V={output}");
        let given = [
            "new",
            "t.csv",
            "--latitude",
            "0",
            "--bench",
            "own",
            "--chain",
            "turn:z",
            "--columns",
            &columns,
            "--model",
            "V [mV] = V0 + k*w_z",
        ];
        let (code, out, told) = tumble(folder, &given);
        assert_eq!(code, 0, "{rate} {output}: {out}{told}");
        let (k, _) = estimate(&report(folder, "t.campaign.json"), "k");
        assert!((k - 20.0).abs() < 1e-9, "{rate} {output}: {k}");
    }
}

/// A built-in bench in LSB and a table in m/s^2: the bench is written with the units of the table.
#[test]
fn a_bench_takes_the_units_of_the_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let faces = [
        (0, 0, [0., 0., 1.]),
        (0, 180, [0., 0., -1.]),
        (0, 90, [0., 1., 0.]),
        (0, 270, [0., -1., 0.]),
        (270, 0, [1., 0., 0.]),
        (90, 0, [-1., 0., 0.]),
    ];
    let row = |(k, (pitch, roll, up)): (usize, &(i32, i32, [f64; 3]))| {
        let [x, y, z] = up.map(|up| 9.81 * up + 0.02);
        [0.0, 1e-4, -1e-4]
            .map(|noise| format!("{k},{pitch},{roll},{},{},{}\n", x + noise, y - noise, z + noise))
            .concat()
    };
    let rows: String = faces.iter().enumerate().map(row).collect();
    std::fs::write(
        folder.join("t.csv"),
        format!("position,pitch_deg,roll_deg,ax [m/s^2],ay [m/s^2],az [m/s^2]\n{rows}"),
    )
    .expect("a table");
    let (code, out, told) = tumble(folder, &["new", "t.csv", "--bench", "accelerometer-six-positions"]);
    assert!(code == 0 && out.contains("t.bench.json"), "{out}{told}");
    let report = report(folder, "t.campaign.json");
    // site without latitude: standard gravity, so K is 9.81 (m/s^2)/g
    let (k, _) = estimate(&report, "Kx");
    assert!((k - 9.81).abs() < 1e-9, "{k}");
    let unit =
        report["parameters"].as_array().expect("parameters").iter().find(|own| own["id"] == "Kx").expect("Kx")["unit"]
            .clone();
    assert_eq!(unit, "m/s^2/g");
}

/// A column of times by its title, a temperature that no model line has, a title with a comma, a name with blanks; what is not said is said.
#[test]
fn titles_of_loggers_have_a_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let mut table = String::from("Rate, table (deg/s);Ausgang;Temp. (°C)\n");
    for (k, rate) in [10.0, -10.0, 30.0, -30.0, 80.0, -80.0, 120.0, -120.0].iter().enumerate() {
        writeln!(table, "{rate};{};{}", 0.002 + 0.02 * rate + 1e-6 * k as f64, 20.0 + 0.3 * k as f64).expect("written");
    }
    std::fs::write(folder.join("two words.csv"), table).expect("a table");
    let columns = "gamma_deg_s=Rate, table (deg/s),V=Ausgang";
    let given = ["new", "two words.csv", "--bench", "gyro-rate-steps", "--latitude", "52", "--columns", columns];
    let (code, out, told) = tumble(folder, &given);
    assert_eq!(code, 0, "{out}{told}");
    assert!(out.contains("'Ausgang' is taken in V"), "{out}");
    assert!(out.contains("next: tumble fit 'two words.campaign.json'"), "{out}");
    let campaign = std::fs::read_to_string(folder.join("two words.campaign.json")).expect("a campaign");
    let campaign: Value = serde_json::from_str(&campaign).expect("JSON");
    assert_eq!(campaign["columns"]["temperature_c"], "Temp. (°C)");
    let (value, _) = estimate(&report(folder, "two words.campaign.json"), "K");
    assert!((value - 0.02).abs() < 1e-6, "{value}");

    // titles without rows are no table of readings
    std::fs::write(folder.join("empty.csv"), "gamma_deg_s,V\n").expect("a table");
    let (code, _, told) = tumble(folder, &["new", "empty.csv", "--bench", "gyro-rate-steps", "--latitude", "52"]);
    assert!(code == 1 && told.contains("has no readings"), "{told}");

    let mut log = String::from("Tiempo en segundos,ax (m/s^2)\n");
    for k in 0..4000 {
        let up = if k / 1000 % 2 == 0 { 9.81 } else { -9.81 };
        let noise = f64::from((k * 7919 + 13) % 1000) * 1e-5;
        writeln!(log, "{:.2},{:.5}", f64::from(k) * 0.01, 0.05 + 1.01 * up + noise).expect("written");
    }
    std::fs::write(folder.join("log.csv"), log).expect("a record");
    for time in [["--time", "Tiempo en segundos"], ["--columns", "time_s=Tiempo en segundos"]] {
        let given = ["new", "log.csv", "--samples", "still", "--bench", "own", "--chain", "face:x", "--model"];
        let line = ["A [m/s^2] = b + k*a_z", "--columns", "A=ax (m/s^2)"];
        let positions = ["--position", "face_deg=0", "--position", "face_deg=180", "--position", "face_deg=0"];
        let last = ["--position", "face_deg=180", "--to", if time[0] == "--time" { "a.json" } else { "b.json" }];
        let (code, out, told) = tumble(folder, &[&given[..], &line, &time, &positions, &last].concat());
        assert_eq!(code, 0, "{out}{told}");
        let (value, u) = estimate(&report(folder, last[3]), "k");
        // of g: a_z is in units of gravity
        assert!((value - 1.01 * 9.81).abs() < 1e-3 + 4.0 * u, "{value} {u}");
    }
}

/// Means of a record: columns that have their own name as title stay beside those that are named.
#[test]
fn columns_under_their_own_names_stay() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let bench = r#"{ "id": "g", "units": { "rate": "deg/s" }, "chain": [ { "joint": "gamma", "about": "z" } ],
        "sensors": { "V": { "unit": "V", "axes": { "I": "z" }, "model": "V0 + K*w_I + cT*T_c" } } }"#;
    std::fs::write(folder.join("g.bench.json"), bench).expect("a bench");
    let (rates, celsius) = ([180.0, -180.0, 360.0, -360.0, 180.0, -180.0], [10.0, 30.0, 50.0, 20.0, 60.0, 0.0]);
    let given: Vec<String> =
        rates.iter().flat_map(|rate| ["--position".into(), format!("gamma_deg_s={rate}")]).collect();
    for (titles, size, zero, columns) in
        [(["V", "temp (K)"], 1.0, 273.15, "T_c=temp (K)"), (["Ausgang (mV)", "T_c"], 1e3, 0.0, "V=Ausgang (mV)")]
    {
        let mut log = format!("time_s,{},{},lab\n", titles[0], titles[1]);
        for (k, (rate, t)) in rates.iter().zip(celsius).enumerate() {
            for j in 0..200 {
                let value = 0.003 + 0.02 * rate + 1e-4 * t + if j % 2 == 0 { 1e-6 } else { -1e-6 };
                writeln!(log, "{:.2},{},{},s{k}", (200 * k + j) as f64 / 50.0, size * value, t + zero)
                    .expect("written");
            }
        }
        std::fs::write(folder.join("log.csv"), log).expect("a record");
        let to = format!("{}.json", columns.split('=').next().expect("a key"));
        let asked = ["new", "log.csv", "--samples", "lab", "--bench", "g.bench.json", "--latitude", "0"];
        let more = ["--columns", columns, "--to", &to];
        let given: Vec<&str> = asked.into_iter().chain(more).chain(given.iter().map(String::as_str)).collect();
        let (code, out, told) = tumble(folder, &given);
        assert_eq!(code, 0, "{out}{told}");
        let report = report(folder, &to);
        assert_eq!(report["parameters"].as_array().map(Vec::len), Some(3), "{report}");
        for (id, truth) in [("V0", 0.003), ("K", 0.02), ("cT", 1e-4)] {
            let (value, _) = estimate(&report, id);
            assert!((value - truth).abs() < 3e-7, "{columns} {id}: {value}");
        }
    }
}
