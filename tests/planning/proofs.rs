//! What a plan claims to be proven is below the truth: small random problems, every choice enumerated from definitions.

use crate::draws::draws;
use crate::plan_support::*;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use tumble::plan::{self, Costs, Criterion, Noise, Offer, Request, Unit};

/// A number in [0, 1).
fn uniform(generator: &mut Pcg64Mcg) -> f64 {
    (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn subsets(of: usize) -> impl Iterator<Item = Vec<usize>> {
    (1_u32..1 << of).map(move |bits| (0..of).filter(|k| bits >> k & 1 == 1).collect())
}

/// Symmetric 2 x 2: `(aa, ab, bb)`.
type Square = (f64, f64, f64);

fn det((aa, ab, bb): Square) -> f64 {
    aa * bb - ab * ab
}

/// The shortest way over all of these angles, deg, by trying every order.
fn shortest(angles: &[f64]) -> f64 {
    fn from(here: f64, left: &[f64]) -> f64 {
        let step = |k: usize| {
            let rest: Vec<f64> = left.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, a)| *a).collect();
            let apart = (left[k] - here).rem_euclid(360.0);
            apart.min(360.0 - apart) + from(left[k], &rest)
        };
        (0..left.len()).map(step).reduce(f64::min).unwrap_or(0.0)
    }
    let begin = |k: usize| {
        from(angles[k], &angles.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, a)| *a).collect::<Vec<f64>>())
    };
    (0..angles.len()).map(begin).reduce(f64::min).unwrap_or(0.0)
}

/// Where the way costs: no schedule within the budget is better than the share that is claimed allows.
#[test]
fn no_share_is_promised_above_the_truth_where_the_way_is_paid_for() {
    let (mut judged, mut short, mut generator) = (0, 0, Pcg64Mcg::seed_from_u64(29));
    for _ in 0..draws(60, 400) {
        let count = 5 + (generator.next_u64() % 2) as usize;
        let at: Vec<(f64, f64)> = (0..count)
            .map(|_| {
                ((uniform(&mut generator) * 360.0).round(), (uniform(&mut generator) * 200.0).round() / 100.0 - 1.0)
            })
            .collect();
        let rows: Vec<String> = at
            .iter()
            .enumerate()
            .map(|(k, (angle, x))| format!(r#"{{ "position": "{k}", "alpha_deg": {angle}, "x": {x} }}"#))
            .collect();
        let campaign = campaign(&format!(
            r#"{{ "bench": {{ "id": "way", "chain": [ {{ "joint": "alpha", "about": "z" }} ],
                 "sensors": {{ "y": {{ "model": "a + b*x" }} }} }},
                 "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": [ {} ] }}"#,
            rows.join(",")
        ));
        let costs = Costs { reading: 1.0, rate_change: 0.0, mounting: 2.0, index: 0.02 };
        let budget = 8.0 + 14.0 * uniform(&mut generator);
        let offer = Offer {
            kept: none(&campaign),
            candidates: campaign.readings.clone(),
            noise: Noise::new(&campaign, &[("y".into(), 1.0)], &[]).unwrap(),
            costs,
        };
        let request = Request { budget: Some(budget), most_repeats: 1, starts: 20, ..Request::default() };
        let Ok(found) = plan::improve(&campaign, &offer, &request) else { continue };
        let information = |chosen: &[usize]| {
            chosen.iter().map(|k| at[*k].1).fold((0.0, 0.0, 0.0), |(aa, ab, bb), x| (aa + 1.0, ab + x, bb + x * x))
        };
        let affordable = |chosen: &[usize]| {
            let angles: Vec<f64> = chosen.iter().map(|k| at[*k].0).collect();
            3.0 * chosen.len() as f64 + 0.02 * shortest(&angles) <= budget
        };
        let best = subsets(count).filter(|own| affordable(own)).map(|own| det(information(&own))).fold(0.0, f64::max);
        let chosen: Vec<usize> = found
            .schedule
            .readings
            .rows
            .iter()
            .map(|row| {
                (0..count)
                    .find(|k| {
                        row.columns == campaign.readings.rows[*k].columns
                            && row.joints == campaign.readings.rows[*k].joints
                    })
                    .unwrap()
            })
            .collect();
        let share = (det(information(&chosen)) / best).sqrt();
        judged += 1;
        short += usize::from(share < 1.0 - 1e-9);
        if let Some(claimed) = found.search.efficiency {
            assert!(claimed <= share * (1.0 + 1e-9), "claimed {claimed}, is {share}: {at:?} for {budget}");
        }
        assert!(found.search.enumerated.is_none() || share > 1.0 - 1e-9);
    }
    println!("{judged} problems, {short} choices below the best");
    assert!(judged >= 20);
}

/// With mountings that scatter, G and I are of readings: what is predicted at each position and not mixtures of them.
#[test]
fn no_share_is_promised_above_the_truth_where_mountings_scatter() {
    let (mut judged, mut generator) = (0, Pcg64Mcg::seed_from_u64(30));
    for draw in 0..draws(60, 400) {
        let count = 5 + draw % 2;
        let at: Vec<[f64; 2]> =
            (0..count).map(|_| [(); 2].map(|()| (uniform(&mut generator) * 400.0).round() / 100.0 - 2.0)).collect();
        let rows: Vec<String> = at
            .iter()
            .enumerate()
            .flat_map(|(k, both)| {
                both.iter().map(move |x| format!(r#"{{ "position": "{k}", "alpha_deg": {}, "x": {x} }}"#, 10 * k))
            })
            .collect();
        let campaign = campaign(&format!(
            r#"{{ "bench": {{ "id": "way", "chain": [ {{ "joint": "alpha", "about": "z" }} ],
                 "sensors": {{ "y": {{ "model": "a + b*x" }} }} }},
                 "estimate": {{ "a": {{}}, "b": {{}} }}, "readings": [ {} ] }}"#,
            rows.join(",")
        ));
        let scatter = 0.2 + 2.0 * uniform(&mut generator);
        let noise = Noise::new(&campaign, &[("y".into(), 1.0)], &[("a".into(), scatter)]).unwrap();
        let offer =
            Offer { kept: none(&campaign), candidates: campaign.readings.clone(), noise, costs: Costs::default() };
        let choose = 2 + (generator.next_u64() % 2) as usize;
        // V = 1 + s^2 1 1' for the two readings of a mounting, so V^-1 = 1 - w 1 1'
        let w = scatter * scatter / (1.0 + 2.0 * scatter * scatter);
        let information = |chosen: &[usize]| -> Square {
            chosen.iter().fold((0.0, 0.0, 0.0), |(aa, ab, bb), k| {
                let [x, y] = at[*k];
                let sum = x + y;
                (aa + 2.0 - 4.0 * w, ab + sum - 2.0 * w * sum, bb + x * x + y * y - w * sum * sum)
            })
        };
        let variances = |chosen: &[usize]| -> Vec<f64> {
            let m = information(chosen);
            at.iter().flatten().map(|x| (m.2 - 2.0 * m.1 * x + m.0 * x * x) / det(m)).collect()
        };
        for criterion in [Criterion::G, Criterion::I] {
            let value = |chosen: &[usize]| {
                let all = variances(chosen);
                match criterion {
                    Criterion::G => all.iter().copied().fold(0.0, f64::max),
                    _ => all.iter().sum::<f64>() / all.len() as f64,
                }
            };
            let request = Request {
                readings: 2 * choose,
                criterion: criterion.clone(),
                unit: Unit::Mounting,
                most_repeats: 1,
                starts: 20,
                ..Request::default()
            };
            let Ok(found) = plan::improve(&campaign, &offer, &request) else { continue };
            let every = subsets(count).filter(|own| own.len() == choose && det(information(own)) > 1e-9);
            let best = every.map(|own| value(&own)).fold(f64::INFINITY, f64::min);
            let of = |row: &tumble::campaign::Reading| {
                let same = |k: &usize| campaign.readings.rows[*k].columns == row.columns;
                (0..2 * count).find(same).unwrap() / 2
            };
            let mut chosen: Vec<usize> = found.schedule.readings.rows.iter().map(of).collect();
            chosen.sort_unstable();
            chosen.dedup();
            if chosen.len() != choose {
                continue; // two mountings with the same reading are not told apart here
            }
            let share = best / value(&chosen);
            judged += 1;
            let claimed = found.search.efficiency.unwrap_or(0.0);
            assert!(claimed <= share * (1.0 + 1e-7), "{criterion:?}: claimed {claimed}, is {share}: {at:?}, {scatter}");
        }
    }
    println!("{judged} problems");
    assert!(judged >= 60);
}
