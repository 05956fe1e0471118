//! The document of a fit: the answer first, then where it comes from, then what it rests on.

use super::checks::{ConstraintsStatus, MonteCarloReport, RecordReport, f_test};
use super::correction::{correction_lines, given_sentence, validity_sentence};
use super::fit::{Shown, interval_note};
use super::fit_figures::{FAR, budget_figures, estimate_figures, residual_figures, spread_figures};
use super::provenance::begin;
use super::scene::scene_figure;
use super::{BudgetReport, CompareReport, FitReport, Input, ReadingReport, compare, conformity, finite, scatter, site};
use crate::campaign::{Campaign, JointState, Kind};
use crate::correction::Mounting;
use crate::document::number::{level, rounded, significant};
use crate::document::{Cell, Content, Detail, Document, Figure, Rows, Section, Tone};
use crate::fit::{Estimator, Fit, State, VarianceFrom};
use crate::language::{Language, code, say};
use crate::wire::CorrectionFile;
use std::collections::BTreeMap;

/// What else the document of a fit is made from, and what a reader of a terminal asked to see.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked<'a> {
    /// The fit itself, which knows the bench's words and the joints of each reading.
    pub fit: Option<&'a Fit>,
    /// The published closed forms beside it, where the bench has them.
    pub comparison: Option<&'a CompareReport>,
    /// Files that the fit was made from.
    pub inputs: &'a [Input],
    /// Each reading (`--readings`).
    pub readings: bool,
    /// The budget of each quantity and the correlations (`--budget`).
    pub budget: bool,
    /// The correction to apply (`--correction`).
    pub correction: bool,
}

/// The document of a fit.
pub fn fit_document(report: &FitReport, asked: &Asked<'_>, lang: Language) -> Document {
    let title = asked.fit.map(|fit| fit.campaign.bench.title.as_str()).filter(|title| !title.is_empty());
    let document = begin(title.map_or(report.bench.clone(), |title| lang.name(title).into_owned()), asked.inputs, lang)
        .facts(report.identity.facts(lang))
        .fact(say!(lang, "bench"), code(&report.bench))
        .facts(model_facts(&report.model, lang))
        .section(result(report, lang))
        .section(estimates(report, asked.fit, lang))
        .section(free(report, lang))
        .section(conformity::section(report.conformity.as_ref(), lang))
        .section(monte_carlo(report, lang))
        .section(scatter::section(&report.scatter, lang))
        .section(conditions(report, lang))
        .section(correction(report, asked.correction, lang))
        .section(budget(report, asked.budget, lang))
        .section(Section::new(say!(lang, "residuals-and-correlations")).full().figures(spread_figures(report, lang)))
        .section(checks(report, lang))
        .section(iterations(report, lang));
    let document = match asked.comparison {
        Some(comparison) => document.section(compare::section(comparison, lang)),
        None => document,
    };
    document.section(assumptions(report, asked, lang)).section(readings(report, asked.fit, asked.readings, lang))
}

pub(super) fn model_facts(model: &BTreeMap<String, String>, lang: Language) -> impl Iterator<Item = (String, String)> {
    let name = move |k| if k == 0 { say!(lang, "model").into() } else { String::new() };
    model.iter().enumerate().map(move |(k, (sensor, line))| (name(k), format!("`{sensor} = {line}`")))
}

fn result(report: &FitReport, lang: Language) -> Section {
    let conforms = report.conformity.as_ref().map(|judged| conformity::verdict(judged, lang));
    let next = lang.sentence(say!(lang, "diagnose-says-what-is-missing"));
    Section::new(say!(lang, "result"))
        .verdicts(conforms)
        .verdicts(verdicts(report, lang))
        .verdicts(report.is_misfit().then_some((Tone::Plain, next)))
}

/// What a reader of the estimates must know of the fit, in a report and in a certificate: what is not determined, the tests, the remarks, how it converged.
pub(super) fn verdicts(report: &FitReport, lang: Language) -> Vec<(Tone, String)> {
    let fit = &report.fit;
    let mut said = Vec::new();
    said.extend(not_estimable(report, lang).map(|text| (Tone::Bad, text)));
    for source in report.scatter.iter().filter(|source| !source.without_u.is_empty()) {
        let note = source.note.as_ref().map_or(String::new(), |note| note.say(lang).to_string());
        let source = scatter::source_name(&source.source, lang);
        said.push((Tone::Bad, say!(lang, "source-note-sentence", source, note)));
    }
    said.extend(global_test(report, lang));
    said.extend(checked(report, lang));
    if let Some(constraints) = &report.constraints {
        let tone = if constraints.status == ConstraintsStatus::Met { Tone::Plain } else { Tone::Bad };
        said.push((tone, lang.sentence(&constraints.verdict.say(lang))));
    }
    if let Some(robust) = report.robust.as_ref().filter(|robust| !robust.converged) {
        said.push((Tone::Bad, say!(lang, "the-robust-estimator-did-not-settle", method = robust.method.to_string())));
    }
    for circle in &fit.inconsistent_circles {
        let mean_residual_deg = significant(circle.mean_residual_deg, 4);
        let text =
            say!(lang, "inconsistent-disagrees-with-the-other-sights-by", sensor = circle.sensor, mean_residual_deg);
        said.push((Tone::Bad, text));
    }
    let remarks = fit.remarks.iter().chain(&report.site.warnings);
    said.extend(remarks.map(|remark| (Tone::Caution, lang.sentence(&remark.say(lang)))));
    said.extend(convergence(report, lang));
    for condition in &report.conditional {
        let by = format!("{} {}", significant(condition.by, 3), condition.unit);
        let shifts = in_u(&condition.shifts, lang);
        let text = say!(lang, "u-holds-only-for-as-held-another", held = condition.held, by = by.trim_end(), shifts);
        said.push((Tone::Caution, text));
    }
    said
}

/// Changes of parameters in their standard uncertainties.
fn in_u(changes: &BTreeMap<String, f64>, lang: Language) -> String {
    let one = |(id, u): (&String, &f64)| format!("`{id}` {} u", significant(*u, 2));
    changes.iter().map(one).collect::<Vec<_>>().join(lang.comma())
}

/// Readings whose sum of squares is exceeded with this probability scatter less than is stated of them: once in a thousand right statements.
const TOO_LITTLE: f64 = 0.999;

fn global_test(report: &FitReport, lang: Language) -> Option<(Tone, String)> {
    let fit = &report.fit;
    match (fit.chi_square, fit.p) {
        (Some(chi_square), Some(p)) => {
            let (tone, rejected) = match fit.global_test_rejected {
                Some(true) => (Tone::Bad, "yes"),
                _ if p > TOO_LITTLE => (Tone::Caution, "less"),
                _ => (Tone::Good, "no"),
            };
            let [chi_square, p] = [significant(chi_square, 4), significant(p, 3)];
            let dof = lang.count(fit.dof, "degree");
            Some((tone, say!(lang, "global-test-chi-square-with-p", rejected, chi_square, dof, p)))
        }
        _ if fit.dof == 0 => Some((Tone::Caution, say!(lang, "no-degrees-of-freedom-the-readings-just").into())),
        _ if fit.variance == VarianceFrom::Estimated && report.checks.misfit().is_none() => {
            Some((Tone::Plain, say!(lang, "the-readings-state-no-uncertainty-of-their").into()))
        }
        _ => None,
    }
}

/// What the checks found.
fn checked(report: &FitReport, lang: Language) -> Vec<(Tone, String)> {
    let tests = [&report.checks.lack_of_fit, &report.checks.lack_of_fit_by_position].into_iter().flatten();
    let tones = tests.map(|test| match (test.rejected, test.is_beyond_doubt()) {
        (true, true) => Tone::Bad,
        (true, false) => Tone::Caution,
        (false, _) if test.is_below_scatter() => Tone::Caution,
        (false, _) => Tone::Good,
    });
    // of a record the sentences say what is in order, too
    let further = if report.record.is_some() { Tone::Plain } else { Tone::Caution };
    let lines = report.checks.verdict.iter().map(|line| lang.sentence(&line.say(lang)));
    tones.chain(std::iter::repeat(further)).zip(lines).collect()
}

/// How far the estimator went, and what it changed.
fn convergence(report: &FitReport, lang: Language) -> Vec<(Tone, String)> {
    let what = in_u(&report.nonlinear, lang);
    let Some(record) = &report.convergence else {
        let said = (!what.is_empty()).then(|| (Tone::Caution, say!(lang, "one-linear-step-is-not-enough-gauss", what)));
        return said.into_iter().collect();
    };
    let steps = lang.count(record.iterations.len(), "iteration");
    let mut said = vec![match record.converged {
        false => (Tone::Bad, say!(lang, "gauss-newton-did-not-converge-after", steps, stop = record.stop.said())),
        true => (Tone::Good, say!(lang, "gauss-newton-converged-after", differs = !what.is_empty(), steps, what)),
    }];
    if !record.moved.is_empty() {
        let moved = lang.names(&record.moved);
        said.push((Tone::Plain, say!(lang, "no-reading-responds-to-at-the-reference", moved)));
    }
    if !record.held.is_empty() {
        let held = lang.names(&record.held);
        said.push((Tone::Plain, say!(lang, "held-where-the-iteration-began-since-the", held)));
    }
    said
}

/// What is not estimable, in a sentence.
fn not_estimable(report: &FitReport, lang: Language) -> Option<String> {
    let what = say!(lang, "not-estimable-from-these-readings");
    let names = lang.names(report.not_estimable.iter().map(|defect| &defect.text));
    (!report.not_estimable.is_empty()).then(|| lang.sentence(&format!("{what}{}{names}", lang.colon())))
}

/// How many readings gave how many parameters.
pub(super) fn estimated(report: &FitReport, lang: Language) -> String {
    let sums = &report.fit;
    let readings = lang.count(sums.readings, "reading");
    let priors = (sums.priors > 0).then(|| lang.count(sums.priors, "prior"));
    say!(
        lang,
        "from-the-fit-estimates-rank-of-freedom",
        from = lang.list(&[vec![readings], priors.into_iter().collect()].concat()),
        parameters = lang.count(report.parameters.len(), "parameter"),
        rank = sums.rank.to_string(),
        dof = lang.count(sums.dof, "degree")
    )
}

fn summary(report: &FitReport, of: Option<&Fit>, lang: Language) -> String {
    let sums = &report.fit;
    let mut said = vec![estimated(report, lang)];
    // lines of scatter hold what the readings scatter
    let beyond = of.is_some_and(|fit| !fit.campaign.scatter.is_empty());
    for (sensor, sd) in &sums.sensor_sd {
        // sensors of a report are those of its bench
        let unit = of.and_then(|fit| fit.campaign.bench.sensors.iter().find(|s| s.id == *sensor));
        let size = sd.map(|sd| format!("{} {}", significant(sd, 3), unit.map_or("", |s| s.unit.as_str())));
        let at_zero = report.scatter.iter().any(|s| s.at_zero && s.per == "reading" && s.of == *sensor);
        let size = size.filter(|_| !at_zero);
        let how = match (sd, sums.resolution.get(sensor)) {
            _ if at_zero => Some(say!(lang, "estimated-as-zero", below = false)),
            (None, _) => Some(say!(lang, "no-degrees-of-freedom-are-left-to").into()),
            (_, Some(step)) => {
                Some(say!(lang, "that-of-rounding-to-its-last-digit", step = significant(*step, 1), beyond))
            }
            _ if sums.at_rounding.contains(sensor) => {
                Some(say!(lang, "the-rounding-of-its-readings-which-show", beyond))
            }
            _ => None,
        };
        let said_of = [size.map(|size| size.trim_end().to_string()), how].into_iter().flatten().collect::<Vec<_>>();
        let per_sample = of.is_some_and(|fit| fit.campaign.readings.rows.iter().any(|row| row.samples != 1.0));
        said.push(say!(lang, "residual-sd-of", sensor, sd = said_of.join(lang.clause()), per_sample));
    }
    if let Some(condition) = sums.condition {
        said.push(say!(lang, "the-scaled-design-matrix-has-condition-number", condition = significant(condition, 3)));
    }
    said.join(lang.space())
}

/// Every angle and coefficient with its uncertainty, and the residuals drawn.
fn estimates(report: &FitReport, fit: Option<&Fit>, lang: Language) -> Section {
    let expanded = format!("U ({})", level(report.level()));
    let derived: Vec<_> = report.derived.iter().filter(|d| d.value.is_some()).collect();
    let parameters = report.parameters.iter().enumerate().map(|(k, p)| {
        let tone = if p.state == State::NotEstimable { Tone::Bad } else { Tone::Plain };
        let state = if p.state == State::Free { String::new() } else { lang.term(p.state.name()) };
        let meaning = fit.and_then(|fit| fit.parameters.get(k)).map(|own| lang.name(&own.meaning).into_owned());
        (p.shown(), tone, state, meaning.unwrap_or_default())
    });
    let rows: Vec<(Shown<'_>, Tone, String, String)> = parameters
        .chain(derived.iter().map(|d| {
            let tone = if d.note.is_some() { Tone::Caution } else { Tone::Plain };
            (d.shown(), tone, say!(lang, "derived").to_string(), format!("= `{}`", d.line))
        }))
        .collect();
    let table = Rows::of(&rows)
        .name(say!(lang, "parameter"), |(quantity, ..)| quantity.id)
        .decimal(say!(lang, "estimate"), |(quantity, ..)| Cell::value(quantity.value, quantity.expanded.or(quantity.u)))
        .decimal("u", |(quantity, ..)| Cell::value(quantity.u, quantity.u))
        .decimal(expanded.as_str(), |(quantity, ..)| Cell::value(quantity.expanded, quantity.expanded))
        .left(say!(lang, "unit"), |(quantity, ..)| quantity.unit)
        .right(say!(lang, "dof"), |(quantity, ..)| Cell::dof(quantity.dof, quantity.u.is_some()))
        .right("k", |(quantity, ..)| Cell::decimals(quantity.k, 2))
        .at(Detail::Roomy)
        .left(say!(lang, "state"), |(_, _, state, _)| state)
        .left(say!(lang, "meaning"), |(.., meaning)| meaning)
        .at(Detail::Full)
        .tone(|(_, tone, ..)| *tone)
        .note(say!(lang, "u-combined-standard-uncertainty-k-u-expanded", expanded));
    let mut notes = Vec::new();
    for p in report.parameters.iter().filter(|p| p.state == State::AtBound && p.combined.u.is_some()) {
        let (Shown { scale, unit, u, .. }, id, level) = (p.shown(), &p.id, level(p.level));
        let end = |end: f64| rounded(end * scale, u);
        notes.push(match p.interval {
            Some([low, high]) => {
                say!(lang, "is-at-a-bound-interval-to-of", id, level, low = end(low), high = end(high), unit)
            }
            None => say!(lang, "is-at-a-bound-and-the-whole", id, level),
        });
    }
    notes.extend(report.parameters.iter().filter(|p| p.state == State::Free).filter_map(|p| {
        let (Shown { scale, unit, .. }, source) = (p.shown(), &p.id);
        let note = &interval_note((p.value?, p.combined.expanded?), p.interval?, (scale, unit), p.level, true)?;
        Some(say!(lang, "source-note-sentence", source, note))
    }));
    let noted = derived.iter().filter_map(|d| Some((&d.id, d.note.as_ref()?)));
    notes.extend(noted.map(|(source, note)| say!(lang, "source-note-sentence", source, note)));
    let without = report.derived_without_a_value();
    if !without.is_empty() {
        notes.push(lang.sentence(&say!(lang, "derived-without-a-value", names = lang.names(&without))));
    }
    Section::new(say!(lang, "estimates"))
        .table(table)
        .list(notes)
        .figures(fit.map(|fit| residual_figures(fit, report, lang)).unwrap_or_default())
        .prose(summary(report, fit, lang))
        .full()
        .figures(estimate_figures(report, lang))
}

/// What the readings leave free, and what would separate it.
fn free(report: &FitReport, lang: Language) -> Section {
    let mut section = Section::new(say!(lang, "not-estimable-from-these-readings"));
    for defect in &report.not_estimable {
        let instead = defect.instead(lang).unwrap_or_else(|| say!(lang, "no-reading-responds", here = defect.weak));
        let mut said = say!(lang, "the-parameters-can-move-along-and-no", text = defect.text, instead);
        if let Some(hides) = &defect.hides {
            said.push_str(&format!("{}{}", lang.space(), lang.sentence(&hides.say(lang))));
        }
        let further = defect.further(lang).unwrap_or_else(|| defect.nowhere().say(lang).to_string());
        section = section.prose(format!("{said}{}{}", lang.space(), lang.sentence(&further)));
    }
    let table = Rows::of(report.estimable_combinations.iter().map(|c| c.shown()))
        .name(say!(lang, "determined-instead"), |c| c.id)
        .decimal(say!(lang, "estimate"), |c| Cell::value(c.value, c.expanded.or(c.u)))
        .decimal("u", |c| Cell::value(c.u, c.u))
        .decimal("U", |c| Cell::value(c.expanded, c.expanded))
        .left(say!(lang, "unit"), |c| c.unit);
    section.table(table)
}

/// A share of the variance below this is left out of the table of a page.
const SMALL: f64 = 5e-4;

/// The budget of each quantity; `asked` puts all of it, and the correlations, before a reader of a terminal.
fn budget(report: &FitReport, asked: bool, lang: Language) -> Section {
    let mut hidden = 0_usize;
    let mut rows = Vec::new();
    for quantity in report.quantities() {
        let shown = quantity.budget.iter().filter(|line| asked || line.share.abs() >= SMALL);
        let before = rows.len();
        rows.extend(shown.enumerate().map(|(k, line)| (quantity, Some(line), k == 0)));
        hidden += quantity.budget.len() - (rows.len() - before);
        if quantity.u.is_some() && !quantity.budget.is_empty() {
            rows.push((quantity, None, false));
        }
    }
    let of = |line: Option<&BudgetReport>, cell: &dyn Fn(&BudgetReport) -> Cell| line.map_or("".into(), cell);
    let table = Rows::of(rows)
        .left(say!(lang, "quantity"), |(quantity, _, first)| if first { Cell::name(quantity.id) } else { "".into() })
        .left(say!(lang, "source"), |(_, line, _)| {
            line.map_or(say!(lang, "combined").into(), |line| scatter::source_name(&line.of.source, lang))
        })
        .right(say!(lang, "estimate"), |(_, line, _)| of(line, &|line| Cell::digits(line.of.estimate, 6)))
        .at(Detail::Roomy)
        .left(say!(lang, "type"), |(_, line, _)| of(line, &|line| line.of.evaluation.to_string().into()))
        .left(say!(lang, "distribution"), |(_, line, _)| {
            of(line, &|line| lang.term(&line.of.distribution.to_string()).into())
        })
        .at(Detail::Roomy)
        .right(say!(lang, "u-of-source"), |(_, line, _)| of(line, &|line| Cell::digits(line.of.source_u, 3)))
        .right("c", |(quantity, line, _)| {
            of(line, &|line| Cell::digits(line.of.sensitivity.map(|c| c * quantity.scale), 4))
        })
        .right(say!(lang, "dof"), |(quantity, line, _)| {
            Cell::dof(line.map_or(quantity.dof, |line| finite(line.of.dof)), true)
        })
        .right(say!(lang, "contribution"), |(quantity, line, _)| {
            Cell::digits(line.map_or(quantity.u, |line| Some(line.of.u * quantity.scale)), 3)
        })
        .right(say!(lang, "share"), |(_, line, _)| Cell::Share(line.map_or(1.0, |line| line.share)))
        .rule(|(_, line, first)| line.is_some() && first)
        .small();
    let note = say!(lang, "angles-in-radians-c-sensitivity-coefficient-of");
    let table = match hidden {
        0 => table.note(note),
        _ => {
            let left_out = say!(lang, "below-of-the-variance-left-out", hidden = hidden.to_string());
            table.note(format!("{note}{}{left_out}", lang.space()))
        }
    };
    let section = Section::new(say!(lang, "where-the-uncertainty-comes-from"));
    match asked {
        true => section.table(table).table(correlations(report, lang)).full().figures(budget_figures(report, lang)),
        false => section.full().figures(budget_figures(report, lang)).table(table),
    }
}

fn correlations(report: &FitReport, lang: Language) -> Rows<(&String, &Vec<Option<f64>>)> {
    let order = &report.correlation.order;
    let rows = order.iter().zip(&report.correlation.matrix).filter(|_| order.len() > 1);
    let table = Rows::of(rows).name(say!(lang, "correlation"), |(id, _)| id);
    let column = |table: Rows<_>, (k, id): (usize, &String)| {
        table.decimal(id, |(_, row): (_, &Vec<Option<f64>>)| row.get(k).map(|r| Cell::decimals(*r, 3)))
    };
    order.iter().enumerate().fold(table, column)
}

fn checks(report: &FitReport, lang: Language) -> Section {
    let checks = &report.checks;
    let mut section = Section::new(say!(lang, "checks"));
    if let Some(record) = &report.record {
        section = record_tables(section, record, lang);
    }
    let mut tests: Vec<(String, String, f64)> = Vec::new();
    tests.extend(checks.misfit().map(|test| {
        let by_replicates = checks.lack_of_fit.is_some();
        let name = if by_replicates { say!(lang, "lack-of-fit") } else { say!(lang, "lack-of-fit-by-position") };
        (name.into(), f_test(test, Cell::digits(test.f, 4).text()).say(lang), test.p)
    }));
    tests.extend(checks.runs.iter().map(|(sensor, test)| {
        let said = say!(lang, "runs-expected", runs = test.runs, expected = significant(test.expected, 3));
        (say!(lang, "runs-of", sensor), said, test.p)
    }));
    tests.extend(checks.follows.iter().map(|found| {
        let said = say!(lang, "runs-expected", runs = found.runs, expected = significant(found.expected, 3));
        (say!(lang, "runs-in-the-order-of", sensor = found.sensor, column = found.column), said, found.p)
    }));
    tests.extend(checks.normality.as_ref().map(|test| {
        (say!(lang, "normality").into(), format!("Shapiro-Francia W' = {}", significant(test.w, 4)), test.p)
    }));
    let tests = Rows::of(&tests)
        .left(say!(lang, "test"), |(name, ..)| name)
        .left(say!(lang, "statistic"), |(_, said, _)| said)
        .right("p", |(.., p)| Cell::Probability(*p));
    section = section.full().table(tests);
    if let Some(snooping) = &checks.snooping {
        let table = Rows::of(&snooping.suspects)
            .left(say!(lang, "reading"), |s| s.index)
            .left(say!(lang, "position"), |s| &s.position)
            .left(say!(lang, "sensor"), |s| &s.sensor)
            .decimal(say!(lang, "shift"), |s| Cell::Value(s.shift, Some(s.u)))
            .decimal("u", |s| Cell::Value(s.u, Some(s.u)))
            .decimal("w", |s| Cell::Decimals(s.w, 2))
            .right("p", |s| Cell::Probability(s.p))
            .caption(lang.title(&lang.term("suspicious-readings")))
            .note(say!(lang, "shift-how-far-the-reading-is-off", tested = snooping.tested));
        section = section.table(table);
    }
    let without = checks.snooping.as_ref().filter(|s| !s.suspects.is_empty()).map(|s| &s.without_suspects);
    let rows = report.parameters.iter().filter_map(|p| Some((p, checks.external.get(&p.id)?)));
    let mut table = Rows::of(rows)
        .name(say!(lang, "parameter"), |(p, _)| &p.id)
        .right(say!(lang, "reading"), |(_, external)| external.index)
        .right(say!(lang, "shift"), |(_, external)| Cell::Digits(external.effect, 3));
    if let Some(changes) = without {
        let change = |(p, _): (&super::ParameterReport, _)| Cell::digits(changes.get(&p.id).copied(), 3);
        table = table.right(say!(lang, "change-without-suspects"), change);
    }
    let table = table
        .left(say!(lang, "unit"), |(p, _)| p.shown().unit)
        .small()
        .caption(say!(lang, "external-reliability"))
        .note(say!(lang, "effect-what-the-smallest-detectable-fault-of"));
    section.table(table)
}

/// Lines of means of a sensor: of 1 row, of the longest means, and of lengths between them.
const LINES: usize = 5;

/// A record that was streamed: means of its residuals, lack of fit over its inputs, the largest residuals.
fn record_tables(section: Section, record: &RecordReport, lang: Language) -> Section {
    let tests = record.sensors.iter().flat_map(|s| {
        let every = s.means.len().div_ceil(LINES).max(1);
        let last = s.means.len().saturating_sub(1);
        s.means
            .iter()
            .enumerate()
            .filter(move |(k, _)| (last - k).is_multiple_of(every))
            .map(move |(_, test)| (s, test))
    });
    let means = Rows::of(tests)
        .left(say!(lang, "sensor"), |(sensor, _)| &sensor.sensor)
        .right(say!(lang, "rows-in-a-mean"), |(_, test)| test.rows.to_string())
        .decimal(say!(lang, "sd-over-that-of-independent-rows"), |(_, test)| Cell::Digits(test.ratio.sqrt(), 3))
        .right("p", |(_, test)| Cell::Probability(test.p));
    let inputs = Rows::of(&record.inputs)
        .left(say!(lang, "sensor"), |input| &input.sensor)
        .left(say!(lang, "input"), |input| &input.column)
        .decimal(say!(lang, "chi-square"), |input| Cell::Digits(input.chi_square, 3))
        .right(say!(lang, "dof"), |input| input.dof)
        .right("p", |input| Cell::Probability(input.p))
        .caption(lang.title(say!(lang, "lack-of-fit")));
    let far = record.sensors.iter().flat_map(|sensor| sensor.largest.iter().take(5).map(move |far| (sensor, far)));
    let largest = Rows::of(far)
        .left(say!(lang, "sensor"), |(sensor, _)| &sensor.sensor)
        .right(say!(lang, "row-of-the-record"), |(_, far)| far.number.to_string())
        .decimal(say!(lang, "value"), |(_, far)| Cell::Digits(far.value, 6))
        .decimal(say!(lang, "residual"), |(_, far)| Cell::Digits(far.residual, 3))
        .decimal("w", |(_, far)| Cell::Decimals(far.w, 2))
        .right("p", |(_, far)| Cell::Probability(far.p))
        .small();
    let [rows, shown] = [record.rows, record.shown as u64].map(|n| n.to_string());
    section.prose(say!(lang, "record-of-rows-read", rows, shown)).table(means).table(inputs).full().table(largest)
}

/// Constraints, the robust estimator and remounting, where the fit has them.
fn conditions(report: &FitReport, lang: Language) -> Section {
    let table = Rows::of(report.constraints.iter().flat_map(|constraints| &constraints.list))
        .right(say!(lang, "constraint"), |c| c.index)
        .name("", |c| &c.text)
        .left(say!(lang, "state"), |c| lang.term(c.state.name()))
        .left(say!(lang, "side"), |c| c.side.map_or(String::new(), |side| lang.term(&side.to_string())))
        .right(say!(lang, "cost-in-chi-square"), |c| Cell::digits(c.cost, 3));
    let section = Section::new(say!(lang, "constraints-and-weights")).table(table);
    let Some(robust) = &report.robust else { return section };
    let low: Vec<String> = robust.downweighted.iter().map(usize::to_string).collect();
    let low = if low.is_empty() { say!(lang, "none").into() } else { low.join(lang.comma()) };
    section.prose(say!(lang, "robust-estimator", method = robust.method.to_string())).prose(say!(
        lang,
        "less-than-half-of-their-weight-readings",
        low
    ))
}

fn iterations(report: &FitReport, lang: Language) -> Section {
    let rows = report.convergence.iter().flat_map(|record| &record.iterations).enumerate();
    let table = Rows::of(rows)
        .right("#", |(k, _)| k + 1)
        .decimal(say!(lang, "weighted-sum-of-squares"), |(_, iteration)| Cell::Digits(iteration.sum_of_squares, 6))
        .right(say!(lang, "step-of-the-predictions"), |(_, iteration)| Cell::Digits(iteration.step, 3))
        .decimal(say!(lang, "share-of-the-step"), |(_, iteration)| Cell::Digits(iteration.share, 3))
        .small();
    Section::new(say!(lang, "iterations")).full().table(table)
}

/// Monte Carlo compared with the first order.
fn monte_carlo(report: &FitReport, lang: Language) -> Section {
    let section = Section::new(say!(lang, "monte-carlo"));
    let Some(MonteCarloReport { drawn, verdict, .. }) = &report.monte_carlo else { return section };
    let rows = drawn.outputs.iter().map(|output| {
        let quantity = report.quantities().find(|quantity| quantity.id == output.id);
        let (scale, unit) = quantity.map_or((1.0, ""), |quantity| (quantity.scale, quantity.unit));
        (output, scale, unit)
    });
    let pair = |scale: f64, u: f64, [a, b]: [f64; 2]| {
        let [a, b] = [a, b].map(|end| rounded(end * scale, Some(u * scale)));
        say!(lang, "from-to", a, b)
    };
    let table = Rows::of(rows)
        .name(say!(lang, "quantity"), |(output, ..)| &output.id)
        .decimal(say!(lang, "mean"), |(output, scale, _)| Cell::Value(output.mean * scale, Some(output.u * scale)))
        .decimal("u", |(output, scale, _)| Cell::Value(output.u * scale, Some(output.u * scale)))
        .right(say!(lang, "checks-page-interval", level = level(report.level())), |(output, scale, _)| {
            pair(scale, output.u, output.interval)
        })
        .right(say!(lang, "shortest"), |(output, scale, _)| pair(scale, output.u, output.shortest))
        .at(Detail::Roomy)
        .right(say!(lang, "first-order"), |(o, scale, _)| o.first_order.map(|ends| pair(scale, o.u, ends)))
        .left(say!(lang, "unit"), |(.., unit)| unit)
        .tone(|(output, ..)| if output.first_order_agrees == Some(false) { Tone::Caution } else { Tone::Plain });
    let trials = say!(lang, "of-trials-seed", trials = drawn.trials, asked = drawn.asked, seed = drawn.seed);
    let joint = drawn.joint.as_ref().and_then(|joint| {
        let (order, k) = (joint.names.join(lang.comma()), significant(joint.ellipsoid_factor?, 4));
        Some(lang.sentence(&say!(lang, "coverage-ellipsoid-of-k-p", order, k)))
    });
    section
        .list(verdict.iter().map(|line| lang.sentence(&line.say(lang))))
        .table(table)
        .prose(say!(lang, "marked-the-first-order-is-not-good", trials))
        .proses(joint)
}

/// Readings to inputs: the first order with numbers, where it holds, and the sensors' axes on the mounting face; a reader of a terminal has to
/// ask for it.
fn correction(report: &FitReport, asked: bool, lang: Language) -> Section {
    let section = Section::new(say!(lang, "the-correction-to-apply")).full_unless(asked);
    let Some(correction) = &report.correction else {
        let missing = report.parameters.iter().filter(|p| p.state == State::NotEstimable).map(|p| p.id.as_str());
        let missing: Vec<&str> = missing.collect();
        let (n, none) = (missing.len(), say!(lang, "correction-none-of-the-sensors-follows-a"));
        return match n {
            0 => section.prose(if asked { none } else { "" }),
            _ => section.verdict(
                Tone::Caution,
                say!(lang, "readings-cannot-be-corrected-not-estimable-here", missing = lang.names(&missing), n),
            ),
        };
    };
    let left_out = correction.left_out.iter();
    let section = section
        .prose(say!(lang, "all-sensors-are-solved-together-for-the"))
        .block(Content::Formula(correction_lines(correction)))
        .prose(validity_sentence(correction, lang))
        .proses(given_sentence(correction, lang))
        .verdicts(
            left_out.map(|(sensor, why)| (Tone::Caution, say!(lang, "is-left-out-of-the-correction", sensor, why))),
        );
    let Some(mounting) = &correction.mounting else { return section };
    let others = report.parameters.iter().filter(|p| p.kind == Kind::Tilt && !mounting.tilts.contains(&p.id));
    let others: Vec<&str> = others.map(|p| p.id.as_str()).collect();
    let section = mounted(section, correction, mounting, lang);
    match others.len() {
        0 => section,
        n => section.prose(say!(lang, "belongs-to-the-bench-and-stays-there", others = lang.names(&others), n)),
    }
}

fn mounted(section: Section, correction: &CorrectionFile, mounting: &Mounting, lang: Language) -> Section {
    let tilts = lang.names(&mounting.tilts);
    if !mounting.missing.is_empty() {
        let (missing, n) = (lang.names(&mounting.missing), mounting.missing.len());
        return section.prose(say!(lang, "the-rotation-from-the-sensors-axes-to", tilts, missing, n));
    }
    let solved = correction.inputs.iter().filter(|input| input.solved);
    let table = Rows::of(solved.filter_map(|input| Some((input, input.direction?))))
        .name(say!(lang, "input"), |(input, _)| &input.name)
        .caption(say!(lang, "direction-cosines-of-the-corrected-inputs-on"));
    let column = |table: Rows<_>, (axis, row): (&str, &[f64; 3])| {
        table.decimal(axis, |(_, d): (_, [f64; 3])| {
            Cell::Decimals(row.iter().zip(&d).map(|(r, d)| r * d).sum::<f64>(), 9)
        })
    };
    let table = ["x", "y", "z"].into_iter().zip(&mounting.rotation).fold(table, column);
    section.prose(say!(lang, "a-corrected-input-points-along-the-sensors", tilts)).table(table)
}

/// What the fit takes for granted.
fn assumptions(report: &FitReport, asked: &Asked<'_>, lang: Language) -> Section {
    let mut points = Vec::new();
    if !report.assumed_zero.is_empty() {
        let assumed_zero = lang.names(&report.assumed_zero);
        points.push(say!(lang, "taken-as-zero-neither-known-nor-estimated", assumed_zero));
    }
    match report.site.latitude_deg {
        Some(latitude_deg) => points.push(say!(
            lang,
            "site-latitude-earth-rate-deg-h",
            latitude_deg,
            earth_rate_deg_h = report.site.earth_rate_deg_h,
            said = site::gravity_text(&report.site, lang)
        )),
        None if report.model.values().any(|line| reads_motion(line)) => {
            points.push(say!(lang, "no-site-no-earth-rate-and-gravity").into());
        }
        None => {}
    }
    if !report.correlations.is_empty() {
        let list = report.correlated();
        points.push(lang.sentence(&say!(lang, "correlated-inputs", list = list.join(lang.comma()))));
    }
    let inexact = |u: f64, cell: Cell| if u > 0.0 { cell } else { "".into() };
    let table = Rows::of(&report.known)
        .name(say!(lang, "known"), |known| &known.id)
        .decimal(say!(lang, "value"), |known| known.shown().0.to_string())
        .decimal("u", |known| if known.u > 0.0 { Cell::Digits(known.shown().1, 3) } else { say!(lang, "exact").into() })
        .left(say!(lang, "distribution"), |known| inexact(known.u, lang.term(&known.distribution.to_string()).into()))
        .at(Detail::Roomy)
        .right(say!(lang, "dof"), |known| inexact(known.u, Cell::dof(known.dof, true)))
        .at(Detail::Roomy)
        .left(say!(lang, "unit"), |known| known.shown().2);
    let estimator = say!(lang, "rows-are-exact-derivatives", iterated = report.estimator == Estimator::Exact);
    let variance = match report.fit.variance {
        VarianceFrom::Stated => lang.sentence(&say!(lang, "noise-floor", noise = lang.term("stated"))),
        VarianceFrom::Estimated => say!(lang, "errors-are-independent").into(),
    };
    let mut origin = Vec::new();
    let source = asked.fit.map(|fit| fit.campaign.bench.source.as_str()).filter(|source| !source.is_empty());
    origin.extend(source.map(|source| (lang.title(say!(lang, "source")), lang.name(source).into_owned())));
    origin.extend(asked.inputs.first().map(|input| (lang.title(say!(lang, "campaign")), input.name.clone())));
    Section::new(say!(lang, "what-was-assumed"))
        .list(points)
        .table(table)
        .full()
        .list([estimator, variance])
        .facts(origin)
        .figures(bench_figure(asked.fit.map(|fit| &fit.campaign), lang))
}

/// The bench as its first reading has it; none without joints.
pub(super) fn bench_figure(campaign: Option<&Campaign>, lang: Language) -> Option<Figure> {
    let campaign = campaign.filter(|campaign| campaign.bench.joints().next().is_some())?;
    let first = campaign.readings.rows.first()?;
    Some(scene_figure(&campaign.bench, &first.joints, say!(lang, "bench-at-first-reading").into(), lang))
}

/// Does a model line read the rate of rotation about an axis (`w_x`, not `flow_x`)?
fn reads_motion(line: &str) -> bool {
    let is_motion = |name: &str| ["w_", "a_"].iter().any(|start| name.starts_with(start));
    line.split(|c: char| !c.is_alphanumeric() && c != '_').any(is_motion)
}

/// More readings than this are not listed on a page.
const LISTED: usize = 1000;

/// Each reading with what the fit makes of it; `asked` puts all of them before a reader of a terminal.
fn readings(report: &FitReport, fit: Option<&Fit>, asked: bool, lang: Language) -> Section {
    let joints: Vec<&str> = fit.map(|fit| fit.campaign.bench.joints().collect()).unwrap_or_default();
    let states = |index: usize| -> &[JointState] {
        let place = match fit.and_then(|fit| fit.streamed.as_ref()) {
            // a reading that is not in the sample has no states to show
            Some(streamed) => streamed.numbers.binary_search(&(index as u64)).unwrap_or(usize::MAX),
            None => index - 1,
        };
        let row = fit.and_then(|fit| fit.campaign.readings.rows.get(place));
        row.map(|row| &*row.joints).unwrap_or_default()
    };
    let most = if asked { usize::MAX } else { LISTED };
    let mut table = Rows::of(report.readings.iter().take(most))
        .right(say!(lang, "reading"), |r| r.index)
        .left(say!(lang, "position"), |r| &r.position);
    for (k, name) in joints.iter().enumerate() {
        for suffix in ["_deg", "_deg_s", "_turns"] {
            let value = |r: &ReadingReport| {
                let mut given = states(r.index).get(k).into_iter().flat_map(JointState::given);
                given.find(|(of, _)| *of == suffix).map(|(_, value)| value)
            };
            if report.readings.iter().any(|r| value(r).is_some()) {
                let text = |r: &ReadingReport| value(r).map_or(String::new(), |v| v.to_string());
                table = table.decimal(format!("{name}{suffix}"), text).at(Detail::Full);
            }
        }
    }
    let tenth = |r: &ReadingReport| r.u.map(|u| u / 10.0);
    let table = table
        .left(say!(lang, "sensor"), |r| &r.sensor)
        .decimal(say!(lang, "value"), |r| as_read(r.value, tenth(r)))
        .decimal(say!(lang, "fitted"), |r| Cell::Value(r.fitted, tenth(r)))
        .at(Detail::Roomy)
        .decimal(say!(lang, "residual"), |r| Cell::Value(r.residual, tenth(r)))
        .decimal(say!(lang, "studentized"), |r| Cell::decimals(r.studentized, 2))
        .decimal(say!(lang, "redundancy"), |r| Cell::Decimals(r.redundancy, 3))
        .right(say!(lang, "mdb"), |r| Cell::digits(r.mdb, 3))
        .tone(|r| if r.studentized.is_some_and(|s| s.abs() > FAR) { Tone::Caution } else { Tone::Plain })
        .small();
    let mut note = say!(lang, "redundancy-the-share-of-a-fault-that", limit = FAR);
    if report.readings.len() > most {
        let n = report.readings.len().to_string();
        note.push_str(&format!(
            "{}{}",
            lang.space(),
            say!(lang, "the-first-of-are-listed-the-json", listed = LISTED, n)
        ));
    }
    Section::new(say!(lang, "readings")).full_unless(asked).table(table.note(note))
}

/// A value as the file gives it, unless it has more digits than anyone wants to see.
fn as_read(value: f64, u: Option<f64>) -> Cell {
    let text = value.to_string();
    if text.len() <= 9 { text.into() } else { Cell::Value(value, u) }
}
