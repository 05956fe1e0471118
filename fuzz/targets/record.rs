//! A record: a table of text in any dialect, also compressed.
#![no_main]

use std::io::Cursor;
use tumble::record::{As, Block, Record};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(mut table) = Record::of_stream("record", Cursor::new(bytes.to_vec())) else { return };
    let columns: Vec<(usize, As)> = (0..table.columns().len()).map(|k| (k, As::Number)).collect();
    table.select(&columns);
    let mut block = Block::default();
    while let Ok(true) = table.next(&mut block) {}
});
