//! A catalogue of effects.
#![no_main]

use tumble::wire::{Source, read_effects};

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = read_effects(&Source { name: "effects".into(), text: text.into() });
});
