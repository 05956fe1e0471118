//! Effects of the catalogue on schedules, and the positions that tell them apart, against closed forms and against diagnoses of seeded readings.

use crate::draws::draws;
use crate::plan_support::*;
use tumble::algebra::Expression;
use tumble::diagnosis;
use tumble::plan::{self, Costs, Noise, Offer, Term};
use tumble::simulate::{self, Regressor};
use tumble::wire::{self, Source};

/// A straight line from x = -1 and 1 only: a quadratic hides in the constant, a cubic in the slope, and both shift them by what they are there.
#[test]
fn absorbed_effects_are_named_with_the_parameter_that_hides_them() {
    let line = line("[-1, 1, -1, 1]");
    let noise = Noise::new(&line, &[("y".into(), 0.1)], &[]).unwrap();
    let text = r#"{ "effects": [ { "term": "x^2", "name": "quadratic" }, { "term": "x^3", "name": "cubic" }, { "term": "x^2 - 1", "name": "nothing" } ] }"#;
    let effects = wire::read_effects(&Source { name: "effects".into(), text: text.into() }).unwrap();
    let foresight = diagnosis::foresee(&line, &effects, &noise).unwrap();
    let fates: Vec<_> =
        foresight.prospects.iter().map(|p| (p.effect.name.as_str(), p.fate.name(), p.hides_in.clone())).collect();
    assert_eq!(fates[0], ("quadratic", "absorbed", vec![0]));
    assert_eq!(fates[1], ("cubic", "absorbed", vec![1]));
    assert_close(foresight.prospects[0].shifts[0], 1.0, 1e-12);
    // on -1, 0, 1 the quadratic is seen: c' = (1/3, -2/3, 1/3), so u = sd / sqrt(2/3); the cubic still hides
    let campaign = self::line("[-1, 0, 1]");
    let foresight = diagnosis::foresee(&campaign, &effects, &noise).unwrap();
    let quadratic = &foresight.prospects[0];
    assert_eq!((quadratic.fate.name(), foresight.prospects[1].fate.name()), ("detectable", "absorbed"));
    assert_close(quadratic.u.unwrap(), 0.1 / (2.0_f64 / 3.0).sqrt(), 1e-12);
    assert_close(quadratic.minimal.unwrap(), foresight.rule.noncentrality * quadratic.u.unwrap(), 1e-12);
}

/// A campaign made with an effect of the promised smallest size is diagnosed with the
/// promised power, whatever its name: normal noise of stated size.
#[test]
fn effects_of_the_smallest_size_are_found_with_the_promised_power() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let effects = wire::built_in_effects().unwrap();
    let foresight = diagnosis::foresee(&campaign, &effects, &noise).unwrap();
    let find = |name: &str| foresight.prospects.iter().find(|p| p.effect.regressor == name).unwrap();
    assert_eq!(find("a_S").group, find("a_S^2").group);
    assert_eq!((find("w_S").fate.name(), find("w_S").hides_in.len()), ("absorbed", 1));
    assert_eq!(find("w_I*w_O").fate.name(), "not-exercised");
    println!("{:?}", foresight.rule);
    let schedule = campaign.with_readings(plan::positions_only(&campaign.readings));
    for name in ["a_S", "w_O^2", "sign(gamma_deg_s)"] {
        let prospect = find(name);
        let truth = |share: f64| simulate::Truth {
            point: campaign.reference_point(),
            noise: vec![simulate::DrawnNoise { sd: 9e-4, stated: true, decimals: None }],
            effects: vec![simulate::Hidden {
                regressor: prospect.effect.kind.clone(),
                value: share * prospect.minimal.unwrap(),
                sensor: Some(0),
            }],
            scatter: vec![],
        };
        // named: it, or an alias of it
        let is_named = |own: &diagnosis::Finding| {
            own.effect.regressor == name || own.aliases.iter().any(|alias| alias.regressor == name)
        };
        let count = draws(60, 1000) as u64;
        let found = |share: f64| {
            (0..count)
                .filter(|seed| {
                    let measured = simulate::simulate(&schedule, &truth(share), *seed).unwrap();
                    let made = diagnosis::diagnose(&measured, &effects, &diagnosis::Settings::default()).unwrap();
                    made.effects.iter().any(is_named)
                })
                .count() as f64
                / count as f64
        };
        let (half, whole) = (found(0.5), found(1.0));
        println!("{name:>20}: named in {half:.2} at half the size, {whole:.2} at the smallest size");
        // three standard deviations of so many draws
        let slack = 3.0 * (0.16 / count as f64).sqrt();
        assert!((whole - 0.8).abs() < slack && half < 0.3, "{name}: {half} {whole}");
    }
}

/// From the size at which the plan says so, an effect is not taken for its nearest rival, with the power that the plan states.
#[test]
fn effects_of_their_size_are_not_taken_for_another() {
    let campaign = published();
    let noise = Noise::new(&campaign, &[("V".into(), 9e-4)], &[]).unwrap();
    let effects = wire::built_in_effects().unwrap();
    let foresight = diagnosis::foresee(&campaign, &effects, &noise).unwrap();
    let schedule = campaign.with_readings(plan::positions_only(&campaign.readings));
    // the pairs that are nearest to each other, and are told apart at a size that exists
    let mut pairs: Vec<(usize, usize, f64)> = Vec::new();
    for (g, group) in foresight.groups.iter().enumerate() {
        pairs.extend(group.near.first().map(|near| (g, near.group, near.apart_from)));
    }
    pairs.sort_by(|a, b| a.2.total_cmp(&b.2));
    let members =
        |g: usize| foresight.groups[g].members.iter().map(|j| foresight.prospects[*j].effect.regressor.clone());
    let count = draws(40, 400);
    let (mut told, mut tried) = (0, 0);
    for (own, other, size) in pairs.into_iter().take(2) {
        let prospect = &foresight.prospects[foresight.groups[own].members[0]];
        let rivals: Vec<String> = members(other).collect();
        let hidden =
            simulate::Hidden { regressor: prospect.effect.kind.clone(), value: size, sensor: prospect.effect.sensor };
        let truth = simulate::Truth {
            point: campaign.reference_point(),
            noise: vec![simulate::DrawnNoise { sd: 9e-4, stated: true, decimals: None }],
            effects: vec![hidden],
            scatter: vec![],
        };
        let right = (0..count as u64)
            .filter(|seed| {
                let measured = simulate::simulate(&schedule, &truth, *seed).unwrap();
                let made = diagnosis::diagnose(&measured, &effects, &diagnosis::Settings::default()).unwrap();
                let is_rival = |name: &String| rivals.contains(name);
                let taken = |f: &diagnosis::Finding| {
                    is_rival(&f.effect.regressor) || f.aliases.iter().any(|a| is_rival(&a.regressor))
                };
                !made.effects.is_empty() && !made.effects.iter().any(taken)
            })
            .count();
        println!(
            "{} at {size:.3e}: not taken for {} in {right} of {count}",
            prospect.effect.regressor,
            rivals.join(", ")
        );
        (told, tried) = (told + right, tried + count);
    }
    let share = told as f64 / tried.max(1) as f64;
    let slack = 3.0 * (0.16 / tried.max(1) as f64).sqrt();
    assert!(tried == 0 || (share - 0.8).abs() < slack + 0.05, "{share}");
}

/// What a further reading adds to T, against a fresh adjustment with it: rank-one updates and definition agree, and the best comes first.
#[test]
fn positions_that_tell_are_best_first() {
    let campaign = line("[-1, -1, 1, 1, 0.5]");
    let noise = Noise::new(&campaign, &[("y".into(), 0.2)], &[]).unwrap();
    let candidates = line("[-0.9, -0.6, -0.3, 0, 0.2, 0.4, 0.8]").readings;
    let offer = Offer { kept: campaign.readings.clone(), candidates, noise: noise.clone(), costs: Costs::default() };
    let term = |text: &str| Term { sensor: Some(0), regressor: Regressor::Term(Expression::parse(text).unwrap()) };
    let [a, b] = [term("x^2"), term("x^3")];
    let list = plan::discriminating_positions(&campaign, &offer, &a, std::slice::from_ref(&b)).unwrap();
    // T = 1 / variance of the coefficient of x^2 beside 1, x, x^3
    let t = |xs: &[f64]| {
        let rows: Vec<Vec<f64>> = xs.iter().map(|x| vec![1.0, *x, x * x * x, x * x]).collect();
        let m: Vec<Vec<f64>> =
            (0..4).map(|i| (0..4).map(|j| rows.iter().map(|r| r[i] * r[j]).sum::<f64>() / 0.04).collect()).collect();
        let whole = determinant(m.clone());
        let rest = determinant(m[..3].iter().map(|r| r[..3].to_vec()).collect());
        if rest > 1e-12 { whole / rest } else { 0.0 }
    };
    let own = [-1.0, -1.0, 1.0, 1.0, 0.5];
    let at: Vec<f64> = list.iter().map(|t| t.position.columns[0].unwrap()).collect();
    let gain = |x: f64| t(&[own.as_slice(), &[x]].concat()) - t(&own);
    let most = gain(at[0]);
    for pair in at.windows(2) {
        assert!(gain(pair[0]) >= gain(pair[1]) - 1e-3 * most);
    }
    for (position, x) in list.iter().zip(&at) {
        assert_close(position.least, gain(*x) / most, 1e-6);
    }
    assert!(list.len() >= 5);
}

/// On x = -1 and 1 alone, x^2 and x^4 are both constants; the added positions must tell them apart.
#[test]
fn positions_that_tell_two_effects_apart() {
    let campaign = line("[-1, 1]");
    let noise = Noise::new(&campaign, &[("y".into(), 0.1)], &[]).unwrap();
    let candidates = line("[-1, -0.7, 0, 0.4, 0.7, 1]").readings;
    let offer = Offer { kept: campaign.readings.clone(), candidates, noise, costs: Costs::default() };
    let term = |text: &str| Term { sensor: Some(0), regressor: Regressor::Term(Expression::parse(text).unwrap()) };
    let apart = plan::discriminate(&campaign, &offer, [&term("x^2"), &term("x^4")], 2, 20, 1).unwrap();
    assert_eq!(apart.before, [None, None]);
    assert!(apart.after.iter().all(Option::is_some) && apart.positions.len() >= 2);
    // the same term twice is told apart by nothing
    let same = plan::discriminate(&campaign, &offer, [&term("x^2"), &term("x*x")], 2, 20, 1).unwrap();
    assert!(same.positions.is_empty() && same.after == [None, None]);
}
