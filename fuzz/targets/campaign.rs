//! A campaign file, and the fit of a small one: what is taken must be fitted without a panic.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Ok(campaign) = tumble::Campaign::from_json(text)
        && campaign.readings.rows.len() < 50
        && campaign.unknowns() < 20
    {
        let _ = tumble::fit(&campaign, &Default::default());
    }
});
