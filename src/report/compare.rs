//! The comparison with published closed forms: its report (`tumble compare --json`; angles in arcseconds), its document, and its section in the document
//! of a fit.

use super::provenance::begin;
use super::{Input, ReportKind, VERSION};
use crate::campaign::Identity;
use crate::compare::{Comparison, GroupComparison, Misprint, shown_in, value_of};
use crate::document::number::significant;
use crate::document::{Cell, Document, Rows, Section, Tone};
use crate::language::{Language, code, say};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `tumble compare --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct CompareReport {
    /// Version of the program that wrote it.
    pub tumble: String,
    /// Always `compare`.
    #[schemars(extend("const" = "compare"))]
    pub report: ReportKind,
    /// Id of the bench.
    pub bench: String,
    /// The unit under test, when, where, by whom, with what.
    #[serde(default, skip_serializing_if = "Identity::is_empty")]
    pub identity: Identity,
    /// The files that the report was made from, with the SHA-256 of their bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Input>,
    /// Where the closed forms come from.
    pub source: String,
    /// What the groups are.
    pub group_title: String,
    /// Each rate or run.
    pub groups: Vec<GroupReport>,
    /// All readings: mean of the closed forms, and one least-squares fit.
    pub all: GroupReport,
    /// Largest relative difference between closed form and least squares on the same physics (without Earth rate where the closed forms
    /// ignore it); null if no closed form could be computed.
    pub largest_relative_difference: Option<f64>,
    /// Title of the printed table, if this campaign is the published one.
    pub printed: Option<String>,
    /// Where print and computation disagree.
    pub misprints: Vec<Misprint>,
}

/// Differences of closed form and least squares above this share of the value are no rounding.
const SQUARE: f64 = 1e-6;

impl CompareReport {
    /// Are the formulas the square special case of least squares for these readings?
    pub(crate) fn is_square_case(&self) -> bool {
        self.largest_relative_difference.is_some_and(|difference| difference < SQUARE)
    }

    /// What the rows are: angles, coefficients, or both.
    pub(crate) fn quantity(&self, lang: Language) -> &'static str {
        let angles = self.all.quantities.iter().filter(|q| q.is_angle()).count();
        match angles {
            0 => say!(lang, "coefficient"),
            n if n == self.all.quantities.len() => say!(lang, "angle"),
            _ => say!(lang, "quantity"),
        }
    }
}

/// One group of readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroupReport {
    /// The rate or run, in the unit of its column; null for all readings.
    pub group: Option<f64>,
    /// How many readings.
    pub readings: usize,
    /// Each quantity.
    pub quantities: Vec<QuantityReport>,
}

/// One quantity of a group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct QuantityReport {
    /// Name.
    pub id: String,
    /// `arcsec` for angles, else the parameter's own unit.
    pub unit: String,
    /// By the published closed form, in `unit` (for all readings: the mean over the groups).
    pub closed_form: Option<f64>,
    /// By least squares without Earth rate, where the closed forms ignore it and the site has one (absent for all readings), in `unit`.
    pub without_earth_rate: Option<f64>,
    /// By least squares with the site's Earth rate, in `unit`.
    pub least_squares: Option<f64>,
    /// As printed, in `unit`.
    pub printed: Option<f64>,
}

impl QuantityReport {
    /// Is it an angle?
    pub(crate) fn is_angle(&self) -> bool {
        self.unit == "arcsec"
    }
}

/// The report of a comparison.
pub fn compare_report(comparison: &Comparison) -> CompareReport {
    let scales: Vec<(f64, String)> = comparison.quantities.iter().map(|id| shown_in(&comparison.all, id)).collect();
    // by the closed form, without Earth rate, by least squares, as printed
    let quantities = |of: &dyn Fn(usize, &str) -> [Option<f64>; 4]| {
        let quantity = |(k, (id, (factor, unit))): (usize, (&String, &(f64, String)))| {
            let values = of(k, id).map(|value| value.map(|v| v * factor));
            let [closed_form, without_earth_rate, least_squares, printed] = values;
            let (id, unit) = (id.clone(), unit.clone());
            QuantityReport { id, unit, closed_form, without_earth_rate, least_squares, printed }
        };
        comparison.quantities.iter().zip(&scales).enumerate().map(quantity).collect::<Vec<_>>()
    };
    let group = |g: &GroupComparison| {
        let lists = [&g.closed_form, &g.like_for_like, &g.least_squares, &g.printed];
        let quantities = quantities(&|k, _| lists.map(|list| list.get(k).copied().flatten()));
        GroupReport { group: g.group, readings: g.readings, quantities }
    };
    let mut largest: Option<f64> = None;
    for g in &comparison.groups {
        for ((closed, square), with_earth) in g.closed_form.iter().zip(&g.like_for_like).zip(&g.least_squares) {
            if let (Some(closed), Some(square)) = (closed, square.as_ref().or(with_earth.as_ref())) {
                let relative = (closed - square).abs() / closed.abs().max(square.abs()).max(f64::MIN_POSITIVE);
                largest = Some(largest.unwrap_or(0.0).max(relative));
            }
        }
    }
    let printed = |id: &str| comparison.printed.as_ref()?.means.iter().find(|(other, _)| other == id).map(|(_, v)| *v);
    let all = quantities(&|k, id| {
        [comparison.mean.get(k).copied().flatten(), None, value_of(&comparison.all, id), printed(id)]
    });
    CompareReport {
        tumble: VERSION.into(),
        report: ReportKind::Compare,
        bench: comparison.all.campaign.bench.id.clone(),
        identity: comparison.all.campaign.identity.clone(),
        inputs: Vec::new(),
        source: comparison.source.clone(),
        group_title: comparison.group_title.clone(),
        groups: comparison.groups.iter().map(group).collect(),
        all: GroupReport { group: None, readings: comparison.all.design.rows.len(), quantities: all },
        largest_relative_difference: largest,
        printed: comparison.printed.as_ref().map(|p| p.title.clone()),
        misprints: comparison.misprints.clone(),
    }
}

/// The document of a comparison.
pub fn compare_document(report: &CompareReport, inputs: &[Input], lang: Language) -> Document {
    let misprints = Rows::of(&report.misprints)
        .left(say!(lang, "quantity"), |m| m.what.say(lang))
        .decimal(say!(lang, "printed"), |m| Cell::digits(m.printed, 4))
        .decimal(say!(lang, "computed"), |m| Cell::digits(m.computed, 4))
        .left(say!(lang, "probable-cause"), |m| m.explanation.say(lang));
    begin(say!(lang, "comparison-with-the-published-closed-forms"), inputs, lang)
        .fact(say!(lang, "bench"), code(&report.bench))
        .fact(lang.title(say!(lang, "source")), lang.name(&report.source))
        .section(section(report, lang))
        .section(Section::new(say!(lang, "group-by-group")).table(groups(report, lang)))
        .section(Section::new(say!(lang, "misprints-found")).table(misprints))
}

/// All readings: the mean of the closed forms beside one least-squares fit.
pub(super) fn section(report: &CompareReport, lang: Language) -> Section {
    let ignored = report.groups.iter().flat_map(|g| &g.quantities).any(|q| q.without_earth_rate.is_some());
    let verdict = report.largest_relative_difference.map(|difference| {
        let (square, difference) = (report.is_square_case(), significant(difference, 2));
        let tone = if square { Tone::Good } else { Tone::Caution };
        match ignored {
            true => (tone, say!(lang, "group-by-group-without-earth-rate", square, difference)),
            false => (Tone::Plain, lang.sentence(&say!(lang, "closed-form-and-least-squares-differ-by", difference))),
        }
    });
    let closed = format!("{} {}", say!(lang, "closed-form"), lang.in_parentheses(say!(lang, "mean")));
    let mut table = Rows::of(&report.all.quantities)
        .name(report.quantity(lang), |q| &q.id)
        .decimal(closed, |q| number(q.closed_form, q, 3))
        .decimal(say!(lang, "least-squares"), |q| number(q.least_squares, q, 3));
    if report.printed.is_some() {
        table = table.decimal(say!(lang, "printed"), |q| number(q.printed, q, 1));
    }
    Section::new(say!(lang, "comparison-with-the-published-closed-forms"))
        .verdicts(verdict)
        .table(table.left(say!(lang, "unit"), |q| &q.unit))
        .full()
        .prose(lang.sentence(&lang.name(&report.source)))
}

/// Angles with so many decimals, coefficients with digits enough for any unit.
fn number(value: Option<f64>, of: &QuantityReport, decimals: usize) -> Cell {
    if of.is_angle() { Cell::decimals(value, decimals) } else { Cell::digits(value, 7) }
}

fn groups(report: &CompareReport, lang: Language) -> Rows<(bool, Option<f64>, &QuantityReport)> {
    let rows = report.groups.iter().flat_map(|group| {
        let quantities = group.quantities.iter().enumerate();
        quantities.map(|(k, q)| (k == 0, group.group, q))
    });
    let group = |value: Option<f64>| value.map_or_else(|| say!(lang, "all").into(), |value| value.to_string());
    Rows::of(rows)
        .left(lang.name(&report.group_title), |(first, value, _)| if first { group(value) } else { String::new() })
        .name(report.quantity(lang), |(.., q)| &q.id)
        .decimal(say!(lang, "closed-form"), |(.., q)| number(q.closed_form, q, 3))
        .decimal(say!(lang, "least-squares-no-earth-rate"), |(.., q)| number(q.without_earth_rate, q, 3))
        .decimal(say!(lang, "least-squares"), |(.., q)| number(q.least_squares, q, 3))
        .decimal(say!(lang, "printed"), |(.., q)| number(q.printed, q, 1))
        .left(say!(lang, "unit"), |(.., q)| &q.unit)
        .rule(|(first, ..)| first)
}
