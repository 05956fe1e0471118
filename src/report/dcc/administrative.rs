//! The administrative part: the lab file, with what the campaigns add to it.

use super::VERSION;
use super::texts::{Texts, Xml, of_type, text, told, within};
use crate::campaign::{Identity, Instrument};
use crate::language::{Language, say};
use crate::wire::{ContactFile, IdentificationFile, IssuerFile, ItemFile, LabFile};
use std::io;

pub(super) fn write(xml: &mut Xml, lab: &LabFile, campaigns: &[&Identity], texts: Texts<'_>) -> io::Result<()> {
    within(xml, "dcc:administrativeData", |xml| {
        software(xml, "dcc:dccSoftware", texts)?;
        core_data(xml, lab, texts)?;
        within(xml, "dcc:items", |xml| {
            lab.items.iter().try_for_each(|item| {
                within(xml, "dcc:item", |xml| {
                    texts.own(xml, "dcc:name", &item.name)?;
                    made(xml, item, None, texts)
                })
            })
        })?;
        within(xml, "dcc:calibrationLaboratory", |xml| {
            if let Some(code) = &lab.laboratory.code {
                text(xml, "dcc:calibrationLaboratoryCode", code)?;
            }
            within(xml, "dcc:contact", |xml| contact(xml, &lab.laboratory, texts))
        })?;
        within(xml, "dcc:respPersons", |xml| {
            lab.persons.iter().try_for_each(|person| {
                within(xml, "dcc:respPerson", |xml| {
                    within(xml, "dcc:person", |xml| texts.own(xml, "dcc:name", &person.name))?;
                    if let Some(role) = &person.role {
                        text(xml, "dcc:role", role)?;
                    }
                    text(xml, "dcc:mainSigner", if person.main_signer { "true" } else { "false" })
                })
            })
        })?;
        within(xml, "dcc:customer", |xml| contact(xml, &lab.customer, texts))?;
        within(xml, "dcc:statements", |xml| {
            let declared = |xml: &mut Xml, ref_type: Option<&str>, said: &dyn Fn(Language) -> String| {
                of_type(xml, "dcc:statement", ref_type, |xml| told(xml, "dcc:declaration", texts, said))
            };
            declared(xml, None, &|lang| say!(lang, "dcc-relates-only-to-the-items").into())?;
            let mut traced: Vec<&Instrument> = Vec::new();
            for instrument in campaigns.iter().flat_map(|own| &own.instruments) {
                let Some(to) = instrument.traceable_to.as_deref().filter(|_| !traced.contains(&instrument)) else {
                    continue;
                };
                let by = [Some(instrument.name.as_str()), instrument.certificate.as_deref()];
                let by: Vec<&str> = by.into_iter().flatten().collect();
                let traceable = Some("basic_metrologicallyTraceableToSI");
                declared(xml, traceable, &|lang| say!(lang, "dcc-traceable", by = by.join(lang.comma()), to))?;
                traced.push(instrument);
            }
            lab.statements.iter().try_for_each(|statement| {
                within(xml, "dcc:statement", |xml| texts.own(xml, "dcc:declaration", statement))
            })
        })
    })
}

/// This program: it writes the certificate, and computes its results.
fn software(xml: &mut Xml, name: &str, texts: Texts<'_>) -> io::Result<()> {
    within(xml, name, |xml| {
        within(xml, "dcc:software", |xml| {
            texts.own(xml, "dcc:name", "tumble")?;
            text(xml, "dcc:release", &format!("v{VERSION}"))?;
            text(xml, "dcc:type", "application")
        })
    })
}

fn core_data(xml: &mut Xml, lab: &LabFile, texts: Texts<'_>) -> io::Result<()> {
    let certificate = &lab.certificate;
    within(xml, "dcc:coreData", |xml| {
        text(xml, "dcc:countryCodeISO3166_1", &certificate.country)?;
        texts.declared().try_for_each(|code| text(xml, "dcc:usedLangCodeISO639_1", code))?;
        text(xml, "dcc:mandatoryLangCodeISO639_1", &certificate.language)?;
        text(xml, "dcc:uniqueIdentifier", &certificate.id)?;
        for (name, day) in [
            ("dcc:receiptDate", &certificate.received),
            ("dcc:beginPerformanceDate", &certificate.begin),
            ("dcc:endPerformanceDate", &certificate.end),
        ] {
            day.iter().try_for_each(|day| text(xml, name, day))?;
        }
        text(xml, "dcc:performanceLocation", certificate.location.name())?;
        text(xml, "dcc:issueDate", &certificate.issued)
    })
}

/// Manufacturer, model and identifications of an item or a piece of equipment, in the schema's order.
fn made(xml: &mut Xml, item: &ItemFile, certificate: Option<&str>, texts: Texts<'_>) -> io::Result<()> {
    if let Some(manufacturer) = &item.manufacturer {
        within(xml, "dcc:manufacturer", |xml| texts.own(xml, "dcc:name", manufacturer))?;
    }
    if let Some(model) = &item.model {
        text(xml, "dcc:model", model)?;
    }
    if item.identifications.is_empty() && certificate.is_none() {
        return Ok(());
    }
    within(xml, "dcc:identifications", |xml| {
        item.identifications.iter().try_for_each(|identification: &IdentificationFile| {
            let serial = identification.issuer == IssuerFile::Manufacturer;
            of_type(xml, "dcc:identification", serial.then_some("basic_serialNumber"), |xml| {
                text(xml, "dcc:issuer", identification.issuer.name())?;
                text(xml, "dcc:value", &identification.value)?;
                identification.name.iter().try_for_each(|name| texts.own(xml, "dcc:name", name))
            })
        })?;
        certificate.map_or(Ok(()), |number| {
            within(xml, "dcc:identification", |xml| {
                text(xml, "dcc:issuer", IssuerFile::Other.name())?;
                text(xml, "dcc:value", number)?;
                told(xml, "dcc:name", texts, |lang| say!(lang, "calibration-certificate").into())
            })
        })
    })
}

fn contact(xml: &mut Xml, contact: &ContactFile, texts: Texts<'_>) -> io::Result<()> {
    texts.own(xml, "dcc:name", &contact.name)?;
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

/// Method, software and equipment, in the place where a measurement result has them: the lab file's and the campaign's, which are one where they have one name.
pub(super) fn method_and_equipment(
    xml: &mut Xml,
    lab: &LabFile,
    campaign: &Identity,
    texts: Texts<'_>,
) -> io::Result<()> {
    within(xml, "dcc:usedMethods", |xml| {
        of_type(xml, "dcc:usedMethod", Some("basic_calibrationMethod"), |xml| {
            match &lab.method {
                Some(method) => texts.own(xml, "dcc:name", &method.name)?,
                None => told(xml, "dcc:name", texts, |lang| say!(lang, "dcc-method").into())?,
            }
            campaign.procedure.iter().try_for_each(|procedure| texts.own(xml, "dcc:description", procedure))?;
            lab.method.iter().flat_map(|method| &method.norms).try_for_each(|norm| text(xml, "dcc:norm", norm))
        })?;
        of_type(xml, "dcc:usedMethod", Some("basic_methodMeasurementUncertainty"), |xml| {
            told(xml, "dcc:name", texts, |lang| say!(lang, "dcc-uncertainty").into())?;
            text(xml, "dcc:norm", "JCGM 100:2008 (GUM)")
        })
    })?;
    software(xml, "dcc:usedSoftware", texts)?;
    let named = |name: &str| campaign.instruments.iter().find(|own| own.name == name);
    let known = |own: &&Instrument| lab.equipment.iter().all(|entry| entry.name != own.name);
    let entry =
        |name: &str| ItemFile { name: name.into(), manufacturer: None, model: None, identifications: Vec::new() };
    let own = campaign.instruments.iter().filter(known).map(|own| (entry(&own.name), Some(own)));
    let equipment: Vec<(ItemFile, Option<&Instrument>)> =
        lab.equipment.iter().map(|entry| (entry.clone(), named(&entry.name))).chain(own).collect();
    if equipment.is_empty() {
        return Ok(());
    }
    within(xml, "dcc:measuringEquipments", |xml| {
        equipment.iter().try_for_each(|(entry, instrument)| {
            of_type(xml, "dcc:measuringEquipment", Some("basic_measurementStandard"), |xml| {
                texts.own(xml, "dcc:name", &entry.name)?;
                let stated = instrument.map(|own| (own.valid_to.as_deref(), own.traceable_to.as_deref()));
                if let Some((valid_to, traceable_to)) = stated.filter(|own| *own != (None, None)) {
                    told(xml, "dcc:description", texts, |lang| {
                        let valid = valid_to.map(|day| format!("{} {day}", say!(lang, "identity-valid-to")));
                        let traceable = traceable_to.map(|to| format!("{} {to}", say!(lang, "identity-traceable-to")));
                        valid.into_iter().chain(traceable).collect::<Vec<_>>().join(lang.comma())
                    })?;
                }
                made(xml, entry, instrument.and_then(|own| own.certificate.as_deref()), texts)
            })
        })
    })
}
