//! Mistakes at the bench that change a value by 20 standard deviations or more: flagged at the reading, and named, there or after three more
//! readings. 6 calibrations of each kind by default, 100 with `TUMBLE_LONG=1`; `TUMBLE_SEED=7` draws others, `TUMBLE_KIND=slipped` those of one kind.
//!
//! Named right: what was done is among the explanations that have a probability of 0.95 together, at its reading; of a slip, that its kind is named,
//! which has 0.95 alone. The table also says how many these explanations are, and how often the first of them is right.

use crate::bench::{drawn, measure, normal, pick, uniform};
use crate::draws::draws;
use rand_pcg::Pcg64Mcg;
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
    sensors: usize,
    flagged: bool,
    /// At once, and after some more readings.
    named: [bool; 2],
    first: bool,
    explanations: usize,
    /// Flags before the mistake, and readings that were judged.
    early: (usize, usize),
    report: String,
}

/// The setting that is made instead of the one asked for, far enough from it that the sensors see it.
fn instead(kind: &str, random: &mut Pcg64Mcg, asked: &Reading) -> Option<Vec<JointState>> {
    let mut joints = asked.joints.clone();
    match kind {
        "wrong face" => {
            let held: Vec<usize> =
                (0..joints.len()).filter(|k| matches!(joints[*k], JointState::Held { .. })).collect();
            let k = *pick(random, &held);
            let JointState::Held { angle_deg } = joints[k] else { return None };
            joints[k] = JointState::Held { angle_deg: (angle_deg + 180.0).rem_euclid(360.0) };
        }
        "exchanged axes" => {
            let a = uniform(random, 0.0, joints.len() as f64 - 1.0) as usize;
            joints.swap(a, a + 1);
        }
        "wrong sense" => joints[0] = joints[0].reversed(),
        _ => {}
    }
    (joints != asked.joints).then_some(joints)
}

fn trial(kind: &'static str, seed: u64) -> Option<Trial> {
    let catalogue = wire::built_in_effects().unwrap();
    let own = drawn(seed);
    let sensors = own.schedule.bench.sensors.len();
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
        let (named, report) = ([false; 2], String::new());
        return Some(Trial { seed, sensors, flagged: false, named, first: false, explanations: 0, early, report });
    }
    let mut world = own.truth.clone();
    let quiet = |truth: &Truth, asked: &Reading| {
        measure(&own.schedule, &Truth { noise: Vec::new(), ..truth.clone() }, &[], asked, 1).observations
    };
    // a mistake that no sensor sees is none
    let least = 20.0 * own.sd;
    let apart = |(one, asked): (&Truth, &Reading), (other, made): (&Truth, &Reading)| {
        quiet(one, asked).iter().zip(&quiet(other, made)).any(|(a, b)| (a.value - b.value).abs() > least)
    };
    let candidates = guide.candidates().to_vec();
    let mut random = own.random.clone();
    let mut found = None;
    for k in 0..40 {
        if kind == "slipped mounting" {
            let tilts: Vec<usize> = (0..own.schedule.unknowns())
                .filter(|k| own.schedule.estimated()[*k].kind == tumble::campaign::Kind::Tilt)
                .collect();
            if tilts.is_empty() {
                return None;
            }
            let mut slipped = own.truth.clone();
            slipped.point[*pick(&mut random, &tilts)] +=
                10.0_f64.powf(uniform(&mut random, -3.0, -1.0)) * normal(&mut random).signum();
            let asked =
                if k == 0 { follow(&guide, &advice.next, BEFORE) } else { pick(&mut random, &candidates).clone() };
            if apart((&own.truth, &asked), (&slipped, &asked)) {
                world = slipped;
                found = Some((asked, None));
                break;
            }
            continue;
        }
        let asked = pick(&mut random, &candidates).clone();
        let Some(joints) = instead(kind, &mut random, &asked) else { continue };
        let made = Reading { joints: joints.clone(), ..asked.clone() };
        if turning(&joints) <= 1 && apart((&own.truth, &asked), (&own.truth, &made)) {
            found = Some((asked, Some(joints)));
            break;
        }
    }
    let (asked, made) = found?;
    let seen = |guide: &Guide, world: &Truth, asked: &Reading, made: &Option<Vec<JointState>>| {
        let set = Reading { joints: made.clone().unwrap_or(asked.joints.clone()), ..asked.clone() };
        let read = measure(&own.schedule, world, guide.taken(), &set, seed);
        Reading { joints: asked.joints.clone(), ..read }
    };
    guide.accept(seen(&guide, &world, &asked, &made)).unwrap();
    advice = guide.advise(true).unwrap();
    let flagged = advice.newest.as_ref().unwrap().agreement == Agreement::Disagrees;
    let is = |one: &tumble::guide::Explanation| {
        let same = |own: &Vec<JointState>, made: &Vec<JointState>| own.iter().zip(made).all(|(a, b)| same_state(a, b));
        one.reading == BEFORE + 1 && one.joints.as_ref().zip(made.as_ref()).is_some_and(|(own, made)| same(own, made))
    };
    let right = |advice: &tumble::guide::Advice| {
        advice.mistake.as_ref().is_some_and(|mistake| match &made {
            None => mistake.named == Some(MistakeKind::SlippedMounting),
            Some(_) => mistake.explanations.iter().any(is),
        })
    };
    let named = right(&advice);
    let explanations = advice.mistake.as_ref().map_or(0, |own| own.explanations.len());
    let first = advice.mistake.as_ref().and_then(|own| own.explanations.first()).is_some_and(|one| match made {
        None => one.kind == MistakeKind::SlippedMounting && one.reading == BEFORE + 1,
        Some(_) => is(one),
    });
    let said = |advice: &tumble::guide::Advice| {
        let verdict = advice.diagnosis.as_ref().map(|own| own.verdict);
        let mistake = advice.mistake.as_ref().map(|own| {
            let one = |own: &tumble::guide::Explanation| {
                (own.kind, own.reading, own.what.clone(), (own.probability * 1e3).round())
            };
            (own.named, own.at, own.explanations.iter().take(3).map(one).collect::<Vec<_>>())
        });
        format!("{mistake:?} {verdict:?}")
    };
    let at_once = said(&advice);
    for k in 0..AFTER {
        let asked = follow(&guide, &advice.next, BEFORE + 1 + k);
        guide.accept(seen(&guide, &world, &asked, &None)).unwrap();
        advice = guide.advise(true).unwrap();
    }
    let report = format!("made {made:?}, said {at_once}, later {}", said(&advice));
    Some(Trial { seed, sensors, flagged, named: [named, right(&advice)], first, explanations, early, report })
}

fn same_state(a: &JointState, b: &JointState) -> bool {
    match (a, b) {
        (JointState::Held { angle_deg: a }, JointState::Held { angle_deg: b }) => (a - b).rem_euclid(360.0) == 0.0,
        _ => a == b,
    }
}

fn turning(joints: &[JointState]) -> usize {
    joints.iter().filter(|state| state.rate_deg_s() != 0.0).count()
}

#[test]
fn mistakes_at_the_bench() {
    let first: u64 = std::env::var("TUMBLE_SEED").map_or(5000, |text| text.parse().unwrap());
    let count = draws(6, 100);
    println!(
        "mistake           calibrations  flagged at once  named at once  named after {AFTER} more  first is right  explanations  flags before / readings judged"
    );
    let only = std::env::var("TUMBLE_KIND").unwrap_or_default();
    for (row, kind) in KINDS.into_iter().enumerate().filter(|(_, kind)| kind.contains(&only)) {
        // benches on which the mistake can be made at all
        let trials: Vec<Trial> =
            (0..3 * count as u64).into_par_iter().filter_map(|k| trial(kind, first + 1000 * row as u64 + k)).collect();
        let trials = &trials[..trials.len().min(count)];
        let n = trials.len() as f64;
        let of = |what: &dyn Fn(&Trial) -> bool| trials.iter().filter(|own| what(own)).count();
        let early = trials.iter().fold((0, 0), |sum, own| (sum.0 + own.early.0, sum.1 + own.early.1));
        let (flagged, named, later) = (of(&|t| t.flagged), of(&|t| t.named[0]), of(&|t| t.named[1]));
        let mut listed: Vec<usize> = trials.iter().map(|own| own.explanations).collect();
        listed.sort_unstable();
        println!(
            "{kind:<16}  {:>12}  {flagged:>15}  {named:>13}  {later:>18}  {:>14}  {:>12}  {} / {}",
            trials.len(),
            of(&|t| t.first),
            listed.get(listed.len() / 2).copied().unwrap_or_default(),
            early.0,
            early.1
        );
        if kind == "slipped mounting" {
            // one value cannot tell a slip from a bad value: both change it by any amount
            let by = |count: usize| {
                let own: Vec<&Trial> = trials.iter().filter(|own| own.sensors == count).collect();
                format!("{} of {} with {count}", own.iter().filter(|own| own.named[0]).count(), own.len())
            };
            println!("  named at once, by sensors: {}, {}, {}", by(1), by(2), by(3));
        }
        for own in trials.iter().filter(|own| kind != "clean" && (!own.flagged || !(own.named[0] || own.named[1]))) {
            println!("  seed {}: flagged {}, named {:?}: {}", own.seed, own.flagged, own.named, own.report);
        }
        assert!(
            early.0 as f64 <= 0.01 * early.1 as f64 + 1.0,
            "{kind}: {} of {} clean readings flagged",
            early.0,
            early.1
        );
        if kind != "clean" {
            assert!(!trials.is_empty());
            // one more may be missed by chance
            assert!(flagged as f64 + 1.0 >= 0.98 * n, "{kind}: {flagged} flagged");
            let told = if kind == "slipped mounting" { later } else { named };
            assert!(told as f64 + 1.0 >= 0.9 * n, "{kind}: {told} named");
        }
    }
}
