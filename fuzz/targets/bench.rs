//! A bench file; what is taken is written and read again alike.
#![no_main]

use tumble::{Bench, wire};

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(bench) = Bench::from_json(text) {
        let file = wire::bench_file(&bench);
        let again = file.clone().into_bench().expect("what was written is read");
        assert_eq!(wire::bench_file(&again), file);
    }
});
