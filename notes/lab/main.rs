mod bank;
mod passes;
#[path = "../../tests/diagnosis/schedules.rs"]
mod schedules;
mod score;
use faer::Side;
use faer::linalg::solvers::{Llt, Solve};
use passes::Answer;
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use rayon::prelude::*;
use schedules::{cosines, draw, fitted, left_of, normal, random, schedule};
use tumble::campaign::{Campaign, JointState};
use tumble::diagnosis::{Candidate, Effect, candidates};
use tumble::fit::Fit;
use tumble::simulate::{DrawnNoise, Hidden, Truth, simulate};
use tumble::wire;

const SCHEDULES: [&str; 4] = ["G5", "G16", "G16x45", "A24"];
const MODES: [&str; 7] = ["one", "two", "three", "none", "mixed", "outside", "tilts"];

struct Trial { mode: &'static str, stated: bool, right: bool, wrong: usize, noticed: bool, stands: bool, suspected: bool, held: (usize, usize), text: String, seconds: f64 }

fn sines(model: &Fit, chosen: &[(Candidate, f64)]) -> Vec<f64> {
    let columns: Vec<&Vec<f64>> = chosen.iter().map(|(c, _)| &c.column).collect();
    let gram = cosines(model, &columns);
    let Ok(factor) = Llt::new(gram.as_ref(), Side::Lower) else { return vec![0.0; chosen.len()] };
    let inverse = factor.solve(faer::Mat::<f64>::identity(chosen.len(), chosen.len()));
    (0..chosen.len()).map(|k| (1.0 / inverse[(k, k)].max(1.0_f64)).sqrt()).collect()
}

/// A pattern from outside, drawn at random: value for each reading, rms about one.
fn pattern(c: &Campaign, g: &mut Pcg64Mcg) -> (String, Vec<f64>) {
    let n = c.readings.rows.len();
    let tcol = c.readings.columns.iter().position(|x| x == "time_s");
    let time: Vec<f64> = c.readings.rows.iter().enumerate().map(|(i, r)| tcol.and_then(|k| r.columns[k]).unwrap_or(i as f64)).collect();
    let (a, b) = time.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    let u: Vec<f64> = time.iter().map(|t| (t - a) / (b - a)).collect();
    let joints: Vec<usize> = (0..c.bench.joints().count()).filter(|k| c.readings.rows.iter().any(|r| matches!(r.joints[*k], JointState::Held { .. }))).collect();
    let angle = |i: usize, k: usize| match c.readings.rows[i].joints[k] { JointState::Held { angle_deg } => angle_deg.to_radians(), _ => 0.0 };
    let kind = random(g, 0.0, 7.0) as usize;
    let (name, mut v): (&str, Vec<f64>) = match kind {
        0 => { let w: Vec<(f64, f64)> = (1..=5).map(|k| (normal(g) / k as f64, random(g, 0.0, 6.283))).collect();
            ("smooth in time", u.iter().map(|u| w.iter().enumerate().map(|(k, (a, p))| a * ((k + 1) as f64 * 3.7 * u + p).sin()).sum()).collect()) }
        1 => { let mut s = 0.0; ("walk", (0..n).map(|_| { s += normal(g); s }).collect()) }
        2 => { let (at, w) = (random(g, 0.15, 0.85), random(g, 0.03, 0.15)); ("bump", u.iter().map(|u| (-0.5 * ((u - at) / w).powi(2)).exp()).collect()) }
        3 => { let (f, p) = (random(g, 2.0, 9.0), random(g, 0.0, 6.283)); ("square in time", u.iter().map(|u| (6.283 * f * u + p).sin().signum()).collect()) }
        4 => { let k = joints[random(g, 0.0, joints.len() as f64) as usize]; let (at, w) = (random(g, 0.0, 6.283), random(g, 0.5, 6.0));
            ("lobe", (0..n).map(|i| (w * ((angle(i, k) - at).cos() - 1.0)).exp()).collect()) }
        5 => { let k = joints[random(g, 0.0, joints.len() as f64) as usize]; let (f, p) = (random(g, 2.5, 7.0).floor(), random(g, 0.0, 6.283));
            ("square in angle", (0..n).map(|i| (f * angle(i, k) + p).sin().signum()).collect()) }
        _ => { let mut seen: std::collections::HashMap<Vec<u64>, f64> = Default::default();
            ("random of angles", (0..n).map(|i| { let key: Vec<u64> = joints.iter().map(|k| angle(i, *k).to_bits()).collect(); *seen.entry(key).or_insert_with(|| normal(g)) }).collect()) }
    };
    let rates: Vec<f64> = c.readings.rows.iter().map(|r| r.joints.iter().map(|j| j.rate_deg_s()).sum()).collect();
    let fast = rates.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let mut name = name.to_string();
    if kind >= 4 && fast > 0.0 && random(g, 0.0, 1.0) < 0.4 { v.iter_mut().zip(&rates).for_each(|(v, r)| *v *= r / fast); name += " x rate"; }
    (name, v)
}

fn trial(mode: &'static str, stated: bool, schedule_name: &'static str, seed: u64, catalogue: &[Effect], settings: &score::Settings) -> Trial {
    let mut g = Pcg64Mcg::seed_from_u64(seed);
    let tilts: &[&str] = if schedule_name == "A24" { &["dtheta_z2"] } else { &["dtheta_x0", "dtheta_y1", "dtheta_z2"] };
    let tilts: Vec<&str> = tilts.iter().copied().filter(|t| is_seen(schedule_name, t)).collect();
    let dropped = (mode == "tilts").then(|| tilts[random(&mut g, 0.0, tilts.len() as f64) as usize]);
    let mut twin = g.clone();
    let (plan, sd) = schedule(schedule_name, dropped, &mut g);
    let mut point = plan.reference_point();
    for (value, p) in point.iter_mut().zip(plan.estimated()) { *value = if p.id == "V0" { 2e-3 * normal(&mut g) } else { 4e-4 * normal(&mut g) }; }
    let mut hidden: Vec<String> = vec![];
    if let Some(tilt) = dropped {
        let size = random(&mut g, 2e-4, 1e-3);
        point[plan.parameter_index(tilt).unwrap()] = if normal(&mut g) < 0.0 { -size } else { size };
        hidden.push(format!("tilt:{tilt}"));
    }
    let truth: Vec<(String, f64)> = plan.estimated().iter().zip(&point).map(|(p, v)| (p.id.clone(), *v)).collect();
    let noise = vec![DrawnNoise { sd, stated, decimals: None }];
    let (whole, _) = schedule(schedule_name, None, &mut twin);
    let mut complete = whole.reference_point();
    for (value, p) in complete.iter_mut().zip(&whole.parameters) { *value = plan.parameter_index(&p.id).and_then(|k| point.get(k)).copied().unwrap_or(*value); }
    let quiet = Truth { point: complete, noise: vec![DrawnNoise { sd, stated: true, decimals: None }], effects: vec![], scatter: vec![] };
    let quiet = simulate(&whole, &quiet, seed).unwrap();
    let model = fitted(&quiet);
    let all = candidates(&quiet, catalogue).unwrap();
    let inside: Vec<_> = all.iter().filter(|(c, u)| u.is_finite() && c.visible > 0.05).cloned().collect();
    let through: Vec<_> = inside.iter().filter(|(c, _)| c.size < 0.02).cloned().collect();
    let inside: Vec<_> = inside.into_iter().filter(|(c, _)| !c.vanishing).collect();
    let mut chosen: Vec<(Candidate, f64)> = vec![];
    let count = match mode { "one" | "mixed" => 1, "two" => 2, "three" => 3, _ => 0 };
    while chosen.len() < count {
        let next = draw(&inside, &mut g).clone();
        let columns: Vec<&Vec<f64>> = chosen.iter().chain([&next]).map(|(c, _)| &c.column).collect();
        let last = columns.len() - 1;
        let gram = cosines(&model, &columns);
        let apart = sines(&model, &chosen.iter().chain([&next]).cloned().collect::<Vec<_>>());
        if (0..last).all(|j| gram[(last, j)].abs() < 0.94) && apart.iter().all(|s| *s > 0.3) { chosen.push(next); }
    }
    if mode == "tilts" {
        let from = if through.is_empty() { &inside } else { &through };
        chosen.push(from[random(&mut g, 0.0, from.len() as f64) as usize % from.len()].clone());
    }
    let mut effects = vec![];
    let mut strength = vec![];
    let mut signal = vec![0.0; model.design.rows.len()];
    let apart = sines(&model, &chosen);
    for (k, (c, u)) in chosen.iter().enumerate() {
        let t = random(&mut g, 10f64.ln(), 40f64.ln()).exp() / apart.get(k).copied().unwrap_or(1.0);
        let sign = if normal(&mut g) < 0.0 { -1.0 } else { 1.0 };
        effects.push(Hidden::new(&plan, &c.regressor, sign * t * u, c.sensor).unwrap());
        signal.iter_mut().zip(&c.column).for_each(|(s, v)| *s += sign * t * u * v);
        strength.push(t);
    }
    let mut campaign = simulate(&plan, &Truth { point, noise, effects, scatter: vec![] }, seed).unwrap();
    hidden.extend(chosen.iter().map(|(c, _)| c.regressor.clone()));
    let mut stands = true;
    let mut outside: Option<Vec<f64>> = None;
    if mode == "mixed" || mode == "outside" {
        let t = random(&mut g, 10f64.ln(), 40f64.ln()).exp();
        let (mut name, mut v);
        loop {
            (name, v) = pattern(&campaign, &mut g);
            let own: Vec<f64> = model.design.rows.iter().map(|o| v[o.reading]).collect();
            let left = left_of(&model, &own);
            let rms = (own.iter().map(|x| x * x).sum::<f64>() / own.len() as f64).sqrt();
            if !(left > 0.2 * rms) { continue; }
            // not what the catalogue has
            let a: Vec<&Vec<f64>> = [&own].into_iter().chain(inside.iter().map(|(c, _)| &c.column)).collect();
            let gram = cosines(&model, &a);
            if (1..a.len()).any(|j| gram[(0, j)].abs() > 0.9) { continue; }
            let s = t * sd / (left * (own.len() as f64).sqrt());
            v.iter_mut().for_each(|x| *x *= s);
            outside = Some(own.iter().map(|x| x * s).collect());
            signal.iter_mut().zip(&own).for_each(|(a, x)| *a += x * s);
            break;
        }
        for (row, v) in campaign.readings.rows.iter_mut().zip(&v) { row.observations[0].value += v; }
        let n = v.len() as f64;
        if mode == "mixed" { stands = strength[0] / (1.0 + t * t / n).sqrt() >= 8.0; }
        strength.push(t);
        hidden.push(name);
    }
    let started = std::time::Instant::now();
    let Some(found) = ask(&campaign, catalogue, settings) else {
        return Trial { mode, stated, right: false, wrong: 0, noticed: false, stands, suspected: false, held: (0, 0), text: format!("{seed} {schedule_name} {hidden:?} FAILED"), seconds: 0.0 };
    };
    let seconds = started.elapsed().as_secs_f64();
    let catalogued = hidden.len() - usize::from(outside.is_some());
    let named: Vec<&passes::Named> = found.named.iter().filter(|n| n.probability >= settings.named).collect();
    let is = |n: &passes::Named, h: &str| n.effect.regressor == *h || n.aliases.iter().any(|a| a.0.regressor == *h);
    let right = hidden[..catalogued].iter().filter(|h| named.iter().any(|n| is(n, h))).count();
    let suspected = hidden[..catalogued].iter().filter(|h| found.named.iter().any(|n| is(n, h))).count();
    let deserved = |n: &passes::Named| {
        let mut columns: Vec<&Vec<f64>> = vec![&n.effect.column];
        columns.extend(hidden.iter().filter_map(|h| all.iter().find(|(c, _)| c.regressor == *h)).map(|(c, _)| &c.column));
        let gram = cosines(&model, &columns);
        (1..columns.len()).any(|j| gram[(0, j)].abs() >= 0.85) || hidden.iter().any(|h| is(n, h))
    };
    let a_sum = found.after.as_ref().is_some_and(|after| left_of(after, &signal) < if outside.is_some() { 0.436 } else { 0.1 } * left_of(&model, &signal));
    let wrong = named.iter().filter(|n| !a_sum && !deserved(n)).count();
    let noticed = found.nothing < 0.5;
    let ok = match mode {
        "none" => named.is_empty() && found.nothing > 0.5,
        "outside" => wrong == 0 && noticed,
        "mixed" => right == 1,
        _ => right == hidden.len() && wrong == 0,
    };
    let mut held = (0, 0);
    let base = if found.after.is_none() { Some(fitted(&campaign)) } else { None };
    let fit = found.after.as_ref().or(base.as_ref());
    let _ = fit;
    for (id, t) in truth.iter().filter(|(id, _)| id != "V0") {
        if let Some((_, Some(v), Some(u))) = found.changes.iter().find(|c| c.0 == *id) { held.1 += 1; held.0 += usize::from((v - t).abs() <= 1.96 * u); }
    }
    let text = format!("{seed} {schedule_name} {} {hidden:?} t {:?}\n      -> right {right} wrong {wrong} nothing {:.3} outside {:.3} {:?} passes {} {:.3}s\n      named {}\n      top {}", if stated { "stated" } else { "unknown" },
        strength.iter().map(|t| *t as i32).collect::<Vec<_>>(), found.nothing, found.outside, found.kernels.iter().map(|(n, p)| format!("{n} {p:.2}")).collect::<Vec<_>>(), found.passes, seconds,
        found.named.iter().map(|n| format!("{} P {:.3} [{}]", n.effect.regressor, n.probability, n.aliases.iter().take(6).map(|a| a.0.regressor.clone()).collect::<Vec<_>>().join(" "))).collect::<Vec<_>>().join(", "),
        found.top.iter().map(|(p, s)| format!("{p:.3} {s:?}")).collect::<Vec<_>>().join("\n          "));
    Trial { mode, stated, right: ok, wrong, noticed, stands, suspected: suspected == catalogued, held, text, seconds }
}

/// The library itself.
fn ask(campaign: &Campaign, catalogue: &[Effect], settings: &score::Settings) -> Option<passes::Answer> {
    if std::env::var("LAB").is_ok() { return passes::diagnose(campaign, catalogue, settings); }
    let found = tumble::diagnosis::diagnose(campaign, catalogue, &Default::default()).ok()?;
    let blank = |a: &tumble::diagnosis::Alias, c: &Candidate| Candidate { regressor: a.regressor.clone(), ..c.clone() };
    let named = found.effects.iter().map(|f| passes::Named { effect: f.effect.clone(), aliases: f.aliases.iter().map(|a| (blank(a, &f.effect), a.probability)).collect(), probability: f.probability }).collect();
    use tumble::diagnosis::Verdict::*;
    Some(passes::Answer { named, nothing: if found.verdict == NothingMissing { 1.0 } else { 0.0 }, outside: if matches!(found.verdict, PartlyExplained | Unexplained) { 1.0 } else { 0.0 },
        kernels: vec![(found.verdict.name().to_string(), 1.0)], passes: 0, top: vec![], changes: found.changes.iter().map(|c| (c.id.clone(), c.after.0, c.u_in_all())).collect(), after: found.after })
}

fn is_seen(schedule_name: &str, tilt: &str) -> bool {
    static CACHE: std::sync::Mutex<Option<std::collections::HashMap<(String, String), bool>>> = std::sync::Mutex::new(None);
    let k = (schedule_name.to_string(), tilt.to_string());
    if let Some(v) = CACHE.lock().unwrap().get_or_insert_default().get(&k) { return *v; }
    let mut g = Pcg64Mcg::seed_from_u64(1);
    let (plan, sd) = schedule(schedule_name, Some(tilt), &mut g);
    let truth = Truth { point: plan.reference_point(), noise: vec![DrawnNoise { sd, stated: true, decimals: None }], effects: vec![], scatter: vec![] };
    let own = format!("tilt:{tilt}");
    let all = candidates(&simulate(&plan, &truth, 1).unwrap(), &wire::built_in_effects().unwrap()).unwrap();
    let v = all.iter().any(|(c, u)| c.regressor == own && u.is_finite() && 2e-4 / u > 10.0);
    CACHE.lock().unwrap().get_or_insert_default().insert(k, v);
    v
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    if args.get(1).is_some_and(|a| a == "file") {
        for name in &args[2..] {
            let text = std::fs::read_to_string(name).unwrap();
            let source = wire::Source { name: name.clone(), text };
            let campaign = match wire::read_campaign(&source, &mut |_| unreachable!()) { Ok(c) => c, Err(e) => { println!("{name}: {e:?}"); continue } };
            if std::env::var("LAB").is_ok() {
                if let Some(a) = passes::diagnose(&campaign, &wire::built_in_effects().unwrap(), &Default::default()) {
                    println!("{name}: nothing {:.3} outside {:.3} {:?}", a.nothing, a.outside, a.kernels);
                    for n in &a.named { println!("    {} P {:.3} [{}]", n.effect.regressor, n.probability, n.aliases.iter().take(8).map(|x| format!("{} {:.3}", x.0.regressor, x.1)).collect::<Vec<_>>().join(" ")); }
                    for (p, t) in &a.top { println!("      {p:.4} {t:?}"); }
                }
                continue;
            }
            let started = std::time::Instant::now();
            match tumble::diagnosis::diagnose(&campaign, &wire::built_in_effects().unwrap(), &Default::default()) {
                Ok(found) => {
                    println!("{name}: {} rows, {} in {:.2} s", campaign.readings.rows.len(), found.verdict.name(), started.elapsed().as_secs_f64());
                    for f in &found.effects { println!("    {} {:?} = {:?} +- {:?} t {:.1} P {:.4} [{}]", f.effect.regressor, f.effect.sensor, f.value, f.u, f.t, f.probability, f.aliases.iter().take(8).map(|a| a.regressor.clone()).collect::<Vec<_>>().join(" ")); }
                    if let Some(u) = &found.unexplained { println!("    {} | {:?} {:?} nearest {:?}", u.pattern, u.follows, u.sd, u.nearest.iter().map(|c| c.regressor.clone()).collect::<Vec<_>>()); }
                }
                Err(e) => println!("{name}: {e:?}"),
            }
        }
        return;
    }
    let each: usize = args.get(1).and_then(|a| a.parse().ok()).unwrap_or(8);
    let seed: u64 = args.get(2).and_then(|a| a.parse().ok()).unwrap_or(0);
    let only = args.get(3).filter(|m| *m != "all");
    let mut settings = score::Settings::default();
    for a in args.iter().skip(4) {
        let (k, v) = a.split_once('=').unwrap();
        let v: f64 = v.parse().unwrap();
        match k { "outside" => settings.outside = v, "odds" => settings.odds = v, "alias" => settings.alias = v, "named" => settings.named = v, "vanishing" => settings.vanishing = v, "rank" => settings.least_rank = v as usize, "smallest" => settings.smallest = v, "largest" => settings.largest = v, _ => panic!("{k}") }
    }
    let catalogue = wire::built_in_effects().unwrap();
    let jobs: Vec<(usize, bool, usize)> = (0..MODES.len()).filter(|m| only.is_none_or(|o| o == MODES[*m])).flat_map(|m| [true, false].into_iter().flat_map(move |s| (0..each).map(move |k| (m, s, k)))).collect();
    let trials: Vec<Trial> = jobs.par_iter().map(|(m, s, k)| trial(MODES[*m], *s, SCHEDULES[k % 4], seed + 1_000_003 * *m as u64 + 500_009 * u64::from(*s) + *k as u64, &catalogue, &settings)).collect();
    for t in &trials { if (t.stands && !t.right) || t.wrong > 0 { println!("{} {} {}", t.mode, if t.right { "right" } else { "NOT" }, t.text); } }
    println!("{:8} {:8} {:>4} {:>6} {:>6} {:>8} {:>9} {:>6} {:>6}", "mode", "noise", "n", "right", "wrong", "noticed", "suspected", "held%", "s");
    for m in MODES { for s in [true, false] {
        let own: Vec<&Trial> = trials.iter().filter(|t| t.mode == m && t.stated == s).collect();
        if own.is_empty() { continue; }
        let st: Vec<&&Trial> = own.iter().filter(|t| t.stands).collect();
        let h = own.iter().fold((0, 0), |a, t| (a.0 + t.held.0, a.1 + t.held.1));
        println!("{m:8} {:8} {:>4} {:>6} {:>6} {:>8} {:>9} {:>6.1} {:>6.3}", if s { "stated" } else { "unknown" }, st.len(), st.iter().filter(|t| t.right).count(), own.iter().filter(|t| t.wrong > 0).count(), own.iter().filter(|t| t.noticed).count(), st.iter().filter(|t| t.suspected).count(), 100.0 * h.0 as f64 / h.1.max(1) as f64, own.iter().map(|t| t.seconds).sum::<f64>() / own.len() as f64);
    } }
}
