//! The JSON report of a fit, as `compare`, `apply` and `export` read it.
#![no_main]

use tumble::report::FitReport;
use tumble::wire::{Source, parse};

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = parse::<FitReport>(&Source { name: "report".into(), text: text.into() });
});
