//! `tumble new lab`: the identities of a certificate.

use super::answers::Answers;
use super::{free, headed, write};
use crate::cli::{Outcome, files};
use crate::error::Result;
use crate::wire::{self, Source};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Options of `new lab`.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The lab file.
    #[arg(default_value = "lab.json")]
    to: PathBuf,
    /// The certificate's unique identifier.
    #[arg(long)]
    id: Option<String>,
    /// Country of issue, two capital letters.
    #[arg(long)]
    country: Option<String>,
    /// Day of issue, YYYY-MM-DD.
    #[arg(long)]
    issued: Option<String>,
    /// Where the calibration was performed: laboratory, customer, laboratoryBranch, customerBranch or other.
    #[arg(long)]
    location: Option<String>,
    /// Name of the laboratory.
    #[arg(long)]
    laboratory: Option<String>,
    /// Its city.
    #[arg(long)]
    city: Option<String>,
    /// Who signs.
    #[arg(long)]
    person: Option<String>,
    /// In which role.
    #[arg(long)]
    role: Option<String>,
    /// Name of the customer.
    #[arg(long)]
    customer: Option<String>,
    /// The customer's city.
    #[arg(long)]
    customer_city: Option<String>,
    /// The customer's country, two capital letters; the laboratory's unless given.
    #[arg(long)]
    customer_country: Option<String>,
}

pub(super) fn run(arguments: &Arguments, answers: &Answers) -> Result<Outcome> {
    free(&arguments.to)?;
    let name = arguments.to.display().to_string();
    // a file that is well-formed whatever was answered so far, so that each answer is read as `fit --lab` reads it
    let mut lab: Value = json!({
        "certificate": { "id": "-", "country": "DE", "issued": "2000-01-01", "location": "laboratory" },
        "laboratory": { "name": "-", "address": { "city": "-", "country": "DE" } },
        "persons": [{ "name": "-", "role": "-", "main_signer": true }],
        "customer": { "name": "-", "address": { "city": "-", "country": "DE" } },
    });
    let theirs = "/customer/address/country";
    let country = ["/certificate/country", "/laboratory/address/country", theirs];
    let places = "where it was performed: laboratory, customer, laboratoryBranch, customerBranch or other";
    let questions: [(&Option<String>, &str, &str, Option<&str>, &[&str]); 10] = [
        (&arguments.id, "--id", "the certificate's unique identifier", None, &["/certificate/id"]),
        (&arguments.country, "--country", "country of issue, two capital letters", None, &country),
        (&arguments.issued, "--issued", "day of issue, YYYY-MM-DD", None, &["/certificate/issued"]),
        (&arguments.location, "--location", places, Some("laboratory"), &["/certificate/location"]),
        (&arguments.laboratory, "--laboratory", "name of the laboratory", None, &["/laboratory/name"]),
        (&arguments.city, "--city", "city of the laboratory", None, &["/laboratory/address/city"]),
        (&arguments.person, "--person", "who signs", None, &["/persons/0/name"]),
        (&arguments.role, "--role", "in which role", Some("head of laboratory"), &["/persons/0/role"]),
        (&arguments.customer, "--customer", "name of the customer", None, &["/customer/name"]),
        (&arguments.customer_city, "--customer-city", "city of the customer", None, &["/customer/address/city"]),
    ];
    let with = |lab: &Value, keys: &[&str], text: &str| -> Result<Value> {
        let mut answered = lab.clone();
        for key in keys {
            answered.pointer_mut(key).into_iter().for_each(|value| *value = text.into());
        }
        wire::read_lab(&Source { name: name.clone(), text: files::json(&answered)? })?;
        Ok(answered)
    };
    for (given, option, question, proposal, keys) in questions {
        lab = answers.one(given.as_deref(), (option, question), proposal, |text| with(&lab, keys, text))?;
    }
    let own = lab.pointer(theirs).and_then(Value::as_str).map(str::to_string);
    let question = ("--customer-country", "country of the customer");
    lab = answers
        .one(arguments.customer_country.as_deref(), question, own.as_deref(), |text| with(&lab, &[theirs], text))?;
    // with its keys in the order of the type
    let lab = wire::read_lab(&Source { name: name.clone(), text: files::json(&lab)? })?;
    let texts = vec![(arguments.to.clone(), headed("lab", "equipment, method and statements may be added", &lab)?)];
    write(texts, &arguments.to, &["lab"])?;
    super::super::show(&format!("wrote {name}\nnext: tumble fit CAMPAIGN --dcc certificate.xml --lab {name}\n"))?;
    Ok(Outcome::Done)
}
