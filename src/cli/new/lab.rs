//! `tumble new lab`: the identities of a certificate.

use super::answers::Answers;
use super::{free, headed, write};
use crate::cli::{Outcome, files};
use crate::error::{Fault, Malformed, Result};
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
    let text = |given: &Option<String>, option: &str, question: &str, proposal: Option<&str>| -> Result<String> {
        answers.one(given.as_deref(), (option, question), proposal, |text| match text.is_empty() {
            true => Err(Malformed::new(Fault::Missing, "a certificate needs this").expected(question)),
            false => Ok(text.to_string()),
        })
    };
    let id = text(&arguments.id, "--id", "the certificate's unique identifier", None)?;
    let country = text(&arguments.country, "--country", "country of issue, two capital letters", None)?;
    let issued = text(&arguments.issued, "--issued", "day of issue, YYYY-MM-DD", None)?;
    let places = "where it was performed: laboratory, customer, laboratoryBranch, customerBranch or other";
    let location = text(&arguments.location, "--location", places, Some("laboratory"))?;
    let laboratory = text(&arguments.laboratory, "--laboratory", "name of the laboratory", None)?;
    let city = text(&arguments.city, "--city", "city of the laboratory", None)?;
    let person = text(&arguments.person, "--person", "who signs", None)?;
    let role = text(&arguments.role, "--role", "in which role", Some("head of laboratory"))?;
    let customer = text(&arguments.customer, "--customer", "name of the customer", None)?;
    let their_city = text(&arguments.customer_city, "--customer-city", "city of the customer", None)?;
    let theirs = text(&arguments.customer_country, "--customer-country", "country of the customer", Some(&country))?;
    let lab: Value = json!({
        "certificate": { "id": id, "country": country, "issued": issued, "location": location },
        "laboratory": { "name": laboratory, "address": { "city": city, "country": country } },
        "persons": [{ "name": person, "role": role, "main_signer": true }],
        "customer": { "name": customer, "address": { "city": their_city, "country": theirs } },
    });
    // read as `fit --lab` reads it, and written with its keys in the order of the type
    let name = arguments.to.display().to_string();
    let lab = wire::read_lab(&Source { name: name.clone(), text: files::json(&lab)? })?;
    let texts = vec![(arguments.to.clone(), headed("lab", "equipment, method and statements may be added", &lab)?)];
    write(texts, &arguments.to, &["lab"])?;
    super::super::show(&format!("wrote {name}\nnext: tumble fit CAMPAIGN --dcc certificate.xml --lab {name}\n"))?;
    Ok(Outcome::Done)
}
