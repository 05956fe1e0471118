//! A measurement result: its method, conditions, and quantities with their conformity; the covariance, the correction, what scatters.

use super::administrative::method_and_equipment;
use super::xml::{Element, Texts, element, text};
use super::{Measured, Quantity, estimated, units, verdicts};
use crate::campaign::{Condition, Identity};
use crate::document::number::places;
use crate::fit::{Conformity, Estimator};
use crate::language::{Language, bare, say};
use crate::number;
use crate::report::conformity::{ConformityReport, LimitedReport, percent};
use crate::report::correction::{given_at, validity_sentence};
use crate::report::{FitReport, ScatterReport, scatter};
use crate::uncertainty::quantiles;
use crate::wire::{CorrectionFile, LabFile};

pub(super) fn measured(title: &str, measurement: &Measured<'_>, lab: &LabFile, texts: Texts<'_>) -> Element {
    let report = measurement.report;
    let name = texts.said("dcc:name", |lang| match measurement.adjusted {
        Some(adjusted) => format!("{}{}{}", lang.name(title), lang.colon(), adjusted.said(lang)),
        None => lang.name(title).into_owned(),
    });
    let results = element("dcc:results")
        .add(estimates(measurement, texts))
        .add(covariance(report, &measurement.quantities, texts))
        .add(report.correction.as_ref().and_then(|correction| matrix(correction, measurement.prefix, texts)))
        .add(scattering(report, measurement.prefix, texts));
    element("dcc:measurementResult")
        .add(name)
        .add(about(&report.identity).map(|said| texts.own("dcc:description", &said)))
        .add(method_and_equipment(lab, &report.identity, texts))
        .add(conditions(&report.identity, measurement.adjusted, texts))
        .add(results)
}

/// The place, and the laboratory's own note.
fn about(identity: &Identity) -> Option<String> {
    let said: Vec<&str> = [&identity.place, &identity.note].into_iter().flatten().map(String::as_str).collect();
    (!said.is_empty()).then(|| said.join("\n"))
}

/// Was the item measured before or after it was adjusted?
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Adjusted {
    /// As found.
    Before,
    /// As left.
    After,
}

impl Adjusted {
    fn status(self) -> &'static str {
        match self {
            Adjusted::Before => "beforeAdjustment",
            Adjusted::After => "afterAdjustment",
        }
    }

    pub(super) fn said(self, lang: Language) -> &'static str {
        match self {
            Adjusted::Before => say!(lang, "dcc-as-found"),
            Adjusted::After => say!(lang, "dcc-as-left"),
        }
    }
}

/// The conditions; names of the environment are the laboratory's own. Without any, that none are stated.
fn conditions(identity: &Identity, adjusted: Option<Adjusted>, texts: Texts<'_>) -> Element {
    let first = (adjusted.is_some() || identity.environment.is_empty()).then(|| {
        let name = texts.said("dcc:name", |lang| match adjusted {
            Some(_) => lang.title(say!(lang, "state")),
            None => say!(lang, "identity-environment").into(),
        });
        let said = |lang: Language| adjusted.map_or(say!(lang, "dcc-not-stated"), |adjusted| adjusted.said(lang));
        element("dcc:influenceCondition")
            .add(name)
            .add(adjusted.map(|adjusted| text("dcc:status", adjusted.status())))
            .add(element("dcc:data").add(texts.said("dcc:text", |lang| said(lang).into())))
    });
    let stated = identity.environment.iter().map(|(name, condition)| {
        let ref_type = ref_type(name);
        // a number without a unit of D-SI is a text
        let quantities = match (condition, unit_of(name)) {
            (Condition::Number(value), Some(unit)) => vec![("", *value, None, unit)],
            (Condition::Measured { value, u }, Some(unit)) => vec![("", *value, Some(*u), unit)],
            (Condition::Range([low, high]), Some(unit)) => vec![("Min", *low, None, unit), ("Max", *high, None, unit)],
            _ => Vec::new(),
        };
        let worded = quantities.is_empty().then(|| texts.own("dcc:text", &condition.to_string()));
        let quantities = quantities.into_iter().map(|(which, value, u, unit)| {
            let u = u.map(|u| element("si:standardMU").add(text("si:valueStandardMU", decimal(u))));
            let real =
                real(None, decimal(value), unit).add(u.map(|u| element("si:measurementUncertaintyUnivariate").add(u)));
            element("dcc:quantity")
                .of_type(ref_type.map(|kind| format!("{kind}{which}")).as_deref())
                .add(texts.own("dcc:name", name))
                .add(real)
        });
        element("dcc:influenceCondition")
            .of_type(ref_type)
            .add(texts.own("dcc:name", name))
            .add(element("dcc:data").add(worded).add(quantities))
    });
    element("dcc:influenceConditions").add(first).add(stated)
}

/// A number with its unit in D-SI's notation.
fn real(label: Option<&str>, value: String, unit: &str) -> Element {
    let label = label.map(|label| text("si:label", label));
    element("si:real").add(label).add(text("si:value", value)).add(text("si:unit", unit))
}

/// The type of a condition in PTB's lists of good practice, by the quantity in its name.
fn ref_type(name: &str) -> Option<&'static str> {
    name.split('_').find_map(|word| match word.to_ascii_lowercase().as_str() {
        "temperature" => Some("basic_temperature"),
        "humidity" | "rh" => Some("basic_humidityRelative"),
        "pressure" => Some("basic_pressure"),
        _ => None,
    })
}

/// The unit at the end of a condition's name, in the notation of D-SI.
fn unit_of(name: &str) -> Option<&'static str> {
    let end = name.rsplit('_').next()?.to_ascii_lowercase();
    Some(match end.as_str() {
        "c" | "degc" | "celsius" => "\\degreecelsius",
        "k" => "\\kelvin",
        "percent" | "rh" => "\\percent",
        "pa" => "\\pascal",
        "hpa" | "mbar" => "\\hecto\\pascal",
        "kpa" => "\\kilo\\pascal",
        "v" => "\\volt",
        "s" => "\\second",
        "h" => "\\hour",
        _ => return None,
    })
}

fn estimates(measurement: &Measured<'_>, texts: Texts<'_>) -> Element {
    let quantities = measurement.quantities.iter().map(|quantity| self::quantity(measurement, quantity, texts));
    element("dcc:result")
        .add(texts.said("dcc:name", |lang| say!(lang, "estimates").into()))
        .add(texts.said("dcc:description", |lang| remarks(measurement.report, lang).join(lang.space())))
        .add(element("dcc:data").add(quantities))
}

/// What a reader must know to use the numbers.
fn remarks(report: &FitReport, lang: Language) -> Vec<String> {
    let models: Vec<String> = report.model.iter().map(|(sensor, line)| format!("{sensor} = {line}")).collect();
    let models = format!("{}{}{}", say!(lang, "model"), lang.colon(), models.join(lang.semicolon()));
    let mut remarks = vec![lang.sentence(&models), estimated(report, lang)];
    remarks.push(say!(lang, "rows-are-exact-derivatives", iterated = report.estimator == Estimator::Exact));
    if !report.known.is_empty() {
        let known: Vec<String> = report
            .known
            .iter()
            .map(|k| (k, k.shown()))
            .map(|(k, (value, u, unit))| format!("{} = {value} {unit} (u = {u})", k.id))
            .collect();
        remarks.push(say!(lang, "taken-as-known", known = known.join(lang.semicolon())));
    }
    if !report.correlations.is_empty() {
        let list = report.correlated().join(lang.semicolon());
        remarks.push(lang.sentence(&say!(lang, "correlated-inputs", list)));
    }
    if !report.assumed_zero.is_empty() {
        remarks.push(say!(
            lang,
            "taken-as-zero-neither-known-nor-estimated",
            assumed_zero = lang.list(&report.assumed_zero)
        ));
    }
    if let Some(robust) = &report.robust {
        remarks.push(say!(lang, "robust-estimator", method = robust.method.to_string()));
    }
    // names are marked as such on pages alone
    remarks.extend(verdicts(report, lang).into_iter().map(|(_, said)| bare(&said)));
    remarks
}

fn quantity(measurement: &Measured<'_>, quantity: &Quantity, texts: Texts<'_>) -> Element {
    let level = measurement.report.level();
    let one = |value: f64, expanded: f64, unit: &str| {
        let [value, rounded] = to_two_digits(value, expanded);
        let uncertainty = match quantity.interval {
            // not value - U to value + U
            Some(ends) => {
                let scale = Some(expanded / quantity.expanded).filter(|scale| scale.is_finite()).unwrap_or(1.0);
                let [low, high] = ends.map(|end| {
                    // a digit more than U: the ends are no estimates
                    let [end, _] = to_two_digits(end * scale, 0.1 * expanded);
                    end
                });
                let [_, u] = to_two_digits(0.0, expanded / quantity.k);
                element("si:coverageIntervalMU")
                    .add(text("si:valueStandardMU", u))
                    .add(text("si:intervalMin", low))
                    .add(text("si:intervalMax", high))
                    .add(text("si:coverageProbability", plain(level)))
            }
            None => element("si:expandedMU")
                .add(text("si:valueExpandedMU", rounded))
                .add(text("si:coverageFactor", plain(quantity.k)))
                .add(text("si:coverageProbability", plain(level)))
                .add(quantity.distribution(level).map(|name| text("si:distribution", name))),
        };
        let uncertainty = element("si:measurementUncertaintyUnivariate").add(uncertainty);
        real(Some(&quantity.id), value, &units::d_si(&[unit])).add(uncertainty)
    };
    let in_unit = one(quantity.value, quantity.expanded, &quantity.unit);
    let number = match quantity.arcsec.and_then(|a| a.value.zip(a.expanded)) {
        Some((value, expanded)) => element("si:hybrid").add(in_unit).add(one(value, expanded, "arcsec")),
        None => in_unit,
    };
    let described = |lang: Language| {
        let meaning = Some(lang.name(&quantity.meaning).into_owned()).filter(|meaning| !meaning.is_empty());
        let note = quantity.note.as_ref().map(|note| note.say(lang).to_string());
        meaning.into_iter().chain(note).collect::<Vec<_>>().join(lang.semicolon())
    };
    let is_described = !quantity.meaning.is_empty() || quantity.note.is_some();
    let meaning = is_described.then(|| texts.said("dcc:description", described));
    element("dcc:quantity")
        .with("id", format!("{}quantity_{}", measurement.prefix, quantity.id))
        .with("refType", "basic_measuredValue")
        .add(texts.own("dcc:name", &quantity.id))
        .add(meaning)
        .add(number)
        .add(measurement.report.conformity.as_ref().and_then(|conformity| verdict(conformity, &quantity.id, texts)))
}

fn distribution(dof: f64) -> &'static str {
    if dof.is_finite() { "t" } else { "normal" }
}

/// Relative difference from a quantile that is its rounding.
const SAME: f64 = 1e-6;

impl Quantity {
    /// The distribution of which k is the quantile; `None` where it is that of another one, as of a largest deviation.
    fn distribution(&self, level: f64) -> Option<&'static str> {
        let k = quantiles::coverage_factor(level, self.dof)?;
        ((self.k / k - 1.0).abs() < SAME).then(|| distribution(self.dof))
    }
}

/// The conformity of a quantity as its metadata; nothing where it has no limits.
fn verdict(conformity: &ConformityReport, id: &str, texts: Texts<'_>) -> Option<Element> {
    let limited = conformity.quantities.iter().find(|q| q.id == id)?;
    let limits = [(limited.lower, true), (limited.upper, false)].into_iter().filter_map(|(limit, lower)| {
        let name = texts
            .said("dcc:name", |lang| if lower { say!(lang, "lower-limit") } else { say!(lang, "upper-limit") }.into());
        Some(element("dcc:quantity").add(name).add(real(None, decimal(limit?), &units::d_si(&[&limited.unit]))))
    });
    let data = element("dcc:metaData")
        .of_type(Some("basic_conformity"))
        .add(texts.said("dcc:declaration", |lang| declaration(conformity, limited, lang)))
        .add(text("dcc:conformity", status(limited)))
        .add(element("dcc:data").add(limits));
    Some(element("dcc:measurementMetaData").add(data))
}

/// The outcome in words, with the rule and the probability that it rests on.
fn declaration(conformity: &ConformityReport, limited: &LimitedReport, lang: Language) -> String {
    let outcome = lang.term(limited.outcome.name());
    let mut said = say!(lang, "conformity-is", outcome, rule = conformity.rule);
    if let Some(probability) = limited.probability {
        said.push_str(lang.space());
        let probability = format!("{}{}{}", say!(lang, "probability"), lang.colon(), percent(probability));
        said.push_str(&lang.sentence(&lang.title(&probability)));
    }
    said
}

/// The schema's word: an undecided quantity is a conditional pass where its estimate is inside the limits, else a conditional fail.
fn status(limited: &LimitedReport) -> &'static str {
    let inside = limited.value.is_some_and(|value| {
        limited.lower.is_none_or(|low| value >= low) && limited.upper.is_none_or(|high| value <= high)
    });
    match (limited.outcome, inside) {
        (Conformity::Pass, _) => "pass",
        (Conformity::Fail, _) => "fail",
        (Conformity::Undecided, true) => "conditionalPass",
        (Conformity::Undecided, false) => "conditionalFail",
    }
}

/// The joint region: covariance and the factor of its ellipsoid, `k^2 = n F(level; n, nu)` with the smallest degrees of freedom (GUM
/// Supplement 2, 6.5.3 for the normal: `k^2` the chi-square quantile).
fn covariance(report: &FitReport, quantities: &[Quantity], texts: Texts<'_>) -> Option<Element> {
    let joint: Vec<(&Quantity, usize)> = quantities.iter().filter_map(|q| Some((q, q.index?))).collect();
    let at = |i: usize, j: usize| report.covariance.matrix.get(i).and_then(|row| row.get(j)).copied().flatten();
    // column by column; nothing where an element is missing
    let column = |(_, j): &(&Quantity, usize)| joint.iter().map(|(_, i)| at(*i, *j)).collect::<Option<Vec<f64>>>();
    let columns = joint.iter().map(column).collect::<Option<Vec<_>>>()?;
    let level = report.level();
    let dof = joint.iter().map(|(q, _)| q.dof).fold(f64::INFINITY, f64::min);
    let n = joint.len() as f64;
    let square = match dof.is_finite() {
        true => quantiles::fisher_f_quantile(level, n, dof).map(|f| n * f),
        false => quantiles::chi_square_quantile(level, n),
    };
    let factor = square.map(f64::sqrt).filter(|k| k.is_finite() && *k >= 1.0);
    let factor = factor.filter(|_| joint.len() > 1)?;
    let list = |of: &dyn Fn(&Quantity) -> String| joint.iter().map(|(q, _)| of(q)).collect::<Vec<_>>().join(" ");
    let columns = joint.iter().zip(&columns).map(|((a, _), column)| {
        element("si:column").add(joint.iter().zip(column).map(|((b, _), value)| {
            element("si:covariance")
                .add(text("si:value", decimal(*value)))
                .add(text("si:unit", units::d_si(&[&a.unit, &b.unit])))
        }))
    });
    let region = element("si:ellipsoidalRegionXMLList")
        .add(element("si:covarianceMatrix").add(columns))
        .add(text("si:coverageFactor", plain(factor)))
        .add(text("si:coverageProbability", plain(level)))
        .add(text("si:distribution", distribution(dof)));
    let list = element("si:realListXMLList")
        .add(text("si:labelXMLList", list(&|q| q.id.clone())))
        .add(text("si:valueXMLList", list(&|q| decimal(q.value))))
        .add(text("si:unitXMLList", list(&|q| units::d_si(&[&q.unit]))))
        .add(region);
    let quantity = element("dcc:quantity").add(texts.said("dcc:name", |lang| say!(lang, "estimates").into())).add(list);
    let name = texts.said("dcc:name", |lang| say!(lang, "dcc-covariance").into());
    Some(element("dcc:result").add(name).add(element("dcc:data").add(quantity)))
}

/// The correction to apply, as a result of its own, and where it holds: `inputs = matrix (readings - bias)`, a quantity for the bias and one for each
/// row; nothing where nothing is corrected.
fn matrix(correction: &CorrectionFile, prefix: &str, texts: Texts<'_>) -> Option<Element> {
    let solved: Vec<_> = correction.inputs.iter().filter(|input| input.solved).zip(&correction.matrix).collect();
    if solved.is_empty() || correction.sensors.is_empty() {
        return None;
    }
    let sensors: Vec<&str> = correction.sensors.iter().map(|sensor| sensor.sensor.as_str()).collect();
    let unit = |input: &str, sensor: &str| match (input, sensor) {
        (input, "") => units::d_si(&[input]),
        ("", sensor) => units::d_si(&[&format!("1/({sensor})")]),
        (input, sensor) => units::d_si(&[&format!("({input})/({sensor})")]),
    };
    // one list of numbers, each with the sensor that it belongs to and its unit
    let row = |id: String, name: Element, values: &[f64], units: Vec<String>| {
        let values: Vec<String> = values.iter().map(|value| decimal(*value)).collect();
        let list = element("si:realListXMLList")
            .add(text("si:labelXMLList", sensors.join(" ")))
            .add(text("si:valueXMLList", values.join(" ")))
            .add(text("si:unitXMLList", units.join(" ")));
        element("dcc:quantity").with("id", id).add(name).add(list)
    };
    let bias = row(
        format!("{prefix}correction_bias"),
        texts.said("dcc:name", |lang| say!(lang, "bias").into()),
        &correction.bias,
        correction.sensors.iter().map(|sensor| units::d_si(&[&sensor.unit])).collect(),
    );
    let rows = solved.into_iter().map(|(input, values)| {
        let name = texts.said("dcc:name", |lang| say!(lang, "dcc-row", input = input.name));
        let units = correction.sensors.iter().map(|sensor| unit(&input.unit, &sensor.unit)).collect();
        row(format!("{prefix}correction_{}", input.name), name, values, units)
    });
    let about = texts.said("dcc:description", |lang| {
        let about = say!(lang, "dcc-correction", frame = lang.name(&correction.frame));
        let said = [Some(about), given_at(correction, lang), Some(validity_sentence(correction, lang))];
        said.into_iter().flatten().collect::<Vec<_>>().join(lang.space())
    });
    let name = texts.said("dcc:name", |lang| say!(lang, "the-correction-to-apply").into());
    Some(element("dcc:result").add(name).add(about).add(element("dcc:data").add(bias).add(rows)))
}

/// What scatters, each source with its standard deviation; nothing where there is only the readings' own noise.
fn scattering(report: &FitReport, prefix: &str, texts: Texts<'_>) -> Option<Element> {
    let sources = report.scatter.iter().filter_map(|source| Some((source, source.sd?)));
    let sources = sources.enumerate().map(|(k, (source, sd))| {
        element("dcc:quantity")
            .with("id", format!("{prefix}scatter_{}", k + 1))
            .add(texts.said("dcc:name", |lang| scatter::source_name(&source.source, lang)))
            .add(texts.said("dcc:description", |lang| about_source(source, lang)))
            .add(real(Some(&source.of), decimal(sd), &units::d_si(&[&source.unit])))
    });
    let sources: Vec<Element> = sources.collect();
    if !scatter::is_worth_a_table(&report.scatter) || sources.is_empty() {
        return None;
    }
    let name = texts.said("dcc:name", |lang| say!(lang, "what-scatters").into());
    let about = texts.said("dcc:description", |lang| say!(lang, "sd-standard-deviation-of-one-deviation-a").into());
    Some(element("dcc:result").add(name).add(about).add(element("dcc:data").add(sources)))
}

fn about_source(source: &ScatterReport, lang: Language) -> String {
    let values = format!("{}{}{}", say!(lang, "values"), lang.colon(), source.levels);
    let mut clauses = vec![lang.term(source.from.name()), values];
    clauses.extend(source.u_sd.map(|u| format!("{} {}", say!(lang, "standard-uncertainty"), decimal(u))));
    let mut said = clauses.join(lang.clause());
    if let Some(note) = &source.note {
        said.push_str(&format!("{}{}", lang.semicolon(), note.say(lang)));
    }
    said
}

/// Value and U: U with two significant digits, the value with the same decimal places (GUM 7.2.6).
fn to_two_digits(value: f64, expanded: f64) -> [String; 2] {
    let Some(places) = places(expanded) else { return [value, expanded].map(decimal) };
    let exponent = 1 - places;
    let rounded = |x: f64| match places {
        0..=12 => format!("{x:.*}", number::unsigned(places)),
        _ => format!("{:.1}e{exponent}", x / 10f64.powi(exponent)),
    };
    let without_sign = |text: String| match text.bytes().any(|b| b.is_ascii_digit() && b != b'0') {
        false => text.trim_start_matches('-').to_string(),
        true => text,
    };
    [rounded(value), rounded(expanded)].map(without_sign)
}

/// A number as `si:decimalType` has it: digits, point, exponent.
fn decimal(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e9).contains(&value.abs()) { format!("{value:e}") } else { value.to_string() }
}

/// A number without exponent, as factors and probabilities must be.
fn plain(value: f64) -> String {
    let text = format!("{value:.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
