//! A CSV of readings on a built-in bench.
#![no_main]

use std::sync::LazyLock;
use tumble::Bench;
use tumble::record::Record;
use tumble::wire::{Named, read_readings};

static BENCH: LazyLock<Bench> = LazyLock::new(|| Bench::named("gyro-turntable").expect("a bench"));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(record) = Record::of_text("readings.csv", bytes) {
        let _ = read_readings(&BENCH, record, &Named::default(), &[]);
    }
});
