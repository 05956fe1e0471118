//! Mistakes at the bench: flagged at the reading, and named, there or after three more readings. 6 calibrations of each kind by default, 100 with
//! `TUMBLE_LONG=1`; `TUMBLE_SEED=7` draws others.

use crate::bench::{Drawn, drawn, measure, normal, pick, uniform};
use crate::draws::draws;
use rayon::prelude::*;
use tumble::campaign::{JointState, Reading};
use tumble::guide::{Agreement, Guide, MistakeKind, Settings};
use tumble::simulate::Truth;
use tumble::wire;

const KINDS: [&str; 5] = ["wrong face", "exchanged axes", "wrong sense", "slipped mounting", "clean"];
/// Readings before the mistake.
const BEFORE: usize = 12;
const AFTER: usize = 3;

struct Trial {
    seed: u64,
    flagged: bool,
    named: bool,
    named_later: bool,
    /// Flags before the mistake, and readings that were judged.
    early: (usize, usize),
    report: String,
}

/// The setting that is made instead of the one asked for, far enough from it that the sensors see it.
fn instead(kind: &str, own: &mut Drawn, asked: &Reading) -> Option<Vec<JointState>> {
    let mut joints = asked.joints.clone();
    match kind {
        "wrong face" => {
            let held: Vec<usize> =
                (0..joints.len()).filter(|k| matches!(joints[*k], JointState::Held { .. })).collect();
            let k = *pick(&mut own.random, &held);
            let JointState::Held { angle_deg } = joints[k] else { return None };
            joints[k] = JointState::Held { angle_deg: (angle_deg + 180.0).rem_euclid(360.0) };
        }
        "exchanged axes" => joints.swap(0, 1),
        "wrong sense" => joints[0] = joints[0].reversed(),
        _ => {}
    }
    (joints != asked.joints).then_some(joints)
}

fn trial(kind: &'static str, seed: u64) -> Option<Trial> {
    let catalogue = wire::built_in_effects().unwrap();
    let mut own = drawn(seed);
    let settings = Settings { goals: own.goals.clone(), ..Settings::default() };
    let mut guide = Guide::new(&own.schedule, &own.schedule.readings, &catalogue, settings).unwrap();
    let mut early = (0, 0);
    let mut advice = guide.advise(false).unwrap();
    let follow = |guide: &Guide, next: &Option<tumble::guide::Next>, k: usize| -> Reading {
        let label = next.as_ref().map(|next| next.position.clone());
        let found = guide.candidates().iter().find(|c| Some(&c.position) == label.as_ref());
        // where it has enough, positions of the schedule go on in their order
        found.unwrap_or(&guide.candidates()[(7 * k) % guide.candidates().len()]).clone()
    };
    for k in 0..BEFORE {
        let asked = follow(&guide, &advice.next, k);
        guide.accept(measure(&own.schedule, &own.truth, guide.taken(), &asked, seed)).unwrap();
        advice = guide.advise(true).unwrap();
        let newest = advice.newest.as_ref().unwrap();
        early.1 += usize::from(newest.agreement != Agreement::NotPredicted);
        early.0 += usize::from(newest.agreement == Agreement::Disagrees);
    }
    if kind == "clean" {
        return Some(Trial { seed, flagged: false, named: false, named_later: false, early, report: String::new() });
    }
    let mut world = own.truth.clone();
    let (asked, made) = match kind {
        "slipped mounting" => {
            let tilts: Vec<usize> = own
                .schedule
                .bench
                .tilts()
                .filter_map(|t| own.schedule.parameter_index(t))
                .filter(|k| *k < own.schedule.unknowns())
                .collect();
            if tilts.is_empty() {
                return None;
            }
            let k = *pick(&mut own.random, &tilts);
            let size = uniform(&mut own.random, 2e-3, 2e-2) * normal(&mut own.random).signum();
            world.point[k] += size;
            (follow(&guide, &advice.next, BEFORE), None)
        }
        _ => {
            // a mistake that no sensor sees is none
            let candidates = guide.candidates().to_vec();
            let mut found = None;
            for _ in 0..40 {
                let asked = pick(&mut own.random, &candidates).clone();
                let Some(joints) = instead(kind, &mut own, &asked) else { continue };
                let joined = Reading { joints: joints.clone(), ..asked.clone() };
                if own.schedule.bench.joints().count() != joints.len() || turning(&joints) > 1 {
                    continue;
                }
                let quiet = Truth { noise: Vec::new(), ..own.truth.clone() };
                let (a, b) =
                    (measure(&own.schedule, &quiet, &[], &asked, 1), measure(&own.schedule, &quiet, &[], &joined, 1));
                let apart = a.observations.iter().zip(&b.observations).any(|(a, b)| (a.value - b.value).abs() > 2e-3);
                if apart {
                    found = Some((asked, joints));
                    break;
                }
            }
            let (asked, joints) = found?;
            (asked, Some(joints))
        }
    };
    let seen = |guide: &Guide, world: &Truth, asked: &Reading, made: &Option<Vec<JointState>>| {
        let set = Reading { joints: made.clone().unwrap_or(asked.joints.clone()), ..asked.clone() };
        let read = measure(&own.schedule, world, guide.taken(), &set, seed);
        Reading { joints: asked.joints.clone(), ..read }
    };
    guide.accept(seen(&guide, &world, &asked, &made)).unwrap();
    advice = guide.advise(true).unwrap();
    let flagged = advice.newest.as_ref().unwrap().agreement == Agreement::Disagrees;
    let right = |advice: &tumble::guide::Advice| {
        let Some(mistake) = &advice.mistake else { return false };
        let setting = mistake.explanations.first().and_then(|own| own.joints.clone());
        mistake.at == Some(BEFORE + 1)
            && match (kind, &made) {
                ("slipped mounting", _) => mistake.named == Some(MistakeKind::SlippedMounting),
                (_, Some(made)) => {
                    setting.as_ref() == Some(made)
                        || mistake
                            .explanations
                            .iter()
                            .any(|own| own.joints.as_ref() == Some(made) && own.probability > 0.05)
                }
                _ => false,
            }
    };
    let named = right(&advice);
    let report = format!(
        "{:?}",
        advice.mistake.as_ref().map(|m| (
            m.named,
            m.at,
            m.explanations
                .iter()
                .take(3)
                .map(|e| (e.kind, e.what.clone(), (e.probability * 1e3).round()))
                .collect::<Vec<_>>()
        ))
    );
    for k in 0..AFTER {
        let asked = follow(&guide, &advice.next, BEFORE + 1 + k);
        guide.accept(seen(&guide, &world, &asked, &None)).unwrap();
        advice = guide.advise(true).unwrap();
    }
    Some(Trial { seed, flagged, named, named_later: right(&advice), early, report })
}

fn turning(joints: &[JointState]) -> usize {
    joints.iter().filter(|state| state.rate_deg_s() != 0.0).count()
}

#[test]
fn mistakes_at_the_bench() {
    let first: u64 = std::env::var("TUMBLE_SEED").map_or(5000, |text| text.parse().unwrap());
    let count = draws(6, 100);
    println!(
        "mistake           calibrations  flagged at once  named at once  named after {AFTER} more  flags before / readings judged"
    );
    for (row, kind) in KINDS.into_iter().enumerate() {
        // benches on which the mistake can be made at all
        let trials: Vec<Trial> = (0..8 * count as u64)
            .into_par_iter()
            .filter_map(|k| (k < 3 * count as u64).then(|| trial(kind, first + 1000 * row as u64 + k)).flatten())
            .collect();
        let trials = &trials[..trials.len().min(count)];
        let of = |what: &dyn Fn(&Trial) -> bool| trials.iter().filter(|own| what(own)).count();
        let early = trials.iter().fold((0, 0), |sum, own| (sum.0 + own.early.0, sum.1 + own.early.1));
        let (flagged, named, later) = (of(&|t| t.flagged), of(&|t| t.named), of(&|t| t.named_later));
        println!(
            "{kind:<16}  {:>12}  {flagged:>15}  {named:>13}  {later:>18}  {} / {}",
            trials.len(),
            early.0,
            early.1
        );
        for own in trials.iter().filter(|own| kind != "clean" && (!own.flagged || !own.named)) {
            println!("  seed {}: flagged {}, later {}: {}", own.seed, own.flagged, own.named_later, own.report);
        }
        assert!(
            early.0 as f64 <= 0.01 * early.1 as f64 + 1.0,
            "{kind}: {} of {} clean readings flagged",
            early.0,
            early.1
        );
        if kind != "clean" {
            assert!(!trials.is_empty());
            assert!(flagged as f64 >= 0.9 * trials.len() as f64, "{kind}: {flagged} flagged");
            let told = if kind == "slipped mounting" { later } else { named };
            assert!(told as f64 >= 0.8 * trials.len() as f64, "{kind}: {told} named");
        }
    }
}
