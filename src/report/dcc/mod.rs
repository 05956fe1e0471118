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
mod results;
mod units;
mod xml;

use super::fit_document::{estimated, verdicts};
use super::{ArcsecReport, FitReport, VERSION};
use crate::campaign::{Identity, Kind};
use crate::error::{Fault, Malformed, Result};
use crate::fit::{Fit, State};
use crate::language::{Language, Sentence};
use crate::wire::LabFile;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use results::Adjusted;
use std::io;
use xml::{Element, Texts, element};

/// Version of the schema that certificates follow.
pub(crate) const SCHEMA_VERSION: &str = "3.3.0";

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
    let meaning = |id: &str| fit.parameters.iter().find(|p| p.id == id).map_or("", |p| p.meaning.as_str());
    let title = match fit.campaign.bench.title.as_str() {
        "" => report.bench.as_str(),
        title => title,
    };
    let after = as_found.map(|_| Adjusted::After);
    // what is wrong with the calibration is said before what is wrong with the one as found
    let calibration = Measured { report, adjusted: after, prefix: "", quantities: quantities(&meaning, report)? };
    let mut results = vec![calibration];
    if let Some(report) = as_found {
        let (adjusted, quantities) = (Some(Adjusted::Before), quantities(&meaning, report)?);
        results.insert(0, Measured { report, adjusted, prefix: "found_", quantities });
    }
    let identities: Vec<&Identity> = results.iter().map(|result| &result.report.identity).collect();
    let lab = &lab.clone().with(&identities)?;
    let texts = Texts { lang, lab: &lab.certificate.language };
    let measured = results.iter().map(|result| results::measured(title, result, lab, texts));
    let whole = element("dcc:digitalCalibrationCertificate")
        .with("xmlns:dcc", "https://ptb.de/dcc")
        .with("xmlns:si", "https://ptb.de/si")
        .with("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance")
        .with("xsi:schemaLocation", "https://ptb.de/dcc https://ptb.de/dcc/v3.3.0/dcc.xsd")
        .with("schemaVersion", SCHEMA_VERSION)
        .add(administrative::data(lab, &identities, texts))
        .add(element("dcc:measurementResults").add(measured));
    let text = written(&whole).ok().and_then(|xml| String::from_utf8(xml).ok());
    text.map(|text| text + "\n").ok_or_else(|| Malformed::new(Fault::Value, "the certificate cannot be written as XML"))
}

fn written(whole: &Element) -> io::Result<Vec<u8>> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 1);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    whole.write(&mut xml)?;
    Ok(xml.into_inner())
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
    /// Its coverage interval where that is not `value - U` to `value + U`, in `unit`.
    interval: Option<[f64; 2]>,
    note: Option<Sentence>,
    /// Index in the covariance matrix.
    index: Option<usize>,
}

fn quantities<'a>(meaning: &dyn Fn(&str) -> &'a str, report: &FitReport) -> Result<Vec<Quantity>> {
    for p in report.parameters.iter().filter(|p| p.value.is_some()) {
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
        uncertainty(&p.id, p.combined.expanded, p.combined.k)?;
    }
    let parameters = report.parameters.iter().enumerate().map(|(k, p)| {
        let numbers = (p.value, p.combined);
        (&p.id, meaning(&p.id).to_string(), &p.unit, numbers, p.arcsec, (Some(k), None, None))
    });
    let derived = report.derived.iter().map(|d| {
        let numbers = (d.value, d.combined);
        (&d.id, format!("{} = {}", d.id, d.line), &d.unit, numbers, d.arcsec, (None, d.interval, d.note.clone()))
    });
    let mut quantities = Vec::new();
    for (id, meaning, unit, (value, combined), arcsec, (index, interval, note)) in parameters.chain(derived) {
        let Some(value) = value else { continue };
        let (expanded, k) = uncertainty(id, combined.expanded, combined.k)?;
        let (id, unit, dof) = (id.clone(), unit.clone(), combined.dof.unwrap_or(f64::INFINITY));
        quantities.push(Quantity { id, meaning, unit, value, expanded, k, dof, arcsec, interval, note, index });
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
