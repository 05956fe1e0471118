//! The administrative part: everything here comes from the lab file.

use super::{VERSION, Xml, content, named, text, within};
use crate::language::Language;
use crate::wire::{ContactFile, ItemFile, LabFile};
use std::io;

pub(super) fn write(xml: &mut Xml, lab: &LabFile, lang: Language) -> io::Result<()> {
    let language = lab.certificate.language.as_str();
    within(xml, "dcc:administrativeData", |xml| {
        within(xml, "dcc:dccSoftware", |xml| {
            within(xml, "dcc:software", |xml| {
                named(xml, "dcc:name", "tumble", "en")?;
                text(xml, "dcc:release", VERSION)?;
                text(xml, "dcc:type", "application")
            })
        })?;
        core_data(xml, lab, lang)?;
        within(xml, "dcc:items", |xml| {
            lab.items.iter().try_for_each(|item| within(xml, "dcc:item", |xml| self::item(xml, item, language)))
        })?;
        within(xml, "dcc:calibrationLaboratory", |xml| {
            if let Some(code) = &lab.laboratory.code {
                text(xml, "dcc:calibrationLaboratoryCode", code)?;
            }
            within(xml, "dcc:contact", |xml| contact(xml, &lab.laboratory, language))
        })?;
        within(xml, "dcc:respPersons", |xml| {
            lab.persons.iter().try_for_each(|person| {
                within(xml, "dcc:respPerson", |xml| {
                    within(xml, "dcc:person", |xml| named(xml, "dcc:name", &person.name, language))?;
                    if let Some(role) = &person.role {
                        text(xml, "dcc:role", role)?;
                    }
                    text(xml, "dcc:mainSigner", if person.main_signer { "true" } else { "false" })
                })
            })
        })?;
        within(xml, "dcc:customer", |xml| contact(xml, &lab.customer, language))?;
        if lab.statements.is_empty() {
            return Ok(());
        }
        within(xml, "dcc:statements", |xml| {
            lab.statements.iter().try_for_each(|statement| {
                within(xml, "dcc:statement", |xml| {
                    within(xml, "dcc:declaration", |xml| content(xml, statement, language))
                })
            })
        })
    })
}

fn core_data(xml: &mut Xml, lab: &LabFile, lang: Language) -> io::Result<()> {
    let certificate = &lab.certificate;
    within(xml, "dcc:coreData", |xml| {
        text(xml, "dcc:countryCodeISO3166_1", &certificate.country)?;
        text(xml, "dcc:usedLangCodeISO639_1", &certificate.language)?;
        for code in Language::ALL.into_iter().filter(|own| [Language::English, lang].contains(own)).map(Language::code)
        {
            if certificate.language != code {
                text(xml, "dcc:usedLangCodeISO639_1", code)?;
            }
        }
        text(xml, "dcc:mandatoryLangCodeISO639_1", &certificate.language)?;
        text(xml, "dcc:uniqueIdentifier", &certificate.id)?;
        text(xml, "dcc:beginPerformanceDate", &certificate.begin)?;
        text(xml, "dcc:endPerformanceDate", &certificate.end)?;
        text(xml, "dcc:performanceLocation", certificate.location.name())?;
        text(xml, "dcc:issueDate", &certificate.issued)
    })
}

/// What an item and a piece of equipment have in common, in the schema's order.
fn item(xml: &mut Xml, item: &ItemFile, language: &str) -> io::Result<()> {
    named(xml, "dcc:name", &item.name, language)?;
    if let Some(manufacturer) = &item.manufacturer {
        within(xml, "dcc:manufacturer", |xml| named(xml, "dcc:name", manufacturer, language))?;
    }
    if let Some(model) = &item.model {
        text(xml, "dcc:model", model)?;
    }
    if item.identifications.is_empty() {
        return Ok(());
    }
    within(xml, "dcc:identifications", |xml| {
        item.identifications.iter().try_for_each(|identification| {
            within(xml, "dcc:identification", |xml| {
                text(xml, "dcc:issuer", identification.issuer.name())?;
                text(xml, "dcc:value", &identification.value)?;
                match &identification.name {
                    Some(name) => named(xml, "dcc:name", name, language),
                    None => Ok(()),
                }
            })
        })
    })
}

fn contact(xml: &mut Xml, contact: &ContactFile, language: &str) -> io::Result<()> {
    named(xml, "dcc:name", &contact.name, language)?;
    for (name, value) in [("dcc:eMail", &contact.email), ("dcc:phone", &contact.phone)] {
        if let Some(value) = value {
            text(xml, name, value)?;
        }
    }
    let address = &contact.address;
    within(xml, "dcc:location", |xml| {
        let street =
            [("dcc:street", &address.street), ("dcc:streetNo", &address.number), ("dcc:postCode", &address.post_code)];
        for (name, value) in street {
            if let Some(value) = value {
                text(xml, name, value)?;
            }
        }
        text(xml, "dcc:city", &address.city)?;
        text(xml, "dcc:countryCode", &address.country)
    })
}

/// Method and equipment, in the place where a measurement result has them.
pub(super) fn method_and_equipment(xml: &mut Xml, lab: &LabFile) -> io::Result<()> {
    let language = lab.certificate.language.as_str();
    if let Some(method) = &lab.method {
        within(xml, "dcc:usedMethods", |xml| {
            within(xml, "dcc:usedMethod", |xml| {
                named(xml, "dcc:name", &method.name, language)?;
                method.norms.iter().try_for_each(|norm| text(xml, "dcc:norm", norm))
            })
        })?;
    }
    if lab.equipment.is_empty() {
        return Ok(());
    }
    within(xml, "dcc:measuringEquipments", |xml| {
        lab.equipment
            .iter()
            .try_for_each(|entry| within(xml, "dcc:measuringEquipment", |xml| item(xml, entry, language)))
    })
}
