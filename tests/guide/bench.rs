//! Benches drawn at random: two or three joints with a tilt after each, one to three sensors, turning or not, tilts from 20 arcsec to a quarter of a
//! degree, noise over a factor of 25, and the full factorial of positions.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::{Pcg64Mcg, rand_core::SeedableRng};
use tumble::campaign::{Campaign, Reading, Readings};
use tumble::diagnosis::{Candidate, Effect};
use tumble::plan::Goal;
use tumble::simulate::{DrawnNoise, Hidden, Truth, simulate};
use tumble::{diagnosis, fit, wire};

/// What is drawn from one seed.
pub struct Drawn {
    pub schedule: Campaign,
    pub truth: Truth,
    pub goals: Vec<Goal>,
    /// Standard deviation of a value.
    pub sd: f64,
    pub random: Pcg64Mcg,
}

pub fn uniform(random: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    Uniform::new(low, high).unwrap().sample(random)
}

pub fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

pub fn pick<'a, T>(random: &mut Pcg64Mcg, list: &'a [T]) -> &'a T {
    &list[(uniform(random, 0.0, list.len() as f64) as usize).min(list.len() - 1)]
}

pub fn parse(text: &str) -> Campaign {
    let source = wire::Source { name: "drawn".into(), text: text.into() };
    wire::read_campaign(&source, &mut |name| panic!("refers to {name}"))
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A bench with its factorial schedule, a truth of small tilts and known noise, and goals that half of the schedule reaches on the whole.
pub fn drawn(seed: u64) -> Drawn {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let turns = uniform(&mut random, 0.0, 1.0) < 0.5;
    let joints = if uniform(&mut random, 0.0, 1.0) < 0.5 { 2 } else { 3 };
    let sensors = 1 + uniform(&mut random, 0.0, 3.0) as usize;
    let axes = *pick(&mut random, &[["z", "x", "y"], ["z", "x", "z"], ["x", "y", "z"], ["z", "y", "x"]]);
    let mut chain = Vec::new();
    let mut position = Vec::new();
    for k in 0..joints {
        chain.push(format!(r#"{{ "joint": "j{k}", "about": "{}" }}"#, axes[k % 3]));
        chain.push(format!(r#"{{ "tilt": "t{k}", "about": "{}" }}"#, axes[(k + 1) % 3]));
        position.push(match (k, turns) {
            (0, true) if joints == 3 => r#""j0_deg_s": [20, -20]"#.to_string(),
            (0, true) => r#""j0_deg_s": [20, -20, 40, -40]"#.to_string(),
            _ if joints == 3 => format!(r#""j{k}_deg": [0, 90, 180, 270]"#),
            _ => format!(r#""j{k}_deg": [0, 45, 90, 135, 180, 225, 270, 315]"#),
        });
    }
    let input = if turns { "w" } else { "a" };
    let scale = if turns { 0.01 } else { 1.0 };
    let mut lines = Vec::new();
    let mut estimate: Vec<String> = (0..joints).map(|k| format!(r#""t{k}": {{}}"#)).collect();
    for (s, axis) in ["x", "y", "z"].iter().enumerate().take(sensors) {
        lines.push(format!(
            r#""S{s}": {{ "unit": "V", "axes": {{ "I": "{axis}" }}, "model": "b{s} + k{s}*{input}_I" }}"#
        ));
        estimate.push(format!(r#""b{s}": {{}}, "k{s}": {{ "start": {scale} }}"#));
    }
    let text = format!(
        r#"{{ "bench": {{ "id": "drawn", "site": {{ "latitude_deg": 48 }}, "units": {{ "rate": "deg/s", "force": "g" }},
            "chain": [{}], "sensors": {{ {} }} }}, "estimate": {{ {} }}, "readings": [ {{ {} }} ] }}"#,
        chain.join(", "),
        lines.join(", "),
        estimate.join(", "),
        position.join(", ")
    );
    let mut schedule = parse(&text);
    let sd = 10.0_f64.powf(uniform(&mut random, -4.7, -3.3));
    let tilt = 10.0_f64.powf(uniform(&mut random, -4.0, -2.3));
    for (k, row) in schedule.readings.rows.iter_mut().enumerate() {
        row.position = format!("P{}", k + 1).into();
        row.planned_u = (0..sensors).map(|s| (s, sd)).collect();
    }
    // tilts that these positions do not determine are no unknowns of this calibration
    let noise = tumble::plan::Noise::new(&schedule, &[], &[]).unwrap();
    let judged = tumble::plan::judge(&schedule, &noise, &Default::default()).unwrap();
    let lost: Vec<String> = judged.parameters.iter().filter(|p| p.u.is_none()).map(|p| p.id.clone()).collect();
    if !lost.is_empty() {
        let keep = |part: &String| !lost.iter().any(|id| part.contains(&format!("\"{id}\"")));
        let fewer: Vec<String> = estimate.iter().filter(|part| keep(part)).cloned().collect();
        let again = text.replace(&estimate.join(", "), &fewer.join(", "));
        let rows = schedule.readings.rows.clone();
        schedule = parse(&again);
        schedule.readings.rows = rows;
    }
    let judged = tumble::plan::judge(&schedule, &noise, &Default::default()).unwrap();
    let mut point = schedule.reference_point();
    for (value, parameter) in point.iter_mut().zip(schedule.estimated()) {
        *value += match parameter.id.as_bytes()[0] {
            b't' => tilt * normal(&mut random),
            b'b' => 2e-3 * normal(&mut random),
            _ => scale * 1e-3 * normal(&mut random),
        };
    }
    let factor = uniform(&mut random, 2.0, 4.0);
    let goals = judged.parameters.iter().filter_map(|p| Some(Goal { id: p.id.clone(), u: p.u? * factor })).collect();
    let truth = Truth {
        point,
        noise: vec![DrawnNoise { sd, stated: true, decimals: None }; sensors],
        effects: Vec::new(),
        scatter: Vec::new(),
    };
    Drawn { schedule, truth, goals, sd, random }
}

/// Hide so many effects of the catalogue, of 10 to 40 of their uncertainties at the whole schedule; their columns beside the model.
pub fn hide(drawn: &mut Drawn, count: usize, catalogue: &[Effect]) -> Vec<Candidate> {
    let quiet = simulate(&drawn.schedule, &drawn.truth, 1).unwrap();
    let all = diagnosis::candidates(&quiet, catalogue).unwrap();
    let plain: Vec<(Candidate, f64)> = all
        .into_iter()
        .filter(|(own, u)| {
            let term = matches!(own.kind, tumble::simulate::Regressor::Term(_));
            term && u.is_finite() && own.visible > 0.2 && !own.vanishing
        })
        .collect();
    let mut hidden: Vec<Candidate> = Vec::new();
    while hidden.len() < count.min(plain.len()) {
        let (own, u) = pick(&mut drawn.random, &plain).clone();
        if hidden.iter().any(|other| cosine(&quiet, &other.column, &own.column).abs() > 0.9) {
            continue;
        }
        let size =
            uniform(&mut drawn.random, 10.0, 40.0) * u * if normal(&mut drawn.random) < 0.0 { -1.0 } else { 1.0 };
        drawn.truth.effects.push(Hidden { regressor: own.kind.clone(), value: size, sensor: own.sensor });
        hidden.push(own);
    }
    hidden
}

/// Cosine of two columns beside the model of a measured campaign.
pub fn cosine(measured: &Campaign, a: &[f64], b: &[f64]) -> f64 {
    let fitted = fit::fit(measured, &fit::Settings::default()).unwrap();
    let rows = fitted.design.rows.len();
    let left = |column: &[f64]| {
        let weighted: Vec<f64> = column.iter().take(rows).zip(&fitted.system.u).map(|(c, u)| c / u).collect();
        fitted.estimate.factor.project_out(&weighted).unwrap()
    };
    let (a, b) = (left(a), left(b));
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt()
}

/// The same position without values; their stated uncertainties stay, as those of values to be read.
fn unread(own: &Reading) -> Reading {
    let stated = own.observations.iter().filter_map(|o| Some((o.sensor, o.u?)));
    let planned_u = own.planned_u.iter().copied().chain(stated).collect();
    Reading { observations: Vec::new().into(), planned_u, ..own.clone() }
}

/// What the sensors say at a position, after those that were read before; `truth` is the world.
pub fn measure(schedule: &Campaign, truth: &Truth, before: &[Reading], asked: &Reading, seed: u64) -> Reading {
    let rows = before.iter().map(unread).chain([asked.clone()]).collect();
    let columns = schedule.readings.columns.clone();
    let all = simulate(&schedule.with_readings(Readings { columns, rows }), truth, seed).unwrap();
    all.readings.rows.last().unwrap().clone()
}
