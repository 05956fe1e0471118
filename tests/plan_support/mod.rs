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

/// Candidates of which only the rows are known, `rows[candidate][row]`: a place each, read once for every row, noise of one. Its unknowns are p0, p1, ..,
/// and `c` is the line of these that is asked for.
pub fn plain(rows: &[Vec<Vec<f64>>], c: &str) -> (Campaign, Offer) {
    let n = rows[0][0].len();
    let list = |of: &dyn Fn(usize) -> String, by: &str| (0..n).map(of).collect::<Vec<_>>().join(by);
    let reading = |place: usize, row: &Vec<f64>| {
        format!(r#"{{ "place_deg": {place}, {} }}"#, list(&|k| format!(r#""x{k}": {:?}"#, row[k]), ", "))
    };
    let readings: Vec<String> =
        rows.iter().enumerate().flat_map(|(j, own)| own.iter().map(move |row| reading(j, row))).collect();
    let campaign = campaign(&format!(
        r#"{{ "bench": {{ "id": "plain", "chain": [ {{ "joint": "place", "about": "z" }} ],
               "sensors": {{ "y": {{ "model": "{}" }} }} }},
             "estimate": {{ {} }}, "derived": {{ "c": "{c}" }}, "readings": [ {} ] }}"#,
        list(&|k| format!("p{k}*x{k}"), " + "),
        list(&|k| format!(r#""p{k}": {{}}"#), ", "),
        readings.join(", ")
    ));
    let noise = Noise::new(&campaign, &[("y".into(), 1.0)], &[]).unwrap();
    let candidates = campaign.readings.clone();
    let offer = Offer { kept: none(&campaign), candidates, noise, costs: Costs::default() };
    (campaign, offer)
}

/// The candidate of each reading of a schedule of such rows, sorted.
pub fn places(schedule: &Campaign) -> Vec<usize> {
    let mut places: Vec<usize> =
        schedule.readings.rows.iter().map(|row| row.joints[0].keys().0.unwrap() as usize).collect();
    places.sort_unstable();
    places
}

/// `X'X` of chosen candidates.
pub fn information(rows: &[Vec<Vec<f64>>], chosen: &[usize]) -> Vec<Vec<f64>> {
    let n = rows[0][0].len();
    let chosen = || chosen.iter().flat_map(|j| &rows[*j]);
    (0..n).map(|a| (0..n).map(|b| chosen().map(|x| x[a] * x[b]).sum()).collect()).collect()
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
