//! Mistakes at the bench that change a value by 20 standard deviations or more: flagged at the reading, and named, there or after one and three more
//! readings. 6 calibrations of each kind by default, 100 with `TUMBLE_LONG=1`; `TUMBLE_SEED=7` draws others, `TUMBLE_KIND=slipped` those of one kind.
//!
//! Listed: what was done is among the explanations that have a probability of 0.95 together, at its reading. Named alone: its kind has 0.95 by itself.
//! Which slips can be named alone at their reading is worked out apart (`told_apart`), by one who knows every unknown of the calibration. The table
//! also says how many the explanations are, and how often the first of them is right.

use crate::bench::{Drawn, drawn, measure, normal, pick, uniform};
use crate::draws::draws;
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use rayon::prelude::*;
use tumble::campaign::{JointState, Reading};
use tumble::guide::{Guide, Settings};
use tumble::simulate::{DrawnNoise, Truth};
use tumble::wire;

const KINDS: [&str; 6] = ["wrong face", "exchanged axes", "wrong sense", "slipped mounting", "clean", "wrong value"];
/// Readings before the mistake.
const BEFORE: usize = 12;
const AFTER: usize = 3;

struct Trial {
    seed: u64,
    sensors: usize,
    flagged: bool,
    /// At once, after one more reading, and after all.
    said: [Said; 3],
    /// Probability of a slip at its reading, for one who knows every unknown.
    told_apart: Option<f64>,
    first: bool,
    explanations: usize,
    /// Flags before the mistake, and readings that were judged.
    early: (usize, usize),
    report: String,
}

/// What was said of what was done.
#[derive(Clone, Copy, Default)]
struct Said {
    listed: bool,
    alone: bool,
    /// A kind that it is not has 0.95 by itself.
    wrongly: bool,
}

/// Probability that a tilt slipped, given one reading, where all unknowns are known: no calibration can tell more of it. As `guide` has it, kinds have
/// the same odds, which their members share, and sizes the same odds in every decade; integrals are Laplace's, about sizes that are solved for with
/// exact rotations. What an earlier reading or a missing effect could explain is left out, which makes a slip more probable than it is.
fn told_apart(own: &Drawn, candidates: &[Reading], asked: &Reading, read: &Reading) -> f64 {
    let quiet = Truth { noise: Vec::new(), ..own.truth.clone() };
    let at = |point: &[f64], joints: &[JointState]| -> Vec<f64> {
        let set = Reading { joints: joints.to_vec().into(), ..asked.clone() };
        let truth = Truth { point: point.to_vec(), ..quiet.clone() };
        measure(&own.schedule, &truth, &[], &set, 1).observations.iter().map(|own| own.value).collect()
    };
    let seen: Vec<f64> = read.observations.iter().map(|own| own.value).collect();
    let off = |made: &[f64]| -> Vec<f64> { seen.iter().zip(made).map(|(y, f)| (y - f) / own.sd).collect() };
    let square = |own: &[f64]| own.iter().map(|x| x * x).sum::<f64>();
    let as_asked = off(&at(&own.truth.point, &asked.joints));
    let (decades, width) = (5.0, (2.0 * std::f64::consts::PI).sqrt());
    // ln of the odds of a size in either sense, with what is integrated about it
    let sized = |size: f64, sd: f64| (width * sd / (2.0 * size.abs() * decades * 10.0_f64.ln())).ln();
    let mut slips = Vec::new();
    for (k, tilt) in own.schedule.estimated().iter().enumerate() {
        if tilt.kind != tumble::campaign::Kind::Tilt {
            continue;
        }
        let moved = |slip: f64| {
            let mut point = own.truth.point.clone();
            point[k] += slip;
            off(&at(&point, &asked.joints))
        };
        let (mut slip, mut sd) = (0.0, f64::INFINITY);
        for _ in 0..30 {
            let step = 1e-6;
            let (here, up, down) = (moved(slip), moved(slip + step), moved(slip - step));
            let slope: Vec<f64> = up.iter().zip(&down).map(|(a, b)| (b - a) / (2.0 * step)).collect();
            let gain = square(&slope);
            sd = gain.sqrt().recip();
            if !sd.is_finite() {
                break;
            }
            slip += (here.iter().zip(&slope).map(|(r, a)| r * a).sum::<f64>() / gain).clamp(-0.1, 0.1);
        }
        if sd.is_finite() && (10.0_f64.powf(-5.5)..10.0_f64.powf(-0.5)).contains(&slip.abs()) {
            slips.push(sized(slip, sd) - 0.5 * square(&moved(slip)));
        } else {
            slips.push(f64::NEG_INFINITY);
        }
    }
    let bad: Vec<f64> =
        (as_asked.iter()).map(|off| sized(off.abs().max(1.0), 1.0) - 0.5 * (square(&as_asked) - off * off)).collect();
    let turned = |joints: &[JointState]| -0.5 * square(&off(&at(&own.truth.point, joints)));
    let others: Vec<f64> =
        candidates.iter().filter(|own| own.joints != asked.joints).map(|own| turned(&own.joints)).collect();
    let mut swapped = Vec::new();
    for a in 0..seen.len() {
        for b in a + 1..seen.len() {
            let mut made = at(&own.truth.point, &asked.joints);
            made.swap(a, b);
            swapped.push(-0.5 * square(&off(&made)));
        }
    }
    let kinds = [slips, bad, others, swapped];
    let most = kinds.iter().flatten().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
    let odds = kinds.map(|own| own.iter().map(|x| (x - most).exp()).sum::<f64>() / own.len().max(1) as f64);
    odds[0] / odds.iter().sum::<f64>()
}

/// The same with the joint turning the other way; unchanged at rest.
fn reversed(joint: JointState) -> JointState {
    let mut other = joint;
    match &mut other {
        JointState::WholeTurns { rate_deg_s }
        | JointState::PartTurns { rate_deg_s, .. }
        | JointState::Passing { rate_deg_s, .. } => *rate_deg_s *= -1.0,
        JointState::Held { .. } => {}
    }
    other
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
        "wrong sense" => joints[0] = reversed(joints[0]),
        _ => {}
    }
    (joints != asked.joints).then_some(joints.to_vec())
}

fn trial(kind: &'static str, seed: u64) -> Option<Trial> {
    let catalogue = wire::built_in_effects().unwrap();
    let own = drawn(seed);
    let sensors = own.schedule.bench.sensors.len();
    let settings = Settings { goals: own.goals.clone(), ..Settings::default() };
    let mut guide = Guide::new(&own.schedule, &own.schedule.readings, &catalogue, settings).unwrap();
    let mut early = (0, 0);
    let mut advice = guide.advise(false).unwrap();
    let follow = |guide: &Guide, label: Option<&String>, k: usize| -> Reading {
        let found = guide.candidates().iter().find(|c| Some(c.position.as_str()) == label.map(String::as_str));
        // where it has enough, positions of the schedule go on in their order
        found.unwrap_or(&guide.candidates()[(7 * k) % guide.candidates().len()]).clone()
    };
    for k in 0..BEFORE {
        let asked = follow(&guide, advice.next.as_ref().map(|next| &next.position), k);
        guide.accept(measure(&own.schedule, &own.truth, guide.taken(), &asked, seed)).unwrap();
        advice = guide.advise(true).unwrap();
        let newest = advice.newest.as_ref().unwrap();
        early.1 += usize::from(newest.agreement.name() != "not-predicted");
        early.0 += usize::from(newest.agreement.name() == "disagrees");
    }
    if kind == "clean" {
        let (said, report) = ([Said::default(); 3], String::new());
        let (told_apart, explanations) = (None, 0);
        return Some(Trial {
            seed,
            sensors,
            flagged: false,
            said,
            told_apart,
            first: false,
            explanations,
            early,
            report,
        });
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
    // of one sensor, by 20 to 10,000 standard deviations
    let wrong = match kind {
        "wrong value" => {
            let size = own.sd * 10.0_f64.powf(uniform(&mut random, 1.3, 4.0)) * normal(&mut random).signum();
            found = Some((follow(&guide, advice.next.as_ref().map(|next| &next.position), BEFORE), None));
            Some((uniform(&mut random, 0.0, sensors as f64) as usize, size))
        }
        _ => None,
    };
    let what = match kind {
        "slipped mounting" => "slipped-mounting",
        _ => "bad-reading",
    };
    for k in 0..if wrong.is_some() { 0 } else { 40 } {
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
            let asked = if k == 0 {
                follow(&guide, advice.next.as_ref().map(|next| &next.position), BEFORE)
            } else {
                pick(&mut random, &candidates).clone()
            };
            if apart((&own.truth, &asked), (&slipped, &asked)) {
                world = slipped;
                found = Some((asked, None));
                break;
            }
            continue;
        }
        let asked = pick(&mut random, &candidates).clone();
        let Some(joints) = instead(kind, &mut random, &asked) else { continue };
        let made = Reading { joints: joints.clone().into(), ..asked.clone() };
        if turning(&joints) <= 1 && apart((&own.truth, &asked), (&own.truth, &made)) {
            found = Some((asked, Some(joints)));
            break;
        }
    }
    let (asked, made) = found?;
    let seen = |guide: &Guide, world: &Truth, asked: &Reading, made: &Option<Vec<JointState>>| {
        let set = Reading { joints: made.clone().map_or(asked.joints.clone(), Into::into), ..asked.clone() };
        let read = measure(&own.schedule, world, guide.taken(), &set, seed);
        Reading { joints: asked.joints.clone(), ..read }
    };
    let mut read = seen(&guide, &world, &asked, &made);
    if let Some((sensor, size)) = wrong {
        read.observations[sensor].value += size;
    }
    let apart = (kind == "slipped mounting").then(|| told_apart(&own, &candidates, &asked, &read));
    guide.accept(read).unwrap();
    advice = guide.advise(true).unwrap();
    let flagged = advice.newest.as_ref().unwrap().agreement.name() == "disagrees";
    let is = |one: &tumble::guide::Explanation| {
        let same = |own: &Vec<JointState>, made: &Vec<JointState>| own.iter().zip(made).all(|(a, b)| same_state(a, b));
        one.reading == BEFORE + 1 && one.joints.as_ref().zip(made.as_ref()).is_some_and(|(own, made)| same(own, made))
    };
    let right = |advice: &tumble::guide::Advice| {
        let Some(mistake) = &advice.mistake else { return Said::default() };
        let is_kind = |kind: &str| match &made {
            None => kind == what,
            // a setting has several kinds: half a turn may be another position of the schedule
            Some(_) => mistake.explanations.iter().any(|one| one.kind.name() == kind && is(one)),
        };
        let at_it = |one: &tumble::guide::Explanation| one.kind.name() == what && one.reading == BEFORE + 1;
        Said {
            listed: mistake.explanations.iter().any(|one| if made.is_none() { at_it(one) } else { is(one) }),
            alone: mistake.named.is_some_and(|kind| is_kind(kind.name())),
            wrongly: mistake.named.is_some_and(|kind| !is_kind(kind.name())),
        }
    };
    let at_reading = right(&advice);
    let explanations = advice.mistake.as_ref().map_or(0, |own| own.explanations.len());
    let first = advice.mistake.as_ref().and_then(|own| own.explanations.first()).is_some_and(|one| match made {
        None => one.kind.name() == what && one.reading == BEFORE + 1,
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
    let mut later = [Said::default(); AFTER];
    for (k, slot) in later.iter_mut().enumerate() {
        let asked = follow(&guide, advice.next.as_ref().map(|next| &next.position), BEFORE + 1 + k);
        guide.accept(seen(&guide, &world, &asked, &None)).unwrap();
        advice = guide.advise(true).unwrap();
        *slot = right(&advice);
    }
    let report = format!("made {made:?}, told apart {apart:?}, said {at_once}, later {}", said(&advice));
    let said = [at_reading, later[0], later[AFTER - 1]];
    Some(Trial { seed, sensors, flagged, said, told_apart: apart, first, explanations, early, report })
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
        "mistake           calibrations  flagged at once  listed at once/+1/+{AFTER}  named alone at once/+1/+{AFTER}  wrongly  first is right  explanations  flags before / readings judged"
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
        let flagged = of(&|t| t.flagged);
        let each = |what: &dyn Fn(&Said) -> bool| [0, 1, 2].map(|k| of(&|t| what(&t.said[k])));
        let (listed, alone, wrongly) = (each(&|own| own.listed), each(&|own| own.alone), each(&|own| own.wrongly));
        let mut lengths: Vec<usize> = trials.iter().map(|own| own.explanations).collect();
        lengths.sort_unstable();
        let shown = |own: [usize; 3]| own.map(|own| own.to_string()).join("/");
        println!(
            "{kind:<16}  {:>12}  {flagged:>15}  {:>22}  {:>27}  {:>7}  {:>14}  {:>12}  {} / {}",
            trials.len(),
            shown(listed),
            shown(alone),
            shown(wrongly),
            of(&|t| t.first),
            lengths.get(lengths.len() / 2).copied().unwrap_or_default(),
            early.0,
            early.1
        );
        // one value cannot tell a slip from a bad value: both change it by any amount
        let can = |own: &Trial| own.told_apart.is_some_and(|p| p >= 0.95);
        let told = (of(&|t| can(t) && t.said[0].alone), of(&can));
        if kind == "slipped mounting" {
            let by = |count: usize| {
                let own: Vec<&Trial> = trials.iter().filter(|own| own.sensors == count).collect();
                let of = |what: &dyn Fn(&Trial) -> bool| own.iter().filter(|own| what(own)).count();
                let (alone, can) = (of(&|own| own.said[0].alone), of(&can));
                format!("{alone} of {} with {count} (can be told: {can})", own.len())
            };
            println!("  named alone at once, by sensors: {}, {}, {}", by(1), by(2), by(3));
            println!("  of those that can be told at once: {} of {}", told.0, told.1);
        }
        let is_odd = |own: &Trial| {
            let [first, _, last] = own.said;
            !own.flagged || first.wrongly || last.wrongly || !first.listed || (can(own) && !first.alone)
        };
        for own in trials.iter().filter(|own| kind != "clean" && is_odd(own)) {
            println!("  seed {}: flagged {}, {} sensors: {}", own.seed, own.flagged, own.sensors, own.report);
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
            assert!(listed[0] as f64 + 1.0 >= 0.9 * n, "{kind}: {} listed", listed[0]);
            if kind == "slipped mounting" {
                assert!(alone[2] as f64 + 1.0 >= 0.9 * n, "{kind}: {} named", alone[2]);
                assert!(told.0 as f64 + 1.0 >= 0.9 * told.1 as f64, "{kind}: {} of {} named at once", told.0, told.1);
            }
        }
    }
}

/// One rate of the wrong sense that is left in. From the first reading that shows it on, every reading that disagrees finds it as the likely culprit, and no effect takes
/// its place; taken back, nothing disagrees.
#[test]
fn a_wrong_sense_that_is_left_in_stays_the_culprit() {
    let text = r#"{ "bench": "gyro-turntable", "known": { "kI": { "value": -2.9222, "unit": "V/(deg/s)", "u": 0 } },
        "estimate": { "V0": {}, "dtheta_x0": {}, "dtheta_y0": {}, "dtheta_y1": {}, "dtheta_y2": {}, "dtheta_z2": {} },
        "readings": [
          { "position": "1", "alpha_deg": 0, "beta_deg": 0, "gamma_deg_s": [20, -20, 40, -40] },
          { "position": "2", "alpha_deg": 0, "beta_deg": 90, "gamma_deg_s": [20, -20, 40, -40] },
          { "position": "3", "alpha_deg": 90, "beta_deg": 180, "gamma_deg_s": [20, -20, 40, -40] },
          { "position": "4", "alpha_deg": 180, "beta_deg": 180, "gamma_deg_s": [20, -20, 40, -40] },
          { "position": "5", "alpha_deg": 270, "beta_deg": 0, "gamma_deg_s": [20, -20, 40, -40] },
          { "position": "6", "alpha_deg": 45, "beta_deg": 0, "gamma_deg_s": [20, -20, 40, -40] },
          { "position": "7", "alpha_deg": 135, "beta_deg": 270, "gamma_deg_s": [20, -20, 40, -40] },
          { "position": "8", "alpha_deg": 225, "beta_deg": 45, "gamma_deg_s": [20, -20, 40, -40] } ] }"#;
    let schedule = crate::bench::parse(text);
    let catalogue = wire::built_in_effects().unwrap();
    let mut truth = Truth { point: schedule.reference_point(), ..drawn(1).truth };
    for (value, tilt) in truth.point.iter_mut().zip([1.5e-3, 1.5e-5, -4e-5, -2.7e-4, -7.8e-4, 2.7e-4]) {
        *value = tilt;
    }
    truth.noise = vec![DrawnNoise { sd: 1e-4, stated: true, decimals: None }];
    for seed in [1, 2, 3] {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut positions = schedule.readings.rows.clone();
        positions.sort_by_cached_key(|_| uniform(&mut random, 0.0, 1e9) as u64);
        let settings = Settings { noise: vec![("V".into(), 1e-4)], ..Settings::default() };
        let mut guide = Guide::new(&schedule, &schedule.readings, &catalogue, settings).unwrap();
        let mut shown = 0;
        for (k, asked) in positions.iter().take(14).enumerate() {
            let mut set = asked.clone();
            if k == 5 {
                set.joints
                    .iter_mut()
                    .for_each(|joint| *joint = if joint.rate_deg_s() == 0.0 { *joint } else { reversed(*joint) });
            }
            let read = measure(&schedule, &truth, guide.taken(), &set, seed);
            guide.accept(Reading { joints: asked.joints.clone(), ..read }).unwrap();
            let advice = guide.advise(true).unwrap();
            let disagrees = advice.newest.as_ref().unwrap().agreement.name() == "disagrees";
            let culprit = advice.mistake.as_ref().and_then(|own| own.culprit()).map(|(reading, _)| reading);
            println!("seed {seed}, reading {}: disagrees {disagrees}, culprit {culprit:?}", k + 1);
            shown += usize::from(culprit == Some(6));
            assert!(k < 5 || shown == 0 || culprit == Some(6), "seed {seed}, reading {}: {:?}", k + 1, advice.mistake);
        }
        assert!(shown >= 4, "seed {seed}: shown after {shown} readings only");
        guide.undo(6).unwrap();
        let advice = guide.advise(false).unwrap();
        assert!(advice.mistake.is_none(), "seed {seed}: {:?}", advice.mistake);
        assert!(advice.diagnosis.is_none_or(|own| own.effects.is_empty()), "seed {seed}");
    }
}
