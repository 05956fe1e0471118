//! The digital calibration certificate (`--dcc`): XML by PTB's schema 3.3.0 with quantities in D-SI 2.
//!
//! ```text
//! digitalCalibrationCertificate
//!   administrativeData   software, core data, items, laboratory, persons, customer, statements: from the lab file, with the campaign's unit, date, operator
//!   measurementResults   method, instruments, conditions; one result with a quantity for each estimate (value, U, k, level), one with the covariance, one with the correction
//! ```
//!
//! With a calibration as found there are two measurement results, before and after adjustment. Each has its conditions, conformity beside the
//! quantity that it is about, and the correction as bias and matrix.
//!
//! <https://ptb.de/dcc/v3.3.0/>; element names and order follow `dcc.xsd` 3.3.0 and `SI_Format.xsd` 2.2. Angles are given in radians and in
//! arcseconds (`si:hybrid`). U has two significant digits, its value the same decimal places; covariances and the correction have all
//! digits. `refType`s are those of PTB's lists of good practice, and the rules of its Schematron hold. Deliberately absent: signatures and seals (a certificate is signed with the laboratory's own means), invented
//! identities, a certificate of estimates without uncertainty.

mod administrative;
mod conditions;
mod covariance;
mod matrix;
mod texts;
mod units;
mod verdicts;

use super::fit_document::{estimated, global_test, not_estimable};
use super::{ArcsecReport, FitReport, VERSION};
use crate::campaign::{Identity, Kind};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{Estimator, Fit, State};
use crate::language::{Language, say};
use crate::number;
use crate::wire::LabFile;
use conditions::Adjusted;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;
use texts::{Texts, Xml, text, told, within};

/// Version of the schema that certificates follow.
pub const SCHEMA_VERSION: &str = "3.3.0";

/// A fit as a digital calibration certificate, with the identities of a lab file; `as_found` is the report of the same unit before it was
/// adjusted.
///
/// Errors: a campaign that contradicts the lab file,  an estimate without uncertainty or held by a bound, a coverage factor below 1 (the schema has none), a coefficient whose unit is not known.
pub fn certificate(
    fit: &Fit,
    report: &FitReport,
    as_found: Option<&FitReport>,
    lab: &LabFile,
    lang: Language,
) -> Result<String> {
    let meaning = |id: &str| fit.parameters.iter().find(|own| own.id == id).map_or("", |own| own.meaning.as_str());
    let title = match fit.campaign.bench.title.as_str() {
        "" => report.bench.as_str(),
        title => title,
    };
    let adjusted = as_found.map(|_| Adjusted::After);
    let own = Measured { report, adjusted, prefix: "", quantities: quantities(&meaning, report)? };
    let found = match as_found {
        Some(found) => Some(Measured {
            report: found,
            adjusted: Some(Adjusted::Before),
            prefix: "found_",
            quantities: quantities(&meaning, found)?,
        }),
        None => None,
    };
    let results: Vec<Measured<'_>> = found.into_iter().chain([own]).collect();
    let lab = &lab.clone().with(&identities(&results))?;
    let texts = Texts::new(lang, &lab.certificate.language);
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 1);
    let written = write(&mut xml, title, &results, lab, texts);
    let text = written.ok().and_then(|()| String::from_utf8(xml.into_inner()).ok());
    text.map(|text| text + "\n").ok_or_else(|| Malformed::new(Fault::Value, "the certificate cannot be written as XML"))
}

/// One measurement result of the certificate.
struct Measured<'a> {
    report: &'a FitReport,
    adjusted: Option<Adjusted>,
    /// Before the ids of its elements.
    prefix: &'static str,
    quantities: Vec<Quantity>,
}

/// A quantity of the certificate.
struct Quantity {
    id: String,
    meaning: String,
    unit: String,
    value: f64,
    expanded: f64,
    k: f64,
    dof: f64,
    arcsec: Option<ArcsecReport>,
    /// Index in the covariance matrix.
    index: Option<usize>,
}

fn quantities<'a>(meaning: &dyn Fn(&str) -> &'a str, report: &FitReport) -> Result<Vec<Quantity>> {
    let mut quantities = Vec::new();
    for (k, p) in report.parameters.iter().enumerate() {
        let Some(value) = p.value else { continue };
        if p.kind != Kind::Tilt && p.unit.is_empty() {
            return Err(Malformed::new(Fault::Missing, format!("a certificate needs the unit of '{}'", p.id))
                .expected(format!("\"unit\" in estimate.{}, or in the bench; \"1\" for a pure number", p.id))
                .at_path(format!("estimate.{}", p.id)));
        }
        if p.state == State::AtBound {
            return Err(Malformed::new(Fault::Value, format!("'{}' is held by a bound, so no U describes it", p.id))
                .expected("a campaign whose bounds are not active; the JSON report has the interval")
                .at_path("constraints"));
        }
        let (expanded, factor) = uncertainty(&p.id, p.expanded, p.k)?;
        quantities.push(Quantity {
            id: p.id.clone(),
            meaning: meaning(&p.id).to_string(),
            unit: p.unit.clone(),
            value,
            expanded,
            k: factor,
            dof: p.dof.unwrap_or(f64::INFINITY),
            arcsec: p.arcsec,
            index: Some(k),
        });
    }
    for d in &report.derived {
        let Some(value) = d.value else { continue };
        let (expanded, factor) = uncertainty(&d.id, d.expanded, d.k)?;
        quantities.push(Quantity {
            id: d.id.clone(),
            meaning: format!("{} = {}", d.id, d.line),
            unit: d.unit.clone(),
            value,
            expanded,
            k: factor,
            dof: d.dof.unwrap_or(f64::INFINITY),
            arcsec: d.arcsec,
            index: None,
        });
    }
    if quantities.is_empty() {
        return Err(Malformed::new(Fault::Value, "nothing is estimable, so there is nothing to certify")
            .expected("readings that determine at least one parameter")
            .at_path("readings"));
    }
    Ok(quantities)
}

fn uncertainty(id: &str, expanded: Option<f64>, k: Option<f64>) -> Result<(f64, f64)> {
    let Some((expanded, k)) = expanded.zip(k).filter(|(expanded, k)| expanded.is_finite() && k.is_finite()) else {
        return Err(Malformed::new(Fault::Value, format!("'{id}' has no uncertainty, so it cannot be certified"))
            .expected("more readings than unknowns, or a stated uncertainty of the readings")
            .at_path("readings"));
    };
    if k < 1.0 {
        return Err(Malformed::new(Fault::Value, format!("the coverage factor of '{id}' is below 1"))
            .expected("a level of at least 0.683; a certificate's schema has no smaller factor")
            .found(format!("k = {k:.3}")));
    }
    Ok((expanded, k))
}

fn write(xml: &mut Xml, title: &str, results: &[Measured<'_>], lab: &LabFile, texts: Texts<'_>) -> io::Result<()> {
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let attributes = [
        ("xmlns:dcc", "https://ptb.de/dcc"),
        ("xmlns:si", "https://ptb.de/si"),
        ("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"),
        ("xsi:schemaLocation", "https://ptb.de/dcc https://ptb.de/dcc/v3.3.0/dcc.xsd"),
        ("schemaVersion", SCHEMA_VERSION),
    ];
    xml.create_element("dcc:digitalCalibrationCertificate").with_attributes(attributes).write_inner_content(|xml| {
        administrative::write(xml, lab, &identities(results), texts)?;
        within(xml, "dcc:measurementResults", |xml| {
            results.iter().try_for_each(|own| measured(xml, title, own, lab, texts))
        })
    })?;
    Ok(())
}

fn measured(xml: &mut Xml, title: &str, own: &Measured<'_>, lab: &LabFile, texts: Texts<'_>) -> io::Result<()> {
    let report = own.report;
    within(xml, "dcc:measurementResult", |xml| {
        told(xml, "dcc:name", texts, |lang| match own.adjusted {
            Some(adjusted) => {
                format!("{}{}{}", lang.name(title), lang.colon(), adjusted.said(lang))
            }
            None => lang.name(title).into_owned(),
        })?;
        if let Some(place) = &report.identity.place {
            texts.own(xml, "dcc:description", place)?;
        }
        administrative::method_and_equipment(xml, lab, &report.identity, texts)?;
        conditions::write(xml, &report.identity, own.adjusted, texts)?;
        within(xml, "dcc:results", |xml| {
            estimates(xml, own, texts)?;
            covariance::write(xml, report, &own.quantities, texts)?;
            matrix::write(xml, report.correction.as_ref(), own.prefix, texts)?;
            scatter(xml, report, own.prefix, texts)
        })
    })
}

fn estimates(xml: &mut Xml, own: &Measured<'_>, texts: Texts<'_>) -> io::Result<()> {
    within(xml, "dcc:result", |xml| {
        told(xml, "dcc:name", texts, |lang| say!(lang, "estimates").into())?;
        told(xml, "dcc:description", texts, |lang| remarks(own.report, lang).join(lang.space()))?;
        within(xml, "dcc:data", |xml| {
            own.quantities.iter().try_for_each(|quantity| self::quantity(xml, own, quantity, texts))
        })
    })
}

/// What a reader must know to use the numbers.
fn remarks(report: &FitReport, lang: Language) -> Vec<String> {
    let models: Vec<String> = report.model.iter().map(|(sensor, line)| format!("{sensor} = {line}")).collect();
    let models = format!("{}{}{}", say!(lang, "model"), lang.colon(), models.join(lang.semicolon()));
    let mut remarks = vec![lang.sentence(&models), estimated(report, lang)];
    remarks.push(say!(lang, "rows-are-exact-derivatives", iterated = report.estimator == Estimator::Exact));
    if !report.known.is_empty() {
        let known: Vec<String> =
            report.known.iter().map(|k| format!("{} = {} {} (u = {})", k.id, k.value, k.unit, k.u)).collect();
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
    remarks.extend(not_estimable(report, lang));
    if let Some(robust) = &report.robust {
        remarks.push(say!(lang, "robust-estimator", method = robust.method.to_string()));
    }
    remarks.extend(report.fit.remarks.iter().map(|remark| lang.sentence(&remark.say(lang))));
    remarks.extend(global_test(report, lang).map(|(_, said)| said));
    remarks
}

/// What scatters, each source with its standard deviation; nothing where there is only the readings' own noise.
fn scatter(xml: &mut Xml, report: &FitReport, prefix: &str, texts: Texts<'_>) -> io::Result<()> {
    let with_sd = || report.scatter.iter().filter_map(|source| Some((source, source.sd?)));
    if !super::scatter::is_worth_a_table(&report.scatter) || with_sd().next().is_none() {
        return Ok(());
    }
    within(xml, "dcc:result", |xml| {
        told(xml, "dcc:name", texts, |lang| say!(lang, "what-scatters").into())?;
        told(xml, "dcc:description", texts, |lang| say!(lang, "sd-standard-deviation-of-one-deviation-a").into())?;
        within(xml, "dcc:data", |xml| {
            for (k, (source, sd)) in with_sd().enumerate() {
                let id = format!("{prefix}scatter_{}", k + 1);
                xml.create_element("dcc:quantity").with_attribute(("id", id.as_str())).write_inner_content(|xml| {
                    told(xml, "dcc:name", texts, |lang| super::scatter::source_name(&source.source, lang))?;
                    told(xml, "dcc:description", texts, |lang| about_source(source, lang))?;
                    within(xml, "si:real", |xml| {
                        text(xml, "si:label", &source.of)?;
                        text(xml, "si:value", &decimal(sd))?;
                        text(xml, "si:unit", &units::d_si(&[&source.unit]))
                    })
                })?;
            }
            Ok(())
        })
    })
}

fn about_source(source: &super::ScatterReport, lang: Language) -> String {
    let values = format!("{}{}{}", say!(lang, "values"), lang.colon(), source.levels);
    let mut clauses = vec![lang.term(source.from.name()), values];
    clauses.extend(source.u_sd.map(|u| format!("{} {}", say!(lang, "standard-uncertainty"), decimal(u))));
    let mut said = clauses.join(lang.clause());
    if let Some(note) = &source.note {
        said.push_str(&format!("{}{}", lang.semicolon(), note.say(lang)));
    }
    said
}

fn quantity(xml: &mut Xml, own: &Measured<'_>, quantity: &Quantity, texts: Texts<'_>) -> io::Result<()> {
    let level = own.report.parameters.first().map_or(0.95, |p| p.level);
    let id = format!("{}quantity_{}", own.prefix, quantity.id);
    let attributes = [("id", id.as_str()), ("refType", "basic_measuredValue")];
    xml.create_element("dcc:quantity").with_attributes(attributes).write_inner_content(|xml| {
        texts.own(xml, "dcc:name", &quantity.id)?;
        if !quantity.meaning.is_empty() {
            told(xml, "dcc:description", texts, |lang| lang.name(&quantity.meaning).into_owned())?;
        }
        match quantity.arcsec.and_then(|a| a.value.zip(a.expanded)) {
            Some((value, expanded)) => within(xml, "si:hybrid", |xml| {
                real(xml, quantity, (quantity.value, quantity.expanded, &quantity.unit), level)?;
                real(xml, quantity, (value, expanded, "arcsec"), level)
            })?,
            None => real(xml, quantity, (quantity.value, quantity.expanded, &quantity.unit), level)?,
        }
        verdicts::of_quantity(xml, own.report.conformity.as_ref(), &quantity.id, texts)
    })?;
    Ok(())
}

fn real(xml: &mut Xml, quantity: &Quantity, (value, expanded, unit): (f64, f64, &str), level: f64) -> io::Result<()> {
    within(xml, "si:real", |xml| {
        text(xml, "si:label", &quantity.id)?;
        let [value, expanded] = to_two_digits(value, expanded);
        text(xml, "si:value", &value)?;
        text(xml, "si:unit", &units::d_si(&[unit]))?;
        within(xml, "si:measurementUncertaintyUnivariate", |xml| {
            within(xml, "si:expandedMU", |xml| {
                text(xml, "si:valueExpandedMU", &expanded)?;
                text(xml, "si:coverageFactor", &plain(quantity.k))?;
                text(xml, "si:coverageProbability", &plain(level))?;
                text(xml, "si:distribution", if quantity.dof.is_finite() { "t" } else { "normal" })
            })
        })
    })
}

/// Value and U: U with two significant digits, the value with the same decimal places (GUM 7.2.6).
fn to_two_digits(value: f64, expanded: f64) -> [String; 2] {
    let Some(places) = crate::document::number::places(expanded) else { return [value, expanded].map(decimal) };
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

fn identities<'a>(results: &'a [Measured<'a>]) -> Vec<&'a Identity> {
    results.iter().map(|own| &own.report.identity).collect()
}
