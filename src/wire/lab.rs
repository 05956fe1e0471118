//! The lab file (`--lab`): the identities that a calibration certificate needs and that no program may invent.

use super::locate::in_source;
use super::{Source, parse};
use crate::error::{Fault, Malformed, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Who calibrated what for whom, when and where.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LabFile {
    /// The certificate itself.
    pub certificate: CertificateFile,
    /// The calibration laboratory.
    pub laboratory: ContactFile,
    /// Persons responsible; at least one.
    pub persons: Vec<PersonFile>,
    /// The customer.
    pub customer: ContactFile,
    /// What was calibrated; at least one.
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
    /// First day of the calibration, `YYYY-MM-DD`.
    pub begin: String,
    /// Last day of the calibration.
    pub end: String,
    /// Day of issue.
    pub issued: String,
    /// Where the calibration was performed.
    pub location: LocationFile,
}

fn english() -> String {
    "en".into()
}

/// Where a calibration was performed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum LocationFile {
    /// In the laboratory.
    Laboratory,
    /// At the customer's.
    Customer,
    /// In a branch of the laboratory.
    LaboratoryBranch,
    /// In a branch of the customer's.
    CustomerBranch,
    /// Elsewhere.
    Other,
}

impl LocationFile {
    /// As files and certificates write it.
    pub fn name(self) -> &'static str {
        match self {
            LocationFile::Laboratory => "laboratory",
            LocationFile::Customer => "customer",
            LocationFile::LaboratoryBranch => "laboratoryBranch",
            LocationFile::CustomerBranch => "customerBranch",
            LocationFile::Other => "other",
        }
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

/// Who gave an identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum IssuerFile {
    /// The manufacturer.
    Manufacturer,
    /// The calibration laboratory.
    CalibrationLaboratory,
    /// The customer.
    Customer,
    /// The owner.
    Owner,
    /// Someone else.
    Other,
}

impl IssuerFile {
    /// As files and certificates write it.
    pub fn name(self) -> &'static str {
        match self {
            IssuerFile::Manufacturer => "manufacturer",
            IssuerFile::CalibrationLaboratory => "calibrationLaboratory",
            IssuerFile::Customer => "customer",
            IssuerFile::Owner => "owner",
            IssuerFile::Other => "other",
        }
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
    let lab: LabFile = parse(source)?;
    check(&lab).map_err(|error| in_source(error, source))?;
    Ok(lab)
}

fn check(lab: &LabFile) -> Result<()> {
    let certificate = &lab.certificate;
    text(&certificate.id, "certificate.id")?;
    code(&certificate.country, "certificate.country", "two capital letters, for example DE", char::is_uppercase)?;
    code(&certificate.language, "certificate.language", "two small letters, for example en", char::is_lowercase)?;
    let days = [("begin", &certificate.begin), ("end", &certificate.end), ("issued", &certificate.issued)];
    for (key, day) in days {
        date(day, &format!("certificate.{key}"))?;
    }
    for ((before, first), (after, second)) in days.iter().zip(days.iter().skip(1)) {
        if first > second {
            return Err(Malformed::new(Fault::Value, format!("the certificate's {after} is before its {before}"))
                .expected(format!("{first} or later"))
                .found(second.to_string())
                .at_path(format!("certificate.{after}")));
        }
    }
    contact(&lab.laboratory, "laboratory")?;
    contact(&lab.customer, "customer")?;
    some(&lab.persons, "persons", "a responsible person")?;
    for (k, person) in lab.persons.iter().enumerate() {
        text(&person.name, &format!("persons[{k}].name"))?;
        optional(&person.role, &format!("persons[{k}].role"))?;
    }
    some(&lab.items, "items", "a calibrated item")?;
    for (k, entry) in lab.items.iter().enumerate() {
        some(
            &entry.identifications,
            &format!("items[{k}].identifications"),
            "a serial number or other identification",
        )?;
        item(entry, &format!("items[{k}]"))?;
    }
    for (k, entry) in lab.equipment.iter().enumerate() {
        item(entry, &format!("equipment[{k}]"))?;
    }
    if let Some(method) = &lab.method {
        text(&method.name, "method.name")?;
        for (k, norm) in method.norms.iter().enumerate() {
            text(norm, &format!("method.norms[{k}]"))?;
        }
    }
    for (k, statement) in lab.statements.iter().enumerate() {
        text(statement, &format!("statements[{k}]"))?;
    }
    Ok(())
}

fn contact(contact: &ContactFile, path: &str) -> Result<()> {
    text(&contact.name, &format!("{path}.name"))?;
    optional(&contact.code, &format!("{path}.code"))?;
    optional(&contact.email, &format!("{path}.email"))?;
    optional(&contact.phone, &format!("{path}.phone"))?;
    let address = &contact.address;
    text(&address.city, &format!("{path}.address.city"))?;
    let country = format!("{path}.address.country");
    code(&address.country, &country, "two capital letters, for example DE", char::is_uppercase)?;
    optional(&address.post_code, &format!("{path}.address.post_code"))?;
    optional(&address.street, &format!("{path}.address.street"))?;
    optional(&address.number, &format!("{path}.address.number"))
}

fn item(item: &ItemFile, path: &str) -> Result<()> {
    text(&item.name, &format!("{path}.name"))?;
    optional(&item.manufacturer, &format!("{path}.manufacturer"))?;
    optional(&item.model, &format!("{path}.model"))?;
    for (k, identification) in item.identifications.iter().enumerate() {
        text(&identification.value, &format!("{path}.identifications[{k}].value"))?;
        optional(&identification.name, &format!("{path}.identifications[{k}].name"))?;
    }
    Ok(())
}

fn some<T>(list: &[T], path: &str, what: &str) -> Result<()> {
    if list.is_empty() {
        return Err(Malformed::new(Fault::Missing, format!("'{path}' is empty")).expected(what).at_path(path));
    }
    Ok(())
}

fn optional(value: &Option<String>, path: &str) -> Result<()> {
    value.as_deref().map_or(Ok(()), |value| text(value, path))
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
    Err(Malformed::new(Fault::Value, format!("'{path}' is no code"))
        .expected(expected)
        .found(format!("'{value}'"))
        .at_path(path))
}

fn date(value: &str, path: &str) -> Result<()> {
    let parts: Vec<Option<u32>> = value.split('-').map(|part| part.parse().ok()).collect();
    let shape = value.len() == 10 && value.bytes().all(|b| b.is_ascii_digit() || b == b'-');
    let good = match parts.as_slice() {
        [Some(year), Some(month), Some(day)] if shape => {
            let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
            let longest = match month {
                2 => 28 + u32::from(leap),
                4 | 6 | 9 | 11 => 30,
                1..=12 => 31,
                _ => 0,
            };
            *year > 0 && (1..=longest).contains(day)
        }
        _ => false,
    };
    if good {
        return Ok(());
    }
    Err(Malformed::new(Fault::Value, format!("'{path}' is no day"))
        .expected("YYYY-MM-DD, for example 2026-05-11")
        .found(format!("'{value}'"))
        .at_path(path))
}
