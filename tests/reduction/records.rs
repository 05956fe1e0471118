//! Records in the dialects of loggers and spreadsheets.

use std::io::{Cursor, Write};
use tumble::record::{As, Block, Cells, Held, Record, UNREADABLE};

/// All numbers of a table: titles and columns.
fn read(bytes: Vec<u8>) -> Result<(Vec<String>, Vec<Vec<f64>>), String> {
    let mut table = Record::of_stream("log.csv", Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let titles: Vec<String> = table.columns().iter().map(|c| c.title.clone()).collect();
    table.select(&(0..titles.len()).map(|k| (k, As::Number)).collect::<Vec<_>>());
    let mut columns = vec![Vec::new(); titles.len()];
    let mut block = Block::default();
    while table.next(&mut block).map_err(|e| e.to_string())? {
        columns.iter_mut().zip(&block.columns).for_each(|(all, part)| all.extend_from_slice(part));
    }
    Ok((titles, columns))
}

#[track_caller]
fn check(bytes: Vec<u8>, titles: &[&str], columns: &[&[f64]]) {
    let (found, values) = read(bytes).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(found, titles);
    let same = |a: &f64, b: &f64| a == b || (a.is_nan() && b.is_nan());
    for (found, expected) in values.iter().zip(columns) {
        assert!(found.len() == expected.len() && found.iter().zip(*expected).all(|(a, b)| same(a, b)), "{values:?}");
    }
}

#[test]
fn dialects() {
    let plain: (&[&str], [&[f64]; 2]) = (&["t", "V"], [&[0.0, 0.5], &[1.25, -2.5e-3]]);
    for text in [
        "t,V\n0,1.25\n0.5,-2.5e-3\n",
        "t;V\r\n0;1,25\r\n0,5;-2,5e-3\r\n",
        "t\tV\n0\t1.25\n0.5\t-2.5e-3",
        "# a remark\n\nt, V\n0, 1.25\n# another\n\n0.5, -2.5e-3\n,\n",
        "\u{feff}\"t\";\"V\"\n\"0\";\"1,25\"\n\"0,5\";\"-2,5e-3\"\n;;\n;\n",
        "Logger 7;serial 12\nstarted;today\nt;V\n0;1.25\n0.5;-2.5e-3\n",
        "  t   V\n  0   1.25\n  0.5  -2.5e-3\n",
        "t;V\ns;mV\n0;1.25\n0.5;-2.5e-3\n",
    ] {
        check(text.into(), plain.0, &plain.1);
    }
    check(
        "t [s],Winkel (\u{b0})\n0,NaN\n1,\n".into(),
        &["t [s]", "Winkel (\u{b0})"],
        &[&[0.0, 1.0], &[f64::NAN, f64::NAN]],
    );
    check("1 2\n3 4\n".into(), &["c1", "c2"], &[&[1.0, 3.0], &[2.0, 4.0]]);
    check("V\n1,5\n2,5\n".into(), &["V"], &[&[1.5, 2.5]]);
}

/// Digits in groups of three, the minus of typesetters, and what stands for no number.
#[test]
fn numbers_as_people_write_them() {
    for text in [
        "t;V\n1 000;-1 234 567,5\n2 000;1,5\n",
        "t;V\n1\u{a0}000;\u{2212}1\u{202f}234\u{202f}567,5\n2000;1,5\n",
        "t;V\n1'000;-1'234'567.5\n2'000;1.5\n",
    ] {
        check(text.into(), &["t", "V"], &[&[1000.0, 2000.0], &[-1_234_567.5, 1.5]]);
    }
    check(
        "t;V\n1\u{a0}000;1,5\n2\u{a0}000;2,5\n".chars().map(|c| u8::try_from(c).expect("Latin-1")).collect(),
        &["t", "V"],
        &[&[1000.0, 2000.0], &[1.5, 2.5]],
    );
    check(
        "t,V\n0,1\n1,---\n2,inf\n3,#DIV/0!\n".into(),
        &["t", "V"],
        &[&[0.0, 1.0, 2.0, 3.0], &[1.0, f64::NAN, f64::NAN, f64::NAN]],
    );
    // of comma and point the one that is no decimal mark groups where it stands twice, or before a decimal mark
    for text in [
        "t;V\n0,5;1.234.567,8\n1,5;-2.345,6\n",
        "t\tV\n0.5\t1,234,567.8\n1.5\t-2,345.6\n",
        "t,V\n0.5,\"1,234,567.8\"\n1.5,\"-2,345.6\"\n",
    ] {
        check(text.into(), &["t", "V"], &[&[0.5, 1.5], &[1_234_567.8, -2345.6]]);
    }
    check("t;V\n1;1.234.567\n2;-2.345.678\n".into(), &["t", "V"], &[&[1.0, 2.0], &[1_234_567.0, -2_345_678.0]]);
    // alone it may be the other decimal mark
    for text in ["t;V\n0,5;1,5\n1,5;20.998\n", "t\tV\n0.5\t1.5\n1.5\t20,998\n", "t;V\n0,5;1,5\n1,5;1234.567.890,5\n"] {
        assert!(read(text.into()).is_err(), "{text}");
    }
    for text in ["t;V\n1 00;1,5\n2;2,5\n", "t;V\n1;1,5\n1'0000;2,5\n", "t;V\n1;1,5\n2;1 5\n"] {
        assert!(read(text.into()).is_err(), "{text}");
    }
}

/// A column of written times in memory, as devices have it: since the first, as in a table of text.
#[test]
fn written_times_in_memory() {
    let texts = ["", "2024-01-01T00:00:10", "2024-01-01 00:00:12.5", "none"].map(String::from).to_vec();
    let mut table = Record::from(Held::of("table", vec![("t".into(), Cells::Texts(texts))]).expect("a table"));
    table.select(&[(0, As::Cell)]);
    let mut block = Block::default();
    assert!(table.next(&mut block).expect("rows"));
    let bits: Vec<u64> = block.columns[0].iter().map(|cell| cell.to_bits()).collect();
    assert_eq!(bits, [f64::NAN, 0.0, 2.5, UNREADABLE].map(f64::to_bits));
}

#[test]
fn encodings() {
    let text = "t;Winkel [\u{b0}]\n0;1,5\n1;2,5\n";
    let titles = ["t", "Winkel [\u{b0}]"];
    let columns: [&[f64]; 2] = [&[0.0, 1.0], &[1.5, 2.5]];
    let utf16 = |bytes: fn(u16) -> [u8; 2]| {
        let units = std::iter::once(0xFEFF).chain(text.encode_utf16());
        units.flat_map(bytes).collect::<Vec<u8>>()
    };
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(text.as_bytes()).expect("packed");
    let gzip = gzip.finish().expect("packed");
    for bytes in [text.as_bytes().to_vec(), utf16(u16::to_le_bytes), utf16(u16::to_be_bytes), latin, gzip] {
        check(bytes, &titles, &columns);
    }
}

/// Blocks end inside rows, and every number is that of the standard library.
#[test]
fn a_table_of_many_blocks() {
    let mut text = String::from("t,a,label,b\n");
    for k in 0..200_000_u32 {
        let a = f64::from(k.wrapping_mul(2_654_435_761) % 1_000_003) / 997.0 - 300.0;
        text.push_str(&format!("{},{a},p{},{a:e}\n", f64::from(k) / 100.0, k / 1000));
    }
    let mut table = Record::of_stream("log.csv", Cursor::new(text.clone().into_bytes())).expect("a table");
    table.select(&[(3, As::Number), (2, As::Label), (1, As::Number)]);
    let (mut block, mut rows) = (Block::default(), Vec::new());
    while table.next(&mut block).expect("rows") {
        for k in 0..block.rows() {
            rows.push([block.columns[0][k], block.columns[1][k], block.columns[2][k]]);
        }
    }
    assert_eq!((rows.len(), table.labels().len()), (200_000, 200));
    for (row, line) in rows.iter().zip(text.lines().skip(1)) {
        let cells: Vec<&str> = line.split(',').collect();
        let value: f64 = cells[1].parse().expect("a number");
        assert_eq!((row[0], row[2]), (value, value));
        assert_eq!(table.labels()[row[1] as usize], cells[2]);
    }
}

#[test]
fn faults_have_their_line() {
    for (text, words) in [
        ("t,V\n0,1\n1,x\n2,3\n", &["log.csv:3", "V", "'x'"][..]),
        ("t,V\n0,1\n1,2,3\n2,3\n", &["log.csv:3", "2 cells", "3 cells"]),
        ("t;V\n0;1,5\n1;2.5\n1;2,5\n", &["'1,5'", "decimal mark"]),
        ("", &["empty"]),
        ("t,t\n1,2\n", &["'t'", "twice"]),
        ("a\u{0}b", &["zero byte"]),
    ] {
        let error = read(text.into()).expect_err(text);
        assert!(words.iter().all(|word| error.contains(word)), "{text:?}: {error}");
    }
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    (0..100_000).for_each(|k| writeln!(gzip, "{k},{}", k * 7 % 1009).expect("packed"));
    let mut bytes = gzip.finish().expect("packed");
    bytes.truncate(bytes.len() / 2);
    assert!(read(bytes).expect_err("half a gzip").contains("cut off"));
}
