//! A file of a laboratory's identities.
#![no_main]

use tumble::wire::{Source, read_lab};

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = read_lab(&Source { name: "lab".into(), text: text.into() });
});
