//! What the tests of plans share: campaigns, offers, a determinant that is independent of the crate.

#![allow(dead_code)] // not every test uses everything

use tumble::campaign::{Campaign, Readings};
use tumble::plan::{self, Costs, Noise, Offer};
use tumble::wire::{self, Source};

pub fn campaign(text: &str) -> Campaign {
    let source = Source { name: "test".into(), text: text.into() };
    wire::read_campaign(&source, &mut |_| panic!("nothing to fetch")).unwrap()
}

pub fn published() -> Campaign {
    campaign(include_str!("../../data/campaigns/li2012-table1.campaign.json"))
}

pub fn line(readings: &str) -> Campaign {
    campaign(&format!(
        r#"{{ "bench": {{ "id": "line", "sensors": {{ "y": {{ "model": "a + b*x + c*z" }} }} }},
             "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": [ {{ "x": {readings}, "z": 1 }} ] }}"#
    ))
}

pub fn none(like: &Campaign) -> Readings {
    Readings { columns: like.readings.columns.clone(), rows: Vec::new() }
}

/// Everything chosen anew from a sweep.
pub fn offer(campaign: &Campaign, noise: Noise, step_deg: f64) -> Offer {
    Offer { kept: none(campaign), candidates: plan::sweep(campaign, step_deg).unwrap(), noise, costs: Costs::default() }
}

pub fn assert_close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "found {found}, expected {expected}");
}

/// Determinant by elimination, independent of the crate.
pub fn determinant(mut m: Vec<Vec<f64>>) -> f64 {
    let n = m.len();
    let mut product = 1.0;
    for k in 0..n {
        let p = (k..n).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs())).unwrap();
        if m[p][k] == 0.0 {
            return 0.0;
        }
        if p != k {
            m.swap(p, k);
            product = -product;
        }
        product *= m[k][k];
        for i in k + 1..n {
            let f = m[i][k] / m[k][k];
            let (above, below) = m.split_at_mut(i);
            below[0].iter_mut().zip(&above[k]).skip(k).for_each(|(x, p)| *x -= f * p);
        }
    }
    product
}
