//! Scatter lines in campaigns: what is refused and where, what shorthands mean, what the report says.

use crate::support::{ARCSEC, assert_within, fit_with, fitted, parse, uncertainty, value};
use tumble::campaign::Campaign;
use tumble::document::{Detail, terminal};
use tumble::estimate::LineState;
use tumble::fit::{self, Remount, Settings, Stop};
use tumble::language::Language;
use tumble::{report, simulate, wire};

/// An accelerometer on a head, read twice at each of eight positions on two days.
fn head(scatter: &str, extra: &str) -> String {
    let readings: Vec<String> = (0..16)
        .map(|k| {
            let (position, angle) = (k / 2, 45 * (k / 2));
            let wiggle = ((k * 7 + 3) % 5) as f64 - 2.0 + ((position * 5 + 1) % 7) as f64 - 3.0;
            let v = 2e-3 + 1.3 * (angle as f64).to_radians().cos() + 1e-5 * wiggle;
            format!(
                r#"{{"position": "p{position}", "day": {}, "who": "{}", "time_s": {k}, "same": 1, "head_deg": {angle}, "V": {v}, "V_u": 1e-5{extra}}}"#,
                k / 8,
                if k % 3 == 0 { "A" } else { "B" }
            )
        })
        .collect();
    format!(
        r#"{{"bench": {{"id": "head", "chain": [{{"joint": "head", "about": "x"}}, {{"tilt": "seat", "about": "x"}}],
            "sensors": {{"V": {{"unit": "V", "axes": {{"I": "z"}}, "model": "b0 + kI*a_I"}}}}}},
            "estimate": {{"b0": {{}}, "kI": {{"start": 1.3}}}}, "scatter": [{scatter}], "readings": [{}]}}"#,
        readings.join(",")
    )
}

fn refused(scatter: &str) -> (String, String) {
    let source = wire::Source { name: "head".into(), text: head(scatter, "") };
    let error = wire::read_campaign(&source, &mut |_| unreachable!()).expect_err(scatter);
    (error.place().path.clone(), error.to_string())
}

/// Each mistake has its sentence and its place.
#[test]
fn scatter_lines_that_say_nothing_are_refused() {
    let line = r#"{"of": "head", "per": "position", "u": 5, "unit": "arcsec"}"#;
    for (scatter, path, words) in [
        (r#"{"of": [], "per": "reading", "u": 1}"#, "scatter[0].of", "scatter line of nothing"),
        (
            r#"{"of": "tail", "per": "reading", "u": 1}"#,
            "scatter[0].of",
            "'tail' is not a sensor, joint, tilt or coefficient",
        ),
        (r#"{"of": "V", "u": 1}"#, "scatter[0]", "when it takes a new value is not stated"),
        (r#"{"of": "V", "per": "position"}"#, "scatter[0].u", "the size of the deviations is not stated"),
        (r#"{"of": "V", "per": "position", "u": 0}"#, "scatter[0].u", "without a positive standard deviation"),
        (r#"{"of": "V", "per": "position", "u": -1e-3}"#, "scatter[0].u", "without a positive standard deviation"),
        (r#"{"of": "head", "per": "position", "u": 5}"#, "scatter[0].u", "is an angle, and its u has no unit"),
        (r#"{"of": "head", "per": "position", "u": 5, "unit": "mV"}"#, "scatter[0].unit", "head"),
        (r#"{"of": "V", "per": "week", "u": 1}"#, "scatter[0].per", "the readings have no column 'week'"),
        (r#"{"of": "V", "per": "same", "u": 1}"#, "scatter[0].per", "same is the same in all readings"),
        (r#"{"of": "V", "per": "time_s", "u": 1}"#, "scatter[0].per", "time_s is different in every reading"),
        (
            r#"{"of": "V", "tau": 30, "per": "reading", "u": 1}"#,
            "scatter[0].tau",
            "a correlation time without an order",
        ),
        (
            r#"{"of": "V", "over": "time_s", "u": 1}"#,
            "scatter[0].over",
            "the correlation time of the noise is not stated",
        ),
        (r#"{"of": "V", "over": "time_s", "tau": 0, "u": 1}"#, "scatter[0].tau", "correlation time is not positive"),
        (r#"{"of": "V", "over": "clock", "tau": 3, "u": 1}"#, "scatter[0].over", "no column 'clock'"),
        (r#"{"of": "V", "per": "position", "u": 1, "dof": 0}"#, "scatter[0].dof", "degrees of freedom"),
        (
            r#"{"of": ["V"], "per": "reading", "correlation": 0.3}"#,
            "scatter[0].correlation",
            "not a correlation of sensors",
        ),
        (&format!("{line}, {line}"), "scatter[1]", "scatters twice"),
    ] {
        let (found, text) = refused(scatter);
        assert_eq!(found, path, "{scatter}: {text}");
        assert!(text.contains(words), "{scatter}: {text}");
    }
}

fn campaign(scatter: &str, extra: &str) -> Campaign {
    parse(&head(scatter, extra))
}

/// `<joint>_u` beside `<joint>_deg` is a line per position; a `per` column may be a text.
#[test]
fn shorthands_are_the_lines_that_they_stand_for() {
    let long = fitted(&campaign(r#"{"of": "head", "per": "position", "u": 5, "unit": "arcsec"}"#, ""));
    let short = fitted(&campaign("", &format!(r#", "head_u": {}"#, 5.0 / 3600.0)));
    for id in ["b0", "kI"] {
        assert_within(value(&short, id), value(&long, id), 1e-15, id);
        assert_within(uncertainty(&short, id), uncertainty(&long, id), 1e-12 * uncertainty(&long, id), id);
    }
    assert_eq!(short.noise.sources[1].name, "head per position");
    let remount = fit_with(&campaign("", ""), Settings { remount: Remount::Stated(3e-5), ..Settings::default() });
    let line = fitted(&campaign(r#"{"of": "V", "per": "position", "u": 3e-5, "unit": "V"}"#, ""));
    assert_within(value(&remount, "kI"), value(&line, "kI"), 1e-15, "kI");
    assert_within(uncertainty(&remount, "kI"), uncertainty(&line, "kI"), 1e-15, "u");
    let who = campaign(r#"{"of": "b0", "per": "who", "u": 1e-5}"#, "");
    assert_eq!(fitted(&who).noise.sources[1].levels, 2);
}

/// A tilt that the bench has and nobody asks for deviates all the same; every line is a source of every budget.
#[test]
fn every_line_is_a_source_of_the_budget() {
    let lines = r#"{"of": "seat", "per": "position", "u": 4, "unit": "arcsec", "dof": 8},
        {"of": "b0", "per": "day", "u": 2e-5}, {"of": "kI", "per": "campaign", "u": 1e-4}"#;
    let fit = fitted(&campaign(lines, ""));
    let report = report::fit_report(&fit);
    let names: Vec<&str> = report.scatter.iter().map(|s| s.source.as_str()).collect();
    assert_eq!(names, ["readings of V", "seat per position", "b0 per day", "kI per campaign"]);
    let seat = &report.scatter[1];
    assert_eq!((seat.levels, seat.unit.as_str(), seat.from.name(), seat.dof), (8, "arcsec", "stated", Some(8.0)));
    assert_within(seat.sd.unwrap(), 4.0, 1e-12, "sd");
    for p in &report.parameters {
        let total: f64 = p.budget.iter().map(|line| line.of.u * line.of.u).sum();
        assert_within(total.sqrt(), p.combined.u.unwrap(), 1e-12 * p.combined.u.unwrap(), &p.id);
        assert!(
            p.budget.iter().all(|line| (line.of.evaluation.name() == "B") == (line.of.source != "readings of V")),
            "{:?}",
            p.budget
        );
    }
    // kI deviates once in the campaign: its own uncertainty cannot be less
    let own = report.parameters[1].budget.iter().find(|line| line.of.source == "kI per campaign").unwrap();
    assert_within(own.of.u, 1e-4, 1e-12, "kI per campaign");
    assert_within(ARCSEC * 4.0, fit.noise.sources[1].variance.sqrt(), 1e-18, "radians inside");
}

/// One reading a position: the sum of offsets and noise stays, and the report says why there is one number.
#[test]
fn what_one_reading_a_position_cannot_tell_is_said() {
    let mut single = campaign(r#"{"of": "V", "per": "position", "u": "estimate"}"#, "");
    single.readings.rows = single.readings.rows.into_iter().step_by(2).collect();
    for reading in &mut single.readings.rows {
        reading.observations[0].u = None;
    }
    let fit = fitted(&single);
    let plain = fitted(&Campaign { scatter: Vec::new(), ..single.clone() });
    assert_eq!(fit.noise.sources[1].state, LineState::Inseparable);
    assert_within(uncertainty(&fit, "kI"), uncertainty(&plain, "kI"), 1e-9 * uncertainty(&plain, "kI"), "the sum");
    let table = tumble::document::terminal::brief(&tumble::report::fit_document(
        &report::fit_report(&fit),
        &Default::default(),
        tumble::language::Language::English,
    ));
    assert!(table.contains("V per position: these readings cannot distinguish it from readings of V"), "{table}");
}

/// What `simulate` draws is what `fit` finds.
#[test]
fn simulated_deviations_come_back() {
    let lines = r#"{"of": "head", "per": "position", "u": "estimate", "unit": "arcsec"}, {"of": "V", "over": "time_s", "tau": 4, "u": 1e-4}"#;
    let schedule = campaign(lines, "");
    let truth = |text: &str| wire::read_truth(&wire::Source { name: "truth".into(), text: text.into() }, &schedule);
    let sizes =
        r#"{"values": {"b0": {"value": 0.002}, "kI": {"value": 1.3}}, "scatter": {"head per position": {"sd": 40}}}"#;
    let drawn = truth(sizes).unwrap();
    let mut sum = 0.0;
    for seed in 0..40 {
        let campaign = simulate::simulate(&schedule, &drawn, seed).unwrap();
        for reading in &campaign.readings.rows {
            let exact = 2e-3
                + 1.3
                    * (reading.columns.iter().flatten().next().map_or(0.0, |_| 0.0)
                        + reading.joints[0].keys().0.unwrap().to_radians().cos());
            sum += (reading.observations[0].value - exact).powi(2);
        }
    }
    // half of the 40 arcsec at a mean square of sin 1/2, and the samples: 1e-8 + (1.3 x 1.94e-4)^2 / 2
    let expected = 1e-8 + 0.5 * (1.3 * 40.0 * ARCSEC).powi(2);
    let found = sum / (40.0 * 16.0);
    assert!((found / expected - 1.0).abs() < 0.25, "{found:e} {expected:e}");
    let missing = simulate::simulate(&schedule, &truth(r#"{"values": {}}"#).unwrap(), 1).unwrap_err();
    assert!(missing.to_string().contains("head per position"), "{missing}");
    assert!(truth(r#"{"scatter": {"tail": {"sd": 1}}}"#).is_err());
    let written = serde_json::to_string(&wire::campaign_file(&schedule, wire::BenchRef::Named("x".into()))).unwrap();
    assert!(written.contains(r#""scatter":[{"of":"head","per":"position","u":"estimate","unit":"arcsec"},{"of":"V","u":0.0001,"unit":"V","over":"time_s","tau":4.0}]"#), "{written}");
}

/// A robust weight is of one reading, a deviation of several: refused with the reason.
#[test]
fn robust_beside_scatter_is_refused() {
    let campaign = campaign(r#"{"of": "V", "per": "position", "u": 3e-5}"#, "");
    let settings = Settings { robust: Some(fit::RobustMethod::Huber), ..Settings::default() };
    assert!(fit::fit(&campaign, &settings).unwrap_err().to_string().contains("random effects of several readings"));
}

/// An offset per position that is estimated as zero is not known to be zero: `u` is that of the positions' own mean square, with its degrees of
/// freedom, and the budget adds up to it.
#[test]
fn a_line_at_zero_keeps_its_degrees_of_freedom() {
    let offsets = [0.1, -0.3, 0.2, -0.1, 0.25, 0.05, -0.2, 0.0];
    let cosine = |position: usize| (45.0 * position as f64).to_radians().cos();
    let mut own = campaign(r#"{"of": "V", "per": "position", "u": "estimate"}"#, "");
    for (k, reading) in own.readings.rows.iter_mut().enumerate() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        reading.observations[0].u = None;
        reading.observations[0].value = 2e-3 + 1.3 * cosine(k / 2) + 1e-5 * (offsets[k / 2] + sign);
    }
    // means of two readings each, less their line in 1 and the cosine (orthogonal, squares 8 and 4): six degrees of freedom
    let mean = offsets.iter().sum::<f64>() / 8.0;
    let slope = (0..8).map(|p| offsets[p] * cosine(p)).sum::<f64>() / 4.0;
    let left: f64 = (0..8).map(|p| (offsets[p] - mean - slope * cosine(p)).powi(2)).sum();
    let fit = fitted(&own);
    assert_eq!(fit.noise.sources[1].state, LineState::AtZero);
    let report = report::fit_report(&fit);
    for (p, squares) in report.parameters.iter().zip([8.0, 4.0]) {
        let expected = 1e-5 * (left / 6.0 / squares).sqrt();
        let u = p.combined.u.unwrap();
        assert_within(u, expected, 1e-6 * expected, &p.id);
        assert_within(p.combined.dof.unwrap(), 6.0, 1e-4, &p.id);
        let total: f64 = p.budget.iter().map(|line| line.of.u * line.of.u).sum();
        assert_within(total.sqrt(), u, 1e-9 * u, &p.id);
    }
    assert!(report.scatter[1].at_zero && report.scatter[1].sd == Some(0.0));
    assert!(fit::draw(&fit, 2000, 1, &|_| {}).unwrap().is_some());
}

/// A known input with an uncertainty is a deviation that the whole campaign shares, and stands beside the lines.
#[test]
fn known_inputs_stand_with_what_scatters() {
    let text = head(r#"{"of": "V", "per": "position", "u": 3e-5}"#, "")
        .replace(r#""kI": {"start": 1.3}}"#, r#"}, "known": {"kI": {"value": 1.3, "u": 2e-5, "dof": 9}}"#)
        .replace(r#""b0": {}, }"#, r#""b0": {}}"#);
    let report = report::fit_report(&fitted(&parse(&text)));
    let own = report.scatter.iter().find(|s| s.source == "kI").expect("kI");
    assert_eq!((own.per.as_str(), own.levels, own.sd, own.dof), ("campaign", 1, Some(2e-5), Some(9.0)));
    let share: f64 = report.scatter.iter().map(|s| s.share["b0"]).sum();
    assert_within(share, 1.0, 1e-12, "shares of b0");
}

/// A correlation time that 120 readings hardly tell: by Satterthwaite the offset has 0.4 degrees of freedom, and U would be 0.016 g for readings that
/// scatter by some 1e-5 g. The interval is of the error's size, its budget adds up, and the report says how it came about.
#[test]
fn a_correlation_time_that_is_hardly_known_leaves_intervals_of_the_size_of_the_errors() {
    let campaign = crate::support::campaign("scatter/ou_dof01.json");
    let fit = fitted(&campaign);
    let mut plain = campaign;
    plain.scatter.clear();
    let sd = fitted(&plain).estimate.residual_sd().unwrap();
    println!(
        "residual standard deviation {sd}, U {:?}",
        fit.parameters.iter().map(|p| p.uncertainty.unwrap().expanded).collect::<Vec<_>>()
    );
    for own in &fit.parameters {
        let uncertainty = own.uncertainty.unwrap();
        // whatever is correlated, it is not known worse than one reading with one degree of freedom
        assert!(uncertainty.dof >= 1.0 && uncertainty.expanded < 12.8 * sd, "{}: {uncertainty:?}", own.id);
        let sum: f64 = own.budget.iter().map(|line| line.u * line.u).sum();
        assert_within(sum.sqrt() / uncertainty.u, 1.0, 1e-9, &own.id);
    }
    assert!(fit.noise.is_summed());
}

/// Where the top of the likelihood says nothing, intervals are those of the whole of it: `tests/scripts/summed_likelihood.py`. The program's 60 nodes
/// and its reach leave some 5e-4.
#[test]
fn intervals_over_the_whole_likelihood_are_those_of_a_dense_quadrature() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scatter/summed.json"));
    let cases: Vec<serde_json::Value> = serde_json::from_str(&text.unwrap()).unwrap();
    assert_eq!(cases.len(), 11);
    for case in &cases {
        let is_line = case["estimate"].as_array().unwrap().len() == 2;
        let (model, unknowns) = if is_line { ("a + s*x", r#""a": {}, "s": {}"#) } else { ("a", r#""a": {}"#) };
        let fit = fitted(&parse(&format!(
            r#"{{"bench": {{"id": "m", "sensors": {{"V": {{"unit": "V", "model": "{model}"}}}}}}, "estimate": {{{unknowns}}},
                "scatter": [{{"of": "V", "per": "position", "u": "estimate"}}], "readings": {}}}"#,
            case["readings"]
        )));
        assert!(fit.noise.is_summed(), "{}", case["repeats"]);
        for (k, own) in fit.parameters.iter().enumerate() {
            let half = case["U"][k].as_f64().unwrap();
            let name = format!("{} of {}", own.id, case["repeats"]);
            assert_within(own.value.unwrap(), case["estimate"][k].as_f64().unwrap(), 1e-4 * half, &name);
            assert_within(own.uncertainty.unwrap().expanded / half, 1.0, 1e-3, &name);
        }
    }
}

/// The residual standard deviation that is told is then that of rounding, 0.1/sqrt 12, beyond a line that holds what the readings scatter: of these nine
/// 0.35, of the line as stated 1.
#[test]
fn rounding_is_told_of_what_is_beyond_the_lines() {
    let values = [0.0, 0.2, -0.3, 0.5, -0.1, 0.4, -0.6, 0.3, 0.1];
    let rows: Vec<String> = values.iter().map(|y| format!(r#"{{"y": {y}}}"#)).collect();
    let said = |line: &str| {
        let fit = fitted(&parse(&format!(
            r#"{{"bench": {{"id": "z", "sensors": {{"y": {{"model": "a"}}}}}}, "estimate": {{"a": {{}}}},
                "scatter": [{line}], "readings": [{}]}}"#,
            rows.join(",")
        )));
        let asked = report::Asked { fit: Some(&fit), ..Default::default() };
        let document = report::fit_document(&report::fit_report(&fit), &asked, Language::English);
        terminal::render(&document, Detail::Full).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let with = said(r#"{"of": "y", "per": "reading", "u": 1}"#);
    let beyond = "beyond the lines of scatter, the variance of the readings is estimated as zero";
    assert!(with.contains("from rounding to 0.1") && with.contains(beyond), "{with}");
    assert!(!with.contains("do not scatter more"), "{with}");
    assert!(!said("").contains("rounding to 0.1"));
}

/// Steps settle at K22 = -110, though at the reference point, where K22 is the value that the readings were drawn with, they are far more likely.
#[test]
fn a_solution_less_likely_than_the_reference_is_no_convergence() {
    let fit = fitted(&crate::support::campaign("scatter/settles_far_away.campaign.json"));
    let record = fit.convergence.as_ref().unwrap();
    assert!(!record.converged && record.stop == Stop::LessLikely, "{:?}", record.stop);
    assert!(fit.is_rejected());
}
