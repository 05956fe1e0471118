//! Readings that come in parts: whatever the order, the parts and the order of joining, a device's row is what its own fit says.

use super::batch::{Draws, Table, is_uncertain, single, table};
use serde_json::json;
use tumble::batch::{Coverage, Device, Layout, Part, Parts, Row, Verdict};
use tumble::campaign::{Campaign, Readings};
use tumble::error::Result;
use tumble::fit::{Estimator, Settings};
use tumble::wire::{self, CampaignFile, ReadingFile};

/// The campaign without readings, and the devices.
fn devices(table: &Table) -> (Campaign, Layout, Vec<Device>) {
    let file: CampaignFile = serde_json::from_value(table.file.clone()).expect("a campaign");
    let bench = file.resolved_bench(&mut |name| panic!("refers to {name}")).expect("a bench");
    let rows: Vec<ReadingFile> = serde_json::from_value(json!(table.rows)).expect("readings");
    let (layout, devices) = wire::inline_devices(&bench, rows, "serial", |_| false).expect("devices");
    let readings = Readings { columns: layout.numeric(&bench), rows: Vec::new() };
    (file.with(bench, readings).expect("a campaign"), layout, devices)
}

/// The row of a device whose readings are dealt to so many parts, in blocks of at most `block`, which are packed, and joined in another order.
fn in_parts(
    step: &Parts,
    layout: &Layout,
    device: &Device,
    (parts, block): (usize, usize),
    draws: &mut Draws,
) -> Result<Row> {
    let readings = wire::device_readings(&step.campaign().bench, layout, device)?;
    let mut dealt: Vec<Vec<usize>> = vec![Vec::new(); parts];
    for k in 0..readings.rows.len() {
        let part = draws.below(parts);
        let place = draws.below(dealt[part].len() + 1);
        dealt[part].insert(place, k);
    }
    let mut whole = step.nothing();
    for own in dealt {
        let mut part = step.nothing();
        for own in own.chunks(block) {
            let rows = own.iter().map(|k| readings.rows[*k].clone()).collect();
            let own = Readings { columns: readings.columns.clone(), rows };
            if own.rows.iter().all(|row| row.observations.is_empty()) {
                continue;
            }
            let lines = step.lines(own.clone())?;
            let values: Vec<_> = lines
                .iter()
                .map(|line| {
                    let row = &own.rows[line.reading];
                    (line, *row.observations.iter().find(|o| o.sensor == line.sensor).expect("a value"))
                })
                .collect();
            step.push(&mut part, &values)?;
        }
        let part: Part = step.unpack(&part.pack())?;
        whole.merge(&part)?;
    }
    Ok(step.finish(&device.label, &whole, &mut Coverage::default()))
}

/// Estimates, u, U, rank and global test agree to 1e-12 with the fits of the devices one by one: 1000 random campaigns of 6 devices.
///
/// The allowance is that of `rows_are_those_of_single_fits`: where readings are large against their residuals, their own rounding counts. A
/// triangle cannot be refined with rows that are gone: unknowns that only a prior of u = 0.5 tells apart beside readings of u = 1e-3 (condition
/// 1e3) lose those digits, the more the worse the readings fit.
#[test]
fn parts_are_the_whole() {
    let mut draws = Draws(0x0bad_cafe_1234_5677_u128 << 1 | 1);
    let (mut worst, mut devices_seen, mut malformed, mut defective, mut harder) = ([0.0_f64; 2], 0, 0, 0, 0);
    for case in 0..1000 {
        let table = table(&mut draws);
        let (template, layout, list) = devices(&table);
        let step = Parts::new(&template, &Settings::default()).expect("a linear model");
        let how = [(1, 1000), (1, 7), (2, 5), (4, 1000), (3, 1)][case % 5];
        for device in &list {
            let row = in_parts(&step, &layout, device, how, &mut draws);
            let Some(fit) = single(&table, &device.label) else {
                malformed += 1;
                assert!(row.map_or(true, |row| row.verdict == Verdict::Malformed), "case {case}");
                continue;
            };
            let (row, single) = (row.expect("a row"), Row::of(device, &fit));
            devices_seen += 1;
            defective += usize::from(single.rank < template.unknowns());
            // lack of fit and a stuck channel are not to be had from parts
            let told = single.reasons.iter().any(|own| matches!(own.name(), "global-test" | "not-estimable"));
            let verdict = if told { Verdict::Rejected } else { Verdict::Accepted };
            let about = || format!("case {case}, {how:?}: {row:?} {single:?}");
            assert_eq!(
                (row.verdict, row.conformity, row.readings, row.rank, row.dof),
                (verdict, single.conformity, single.readings, single.rank, single.dof),
                "{}",
                about()
            );
            let largest = table
                .rows
                .iter()
                .filter(|own| own["serial"] == *row.label)
                .flat_map(|own| {
                    ["a", "b"].map(|name| own.get(name).and_then(serde_json::Value::as_f64).unwrap_or(0.0).abs())
                })
                .fold(0.0, f64::max);
            let scatter = single.residual_sd * if single.chi_square_p.is_nan() { 1.0 } else { 1e-3 };
            let near = (64.0 * f64::EPSILON * largest / scatter).max(1e-12);
            let near = if near.is_nan() { 1e-12 } else { near }.max(if table.large { 2e-9 } else { 0.0 });
            // as there: the scale of the noise beside these is the top of a likelihood
            let inputs = is_uncertain(&table);
            // noise that it draws to zero is below a thousandth of u, wherever the walk ends: half a millionth of u, by squares; its own size and degrees of freedom are nobody's
            let is_nothing = |own: &Row| own.type_a.iter().zip(&own.u).all(|(a, u)| *a < 1e-3 * u);
            let nothing = inputs && is_nothing(&row) && is_nothing(&single);
            let near = if inputs { near.max(if nothing { 1e-6 } else { 1e-9 }) } else { near };
            let misfit = if single.chi_square_p.is_nan() { 1.0 } else { single.residual_sd.max(1.0) };
            let hard = 4.0 * f64::EPSILON * fit.estimate.unknowns.condition().unwrap_or(1.0) * misfit;
            harder += usize::from(hard > near);
            let near = near.max(hard);
            let size = |x: f64| if x.is_nan() { 0.0 } else { x.abs() };
            for k in 0..row.value.len() {
                for (a, b, scale) in [
                    (row.value[k], single.value[k], size(single.value[k]).max(size(single.u[k]))),
                    (row.u[k], single.u[k], size(single.u[k])),
                    (
                        row.expanded[k],
                        if nothing { row.expanded[k] } else { single.expanded[k] },
                        size(single.expanded[k]),
                    ),
                    (row.type_a[k], if nothing { row.type_a[k] } else { single.type_a[k] }, size(single.u[k])),
                ] {
                    assert_eq!(a.is_nan(), b.is_nan(), "{}", about());
                    if scale > 0.0 {
                        if hard < 1e-12 && !inputs {
                            let own = &mut worst[usize::from(table.large)];
                            *own = own.max((a - b).abs() / scale);
                        }
                        assert!((a - b).abs() <= near * scale, "quantity {k}: {a:e} for {b:e}; {}", about());
                    }
                }
            }
            let both = (row.residual_sd, single.residual_sd);
            assert!((both.0 - both.1).abs() <= near * both.1 || both.0.is_nan() && both.1.is_nan(), "{}", about());
            let both = (row.chi_square_p, single.chi_square_p);
            assert!((both.0 - both.1).abs() <= 1e3 * near || both.0.is_nan() && both.1.is_nan(), "{}", about());
        }
    }
    println!(
        "1000 campaigns: {devices_seen} devices, {defective} with a rank defect, {malformed} malformed, {harder} too badly conditioned for 1e-12; the worst number off by {:.1e} relative ({:.1e} where readings are ten million times their noise) but for those",
        worst[0], worst[1]
    );
    assert!(10 * harder < devices_seen && devices_seen > 4000 && defective > 50 && malformed > 50);
}

/// What one step without the readings cannot do is refused with what does it.
#[test]
fn what_needs_all_readings_is_refused() {
    let parts = |change: &dyn Fn(&mut serde_json::Value), settings: &Settings| {
        let mut file = json!({ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } }, "estimate": { "a": {}, "b": {} }, "readings": [] });
        change(&mut file);
        let file: CampaignFile = serde_json::from_value(file).expect("a campaign");
        let bench = file.resolved_bench(&mut |_| panic!()).expect("a bench");
        let readings = Readings { columns: vec!["x".into()], rows: Vec::new() };
        Parts::new(&file.with(bench, readings).expect("a campaign"), settings).map_err(|error| error.to_string())
    };
    let plain = Settings::default();
    assert!(parts(&|_| {}, &plain).is_ok());
    let exponential = |file: &mut serde_json::Value| file["bench"]["sensors"]["y"]["model"] = json!("a*exp(b*x)");
    let refused = parts(&exponential, &plain).expect_err("not linear");
    assert!(refused.contains("not linear") && refused.contains("--by"), "{refused}");
    assert!(parts(&exponential, &Settings { estimator: Estimator::Linear, ..plain }).is_ok());
    let refused = parts(&|file| file["constraints"] = json!([{ "of": { "a": 1 }, "between": [0, 1] }]), &plain);
    assert!(refused.expect_err("constraints").contains("constraints"));
    let refused = parts(&|file| file["scatter"] = json!([{ "of": "y", "per": "reading", "u": 1.0 }]), &plain);
    assert!(refused.expect_err("scatter").contains("scatters"));
    assert!(parts(&|_| {}, &Settings { level: 1.0, ..plain }).expect_err("a level").contains("level"));
}

/// Scales that are estimated, and states from elsewhere.
#[test]
fn what_no_part_can_say_is_a_row() {
    let reading = |values: serde_json::Value| values.as_object().expect("an object").clone();
    let one = |values: &[serde_json::Value]| {
        let sensors = json!({ "y": { "model": "a + b*x" }, "z": { "model": "a - b*x" } });
        let file =
            json!({ "bench": { "id": "lines", "sensors": sensors }, "estimate": { "a": {}, "b": {} }, "readings": [] });
        let table = Table { file, rows: values.iter().cloned().map(reading).collect(), large: false };
        let (template, layout, list) = devices(&table);
        let step = Parts::new(&template, &Settings::default()).expect("a linear model");
        let row = in_parts(&step, &layout, &list[0], (1, 100), &mut Draws(7)).expect("a row");
        assert!(step.unpack(&[]).is_err() && step.unpack(&[0.0; 9]).is_err() && step.unpack(&[f64::NAN; 14]).is_err());
        row
    };
    let row =
        one(&[json!({ "serial": "A", "x": 0, "y": 1, "z": 2 }), json!({ "serial": "A", "x": 1, "y": 1, "z": 2 })]);
    assert!(row.verdict == Verdict::Malformed && row.why.contains("several sensors"), "{}", row.why);
    let row = one(&[json!({ "serial": "A", "x": 0, "y": 1, "y_u": 1 }), json!({ "serial": "A", "x": 1, "y": 1 })]);
    assert!(row.verdict == Verdict::Malformed && row.why.contains("some have none"), "{}", row.why);
    let row = one(&[json!({ "serial": "A", "x": 0, "y": 1 }), json!({ "serial": "A", "x": 1, "y": 3 })]);
    assert_eq!((row.verdict, row.dof, row.u[0].is_nan()), (Verdict::Accepted, 0, true));
    assert!((row.value[1] - 2.0).abs() < 1e-15);
}
