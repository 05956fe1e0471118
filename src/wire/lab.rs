//! The lab file (`--lab`): the identities that a calibration certificate needs and that no program may invent.

use super::locate::in_source;
use super::{Source, parse};
use crate::campaign::{Identity, UnitUnderTest, day};
use crate::error::{Fault, Malformed, Result};
use crate::vocabulary::vocabulary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Who calibrated what for whom, when and where.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LabFile {
    /// Where it was read: faults of its own are located there.
    #[serde(skip)]
    pub(super) source: Source,
    /// The certificate itself.
    pub certificate: CertificateFile,
    /// The calibration laboratory.
    pub laboratory: ContactFile,
    /// Persons responsible; at least one.
    pub persons: Vec<PersonFile>,
    /// The customer.
    pub customer: ContactFile,
    /// What was calibrated; without it the unit under test of the campaign.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub items: Vec<ItemFile>,
    /// Standards and equipment used.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub equipment: Vec<ItemFile>,
    /// The calibration method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<MethodFile>,
    /// Statements of the laboratory, for example on traceability.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statements: Vec<String>,
}

/// The certificate's own data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CertificateFile {
    /// Its unique identifier.
    pub id: String,
    /// Country of issue, two capital letters (ISO 3166-1).
    pub country: String,
    /// Language of the texts in this file, two small letters (ISO 639-1).
    #[serde(default = "english")]
    pub language: String,
    /// Day on which the items were received, `YYYY-MM-DD`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub received: Option<String>,
    /// First day of the calibration; the campaign's date unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub begin: Option<String>,
    /// Last day of the calibration; the campaign's date unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<String>,
    /// Day of issue.
    pub issued: String,
    /// Where the calibration was performed.
    pub location: LocationFile,
}

fn english() -> String {
    "en".into()
}

vocabulary! {
    /// Where a calibration was performed.
    LocationFile {
        /// In the laboratory.
        Laboratory = "laboratory",
        /// At the customer's.
        Customer = "customer",
        /// In a branch of the laboratory.
        LaboratoryBranch = "laboratoryBranch",
        /// In a branch of the customer's.
        CustomerBranch = "customerBranch",
        /// Elsewhere.
        Other = "other",
    }
}

/// An organisation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactFile {
    /// Name.
    pub name: String,
    /// Accreditation code, for a laboratory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// Electronic mail.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub email: Option<String>,
    /// Telephone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phone: Option<String>,
    /// Postal address.
    pub address: AddressFile,
}

/// A postal address.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AddressFile {
    /// City.
    pub city: String,
    /// Country, two capital letters (ISO 3166-1).
    pub country: String,
    /// Postal code.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub post_code: Option<String>,
    /// Street.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub street: Option<String>,
    /// Number in the street.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
}

/// A responsible person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PersonFile {
    /// Name.
    pub name: String,
    /// Role, for example `head of laboratory`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// Does this person sign?
    #[serde(default)]
    pub main_signer: bool,
}

/// A calibrated item or a piece of equipment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ItemFile {
    /// Name.
    pub name: String,
    /// Manufacturer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manufacturer: Option<String>,
    /// Model or type.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Serial numbers and the like; at least one for a calibrated item.
    pub identifications: Vec<IdentificationFile>,
}

/// A serial number or the like.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentificationFile {
    /// Who gave it.
    pub issuer: IssuerFile,
    /// The number.
    pub value: String,
    /// What it is, for example `serial number`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

vocabulary! {
    /// Who gave an identification.
    IssuerFile {
        /// The manufacturer.
        Manufacturer = "manufacturer",
        /// The calibration laboratory.
        CalibrationLaboratory = "calibrationLaboratory",
        /// The customer.
        Customer = "customer",
        /// The owner.
        Owner = "owner",
        /// Someone else.
        Other = "other",
    }
}

/// A calibration method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MethodFile {
    /// Name.
    pub name: String,
    /// Standards that it follows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub norms: Vec<String>,
}

/// Read a lab file.
///
/// Errors: a missing or unknown key, an empty text, a code or date that is none, a character that XML cannot hold; each with its place.
///
/// ```
/// let source = tumble::wire::Source { name: "lab.json".into(), text: "{ \"certificate\": {} }".into() };
/// let error = tumble::wire::read_lab(&source).unwrap_err();
/// assert_eq!(error.fault(), tumble::error::Fault::Missing);
/// assert!(error.what().contains("id"));
/// ```
pub fn read_lab(source: &Source) -> Result<LabFile> {
    let lab = LabFile { source: source.clone(), ..parse(source)? };
    check(&lab).map_err(|error| in_source(error, source))?;
    Ok(lab)
}

impl LabFile {
    /// The lab file with what the campaigns of the certificate say: the unit under test, the dates, the operators.
    ///
    /// Errors: what a campaign says is not what the lab file says; what neither says.
    pub fn with(mut self, campaigns: &[&Identity]) -> Result<LabFile> {
        for identity in campaigns {
            if let Some(unit) = &identity.unit {
                self.item(unit)?;
            }
            if let Some(operator) =
                identity.operator.as_ref().filter(|name| self.persons.iter().all(|p| p.name != **name))
            {
                let (name, role) = (operator.clone(), Some("operator".into()));
                self.persons.push(PersonFile { name, role, main_signer: false });
            }
        }
        let has_serial = |identity: &&&Identity| identity.unit.as_ref().is_some_and(|unit| unit.serial.is_some());
        if (1..campaigns.len()).contains(&campaigns.iter().filter(has_serial).count()) {
            return Err(contradiction("one of the two results does not say which unit it is of", "unit.serial")
                .expected("the serial number in both: as found and as left"));
        }
        some(&self.items, "items", "\"items\" in the lab file, or \"unit\" with its serial number in the campaign")?;
        let dates: Vec<&str> = campaigns.iter().filter_map(|campaign| campaign.date.as_deref().and_then(day)).collect();
        let certificate = &mut self.certificate;
        for date in &dates {
            let before = certificate.begin.as_deref().is_some_and(|begin| *date < begin);
            if before || certificate.end.as_deref().is_some_and(|end| *date > end) {
                let said = |day: &Option<String>| day.clone().unwrap_or_else(|| "any day".into());
                return Err(contradiction("the campaign's date is not within the certificate's days", "date")
                    .expected(format!("{} to {}, as in the lab file", said(&certificate.begin), said(&certificate.end)))
                    .found(date.to_string()));
            }
        }
        certificate.begin = certificate.begin.take().or_else(|| dates.iter().min().map(|day| day.to_string()));
        certificate.end = certificate.end.take().or_else(|| dates.iter().max().map(|day| day.to_string()));
        if certificate.begin.is_none() || certificate.end.is_none() {
            return Err(Malformed::new(Fault::Missing, "the days of the calibration are not known")
                .expected(
                    "\"begin\" and \"end\" in the lab file's certificate, or \"date\" (YYYY-MM-DD) in the campaign",
                )
                .at_path("date"));
        }
        days(certificate).map_err(|error| in_source(error, &self.source))?;
        Ok(self)
    }

    /// The unit under test is one of the items, or the only one where none is named.
    fn item(&mut self, unit: &UnitUnderTest) -> Result<()> {
        if self.items.is_empty() {
            let identifications = unit.serial.iter().map(|serial| IdentificationFile {
                issuer: IssuerFile::Manufacturer,
                value: serial.clone(),
                name: Some("serial number".into()),
            });
            let identifications: Vec<IdentificationFile> = identifications.collect();
            some(&identifications, "unit", "\"serial\" of the unit, or \"items\" in the lab file")?;
            let name = unit.kind.clone().or_else(|| unit.serial.clone()).unwrap_or_default();
            let (manufacturer, model) = (unit.manufacturer.clone(), unit.kind.clone());
            self.items.push(ItemFile { name, manufacturer, model, identifications });
            return Ok(());
        }
        let has = |item: &ItemFile, serial: &str| item.identifications.iter().any(|i| i.value == serial);
        let item = match (&unit.serial, self.items.as_slice()) {
            (Some(serial), items) => {
                let found = items.iter().find(|item| has(item, serial));
                let named = || items.iter().flat_map(|item| &item.identifications).map(|i| i.value.as_str());
                Some(found.ok_or_else(|| {
                    contradiction("the campaign's unit is none of the lab file's items", "unit.serial")
                        .expected(format!("one of {}", named().collect::<Vec<_>>().join(", ")))
                        .found(format!("'{serial}'"))
                })?)
            }
            (None, [only]) => Some(only),
            (None, _) => None,
        };
        let Some(item) = item else { return Ok(()) };
        for (key, stated, theirs) in [
            ("type", &unit.kind, item.model.as_ref().or(Some(&item.name))),
            ("manufacturer", &unit.manufacturer, item.manufacturer.as_ref()),
        ] {
            if let (Some(stated), Some(theirs)) = (stated, theirs)
                && stated != theirs
                && !(key == "type" && *stated == item.name)
            {
                return Err(contradiction(
                    &format!("the campaign's unit has another {key} than the lab file's item"),
                    &format!("unit.{key}"),
                )
                .expected(format!("'{theirs}'"))
                .found(format!("'{stated}'")));
            }
        }
        Ok(())
    }
}

fn contradiction(what: &str, path: &str) -> Malformed {
    Malformed::new(Fault::Value, what).at_path(path)
}

fn days(certificate: &CertificateFile) -> Result<()> {
    let issued = Some(&certificate.issued);
    let days = [
        ("received", certificate.received.as_ref()),
        ("begin", certificate.begin.as_ref()),
        ("end", certificate.end.as_ref()),
        ("issued", issued),
    ];
    let said: Vec<(&str, &String)> = days.into_iter().filter_map(|(key, day)| Some((key, day?))).collect();
    for (key, day) in &said {
        date(day, &format!("certificate.{key}"))?;
    }
    for ((before, first), (after, second)) in said.iter().zip(said.iter().skip(1)) {
        if first > second {
            return Err(Malformed::new(Fault::Value, format!("the certificate's {after} is before its {before}"))
                .expected(format!("{first} or later"))
                .found(second.to_string())
                .at_path(format!("certificate.{after}")));
        }
    }
    Ok(())
}

fn check(lab: &LabFile) -> Result<()> {
    let certificate = &lab.certificate;
    for (value, path) in [
        (&certificate.country, "certificate.country"),
        (&lab.laboratory.address.country, "laboratory.address.country"),
        (&lab.customer.address.country, "customer.address.country"),
    ] {
        code(value, path, "two capital letters, for example DE", char::is_uppercase)?;
    }
    code(&certificate.language, "certificate.language", "two small letters, for example en", char::is_lowercase)?;
    days(certificate)?;
    some(&lab.persons, "persons", "a responsible person")?;
    if !lab.persons.iter().any(|person| person.main_signer) {
        return Err(Malformed::new(Fault::Missing, "nobody signs the certificate")
            .expected("\"main_signer\": true for the person who signs")
            .found("no person who does")
            .at_path("persons"));
    }
    for (k, entry) in lab.items.iter().enumerate() {
        let path = format!("items[{k}].identifications");
        some(&entry.identifications, &path, "a serial number or other identification")?;
    }
    // texts, lists and words: each has its JSON
    texts(&serde_json::to_value(lab).unwrap_or_default(), "")
}

/// Every text of a file says something.
fn texts(value: &Value, path: &str) -> Result<()> {
    match value {
        Value::String(string) => text(string, path),
        Value::Array(list) => list.iter().zip(0..).try_for_each(|(value, k)| texts(value, &format!("{path}[{k}]"))),
        Value::Object(keys) => keys.iter().try_for_each(|(key, value)| match path {
            "" => texts(value, key),
            _ => texts(value, &format!("{path}.{key}")),
        }),
        _ => Ok(()),
    }
}

fn some<T>(list: &[T], path: &str, what: &str) -> Result<()> {
    if list.is_empty() {
        return Err(Malformed::new(Fault::Missing, format!("'{path}' is empty")).expected(what).at_path(path));
    }
    Ok(())
}

/// A text that says something, without spaces around it and without characters that XML cannot hold.
fn text(value: &str, path: &str) -> Result<()> {
    if value.trim().is_empty() {
        return Err(Malformed::new(Fault::Missing, format!("'{path}' says nothing")).expected("a text").at_path(path));
    }
    if value.trim() != value {
        return Err(Malformed::new(Fault::Value, format!("'{path}' begins or ends with a space"))
            .expected("a text without spaces around it")
            .at_path(path));
    }
    if let Some(c) = value.chars().find(|c| c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}')) {
        return Err(Malformed::new(Fault::Value, format!("'{path}' has a character that a certificate cannot hold"))
            .expected("printable text on one line")
            .found(format!("U+{:04X}", u32::from(c)))
            .at_path(path));
    }
    Ok(())
}

fn code(value: &str, path: &str, expected: &str, case: fn(char) -> bool) -> Result<()> {
    let letters = value.chars().filter(|c| c.is_ascii_alphabetic() && case(*c)).count();
    if letters == 2 && value.len() == 2 {
        return Ok(());
    }
    Err(Malformed::new(Fault::Value, format!("'{path}' is not a code"))
        .expected(expected)
        .found(format!("'{value}'"))
        .at_path(path))
}

fn date(value: &str, path: &str) -> Result<()> {
    if day(value) == Some(value) {
        return Ok(());
    }
    Err(Malformed::new(Fault::Value, format!("'{path}' is not a day"))
        .expected("YYYY-MM-DD, for example 2026-05-11")
        .found(format!("'{value}'"))
        .at_path(path))
}
