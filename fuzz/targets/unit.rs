//! A unit.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = tumble::units::Unit::parse_any(text);
});
