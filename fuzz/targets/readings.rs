//! A CSV of readings on a built-in bench.
#![no_main]

use std::sync::LazyLock;
use tumble::Bench;
use tumble::wire::{Named, Source, Table, read_readings};

static BENCH: LazyLock<Bench> = LazyLock::new(|| Bench::named("gyro-turntable").expect("a bench"));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(source) = Source::from_bytes("readings.csv", bytes.to_vec()) {
        let _ = read_readings(&BENCH, Table::Text(source), &Named::default());
    }
});
