//! A file in any format, told by its first bytes: Parquet, workbooks, MATLAB, HDF5, MCAP, bags, ULog, tables of text.
#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;
use tumble::record::{As, Block, Record};

/// In memory, one for each process.
static PATH: LazyLock<PathBuf> = LazyLock::new(|| {
    let shared = PathBuf::from("/dev/shm");
    let folder = if shared.is_dir() { shared } else { std::env::temp_dir() };
    folder.join(format!("tumble-fuzz-{}", std::process::id()))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    std::fs::write(&*PATH, bytes).expect("a file");
    for kind in [As::Number, As::Mixed, As::Label] {
        let Ok(mut record) = Record::at(&PATH) else { return };
        let columns: Vec<(usize, As)> = (0..record.columns().len()).map(|k| (k, kind)).collect();
        record.select(&columns);
        let mut block = Block::default();
        while let Ok(true) = record.next(&mut block) {}
    }
});
