//! A truth file, for the published gyro campaign.
#![no_main]

use std::sync::LazyLock;
use tumble::Campaign;
use tumble::wire::{Source, read_truth};

static CAMPAIGN: LazyLock<Campaign> = LazyLock::new(|| {
    Campaign::from_json(include_str!("../../data/campaigns/li2012-table1.campaign.json")).expect("a campaign")
});

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = read_truth(&Source { name: "truth".into(), text: text.into() }, &CAMPAIGN);
});
