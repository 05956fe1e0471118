//! Texts of Parquet files, in whatever pages they stand.

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType};
use parquet::file::properties::{WriterProperties, WriterPropertiesBuilder, WriterVersion};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fs::File;
use std::io::{Read, Seek, Write};
use std::sync::Arc;
use tumble::record::{As, Block, Record};

/// A file of one column of texts, by the library of Parquet.
fn written(texts: &[Option<String>], is_optional: bool, properties: WriterPropertiesBuilder) -> File {
    let repetition = if is_optional { Repetition::OPTIONAL } else { Repetition::REQUIRED };
    let field =
        Type::primitive_type_builder("serial", Physical::BYTE_ARRAY).with_repetition(repetition).build().unwrap();
    let schema = Type::group_type_builder("table").with_fields(vec![Arc::new(field)]).build().unwrap();
    let file = tempfile::tempfile().unwrap();
    let to = file.try_clone().unwrap();
    let mut writer = SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties.build())).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    let values: Vec<ByteArray> = texts.iter().flatten().map(|text| ByteArray::from(text.as_str())).collect();
    let levels: Vec<i16> = texts.iter().map(|text| i16::from(text.is_some())).collect();
    column.typed::<ByteArrayType>().write_batch(&values, is_optional.then_some(levels.as_slice()), None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    file
}

/// The texts as the program reads them.
fn read(mut file: File) -> Result<Vec<Option<String>>, tumble::Malformed> {
    file.rewind().unwrap();
    let mut record = Record::open("texts", file)?;
    record.select(&[(0, As::Label)]);
    let (mut block, mut found) = (Block::default(), Vec::new());
    while record.next(&mut block)? {
        for number in &block.columns[0] {
            found.push((!number.is_nan()).then(|| record.labels()[*number as usize].clone()));
        }
    }
    Ok(found)
}

/// Texts in runs, in turn, or all the same, some absent, as files of either version with and without dictionaries, and with one that ends midway: what was written.
#[test]
fn texts_come_back_whatever_their_pages() {
    let plain = WriterProperties::builder;
    let all = [
        plain(),
        plain().set_writer_version(WriterVersion::PARQUET_2_0),
        plain().set_dictionary_enabled(false),
        plain().set_dictionary_page_size_limit(200).set_data_page_size_limit(500).set_write_batch_size(64),
    ];
    let kinds: [fn(u32) -> u32; 4] = [|row| row / 30, |row| row % 8, |row| row * row % 37, |_| 0];
    for (k, properties) in all.into_iter().enumerate() {
        for is_optional in [false, true] {
            for kind in kinds {
                let text = |row: u32| (!is_optional || !row.is_multiple_of(7)).then(|| format!("S{}", kind(row)));
                let texts: Vec<Option<String>> = (0..3000).map(text).collect();
                assert_eq!(read(written(&texts, is_optional, properties.clone())).unwrap(), texts, "way {k}");
            }
        }
    }
}

/// The example of the specification (Encodings.md): 0 to 7 in three bits are the bytes 10001000 11000110 11111010, one group of eight. Pages that end before
/// their last number are errors.
#[test]
fn runs_and_groups() {
    let texts: Vec<Option<String>> = (0..8).map(|k| Some(format!("S{k}"))).collect();
    let bytes = |mut file: File| {
        let mut all = Vec::new();
        file.rewind().unwrap();
        file.read_to_end(&mut all).unwrap();
        all
    };
    let whole = bytes(written(&texts, false, WriterProperties::builder()));
    // the width of an index, the head of one group, the group
    let page = [3, 0b11, 0b1000_1000, 0b1100_0110, 0b1111_1010];
    let places: Vec<usize> = (0..whole.len() - 4).filter(|k| whole[*k..*k + 5] == page).collect();
    let [at] = places[..] else { panic!("{places:?}") };
    let changed = |to: [u8; 5]| {
        let mut own = whole.clone();
        own[at..at + 5].copy_from_slice(&to);
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&own).unwrap();
        file.rewind().unwrap();
        read(file)
    };
    assert_eq!(changed(page).unwrap(), texts);
    let labels = |of: [usize; 8]| of.map(|k| texts[k].clone()).to_vec();
    // a run of five fives, and one of three twos
    assert_eq!(changed([3, 10, 5, 6, 2]).unwrap(), labels([5, 5, 5, 5, 5, 2, 2, 2]));
    // runs of five and two numbers, of no number, a group of two bytes, an entry that the dictionary does not have
    for damaged in [[3, 10, 5, 4, 2], [3, 0, 5, 16, 2], [3, 10, 5, 3, 2], [5, 10, 9, 6, 9]] {
        assert!(changed(damaged).is_err(), "{damaged:?}");
    }
}
