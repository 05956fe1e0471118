//! A mission file.
#![no_main]

use tumble::wire::{MissionFile, Source, parse};

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(file) = parse::<MissionFile>(&Source { name: "mission".into(), text: text.into() }) {
        let _ = file.mission();
    }
});
