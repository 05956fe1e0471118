//! Records in and out of Parquet: the same numbers as from text to text, and what is not corrected stays.

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

fn tumble(arguments: &[&str]) -> (Option<i32>, String, String) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(env!("CARGO_BIN_EXE_tumble")).args(arguments).current_dir(root).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// The calibration of the gyro of example 01, as a file.
fn calibration(folder: &Path) -> PathBuf {
    let path = folder.join("gyro.fit.json");
    tumble(&["fit", "examples/01-gyro-table/table1.campaign.json", "--json", path.to_str().unwrap()]);
    assert!(path.exists());
    path
}

/// Three rows, the second without a reading: time, a remark, the voltage in single precision.
fn log(path: &Path) {
    let field = |name: &str, physical: Physical| {
        let builder = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
        let text = physical == Physical::BYTE_ARRAY;
        Arc::new(if text { builder.with_logical_type(Some(LogicalType::String)) } else { builder }.build().unwrap())
    };
    let fields =
        vec![field("time_s", Physical::DOUBLE), field("remark", Physical::BYTE_ARRAY), field("V", Physical::FLOAT)];
    let schema = Arc::new(Type::group_type_builder("log").with_fields(fields).build().unwrap());
    let file = std::fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<DoubleType>().write_batch(&[0.0, 0.1, 0.2], Some(&[1, 1, 1]), None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let texts = [ByteArray::from("warm, still"), ByteArray::from("end")];
    column.typed::<ByteArrayType>().write_batch(&texts, Some(&[1, 0, 1]), None).unwrap();
    column.close().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<FloatType>().write_batch(&[-2.75_f32, 1.5], Some(&[1, 0, 1]), None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
}

#[test]
fn a_record_in_parquet_is_corrected_as_one_in_text() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let gyro = calibration(folder.path());
    let gyro = gyro.to_str().unwrap();
    log(Path::new(&at("log.parquet")));
    // single precision holds both readings exactly
    std::fs::write(at("log.csv"), "time_s,remark,V\n0,\"warm, still\",-2.75\n0.1,,\n0.2,end,1.5\n").unwrap();

    let (code, from_text, _) = tumble(&["apply", gyro, &at("log.csv"), "--u"]);
    assert_eq!(code, Some(2), "the row without a reading");
    let (code, from_columns, error) = tumble(&["apply", gyro, &at("log.parquet"), "--u"]);
    assert!(code == Some(2) && error.contains("1 of 3 rows"), "{error}");
    assert_eq!(from_columns, from_text);
    assert!(from_text.contains("0,\"warm, still\",") && from_text.lines().nth(2) == Some("0.1,,,"), "{from_text}");

    // to Parquet from both, the second in the place of the first, and read back: by the program itself, which copies what it does not know
    for log in ["log.csv", "log.parquet"] {
        let (code, out, error) = tumble(&["apply", gyro, &at(log), "--u", "--out", &at("corrected.parquet")]);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{error}");
        let file = std::fs::File::open(at("corrected.parquet")).unwrap();
        let mut record = tumble::record::Record::open("corrected", file).unwrap();
        use tumble::record::As::{Label, Number};
        let columns = ["time_s", "remark", "w_I", "w_I_u"].map(|name| record.find(name).unwrap());
        record.select(&[(columns[0], Number), (columns[1], Label), (columns[2], Number), (columns[3], Number)]);
        let mut block = tumble::record::Block::default();
        assert!(record.next(&mut block).unwrap());
        assert_eq!(block.columns[0], [0.0, 0.1, 0.2]);
        let remarks: Vec<&str> =
            block.columns[1].iter().map(|n| record.labels().get(*n as usize).map_or("", String::as_str)).collect();
        assert_eq!(remarks[0], "warm, still");
        assert_eq!(remarks[2], "end");
        for (row, line) in from_text.lines().skip(1).enumerate() {
            let cells: Vec<&str> = line.rsplit(',').take(2).collect();
            for (cell, column) in cells.iter().rev().zip(&block.columns[2..]) {
                match cell.parse::<f64>() {
                    Ok(value) => assert_eq!(value, column[row], "{log} {row}"),
                    Err(_) => assert!(column[row].is_nan(), "{log} {row}"),
                }
            }
        }
    }
}

#[test]
fn a_stream_of_text_cannot_become_parquet() {
    let folder = tempfile::tempdir().unwrap();
    let gyro = calibration(folder.path());
    let out = folder.path().join("corrected.parquet");
    let (code, _, error) = tumble(&["apply", gyro.to_str().unwrap(), "-", "--out", out.to_str().unwrap()]);
    assert!(code == Some(1) && error.contains("a record in a file"), "{error}");
    assert!(!out.exists());
}
