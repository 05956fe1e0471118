//! The administrative part: the lab file, with what the campaigns add to it; method, software and equipment.

use super::VERSION;
use super::xml::{Element, Texts, element, text};
use crate::campaign::{Identity, Instrument};
use crate::language::say;
use crate::wire::{ContactFile, IssuerFile, ItemFile, LabFile};

pub(super) fn data(lab: &LabFile, campaigns: &[&Identity], texts: Texts<'_>) -> Element {
    let items = lab
        .items
        .iter()
        .map(|item| element("dcc:item").add(texts.own("dcc:name", &item.name)).add(made(item, None, texts)));
    let code = lab.laboratory.code.as_ref().map(|code| text("dcc:calibrationLaboratoryCode", code));
    let persons = lab.persons.iter().map(|person| {
        element("dcc:respPerson")
            .add(element("dcc:person").add(texts.own("dcc:name", &person.name)))
            .add(person.role.as_ref().map(|role| text("dcc:role", role)))
            .add(text("dcc:mainSigner", person.main_signer.to_string()))
    });
    let laboratory = element("dcc:contact").add(contact(&lab.laboratory, texts));
    element("dcc:administrativeData")
        .add(software("dcc:dccSoftware", texts))
        .add(core_data(lab, texts))
        .add(element("dcc:items").add(items))
        .add(element("dcc:calibrationLaboratory").add(code).add(laboratory))
        .add(element("dcc:respPersons").add(persons))
        .add(element("dcc:customer").add(contact(&lab.customer, texts)))
        .add(statements(lab, campaigns, texts))
}

fn statements(lab: &LabFile, campaigns: &[&Identity], texts: Texts<'_>) -> Element {
    let mut traced: Vec<(&Instrument, &str)> = Vec::new();
    for instrument in campaigns.iter().flat_map(|campaign| &campaign.instruments) {
        let is_new = traced.iter().all(|(known, _)| *known != instrument);
        traced.extend(instrument.traceable_to.as_deref().filter(|_| is_new).map(|to| (instrument, to)));
    }
    let traced = traced.into_iter().map(|(instrument, to)| {
        let by = [Some(instrument.name.as_str()), instrument.certificate.as_deref()];
        let by: Vec<&str> = by.into_iter().flatten().collect();
        let said = texts.said("dcc:declaration", |lang| say!(lang, "dcc-traceable", by = by.join(lang.comma()), to));
        element("dcc:statement").of_type(Some("basic_metrologicallyTraceableToSI")).add(said)
    });
    let only = texts.said("dcc:declaration", |lang| say!(lang, "dcc-relates-only-to-the-items").into());
    let declared = lab.statements.iter().map(|s| element("dcc:statement").add(texts.own("dcc:declaration", s)));
    element("dcc:statements").add(element("dcc:statement").add(only)).add(traced).add(declared)
}

/// This program: it writes the certificate, and computes its results.
fn software(name: &'static str, texts: Texts<'_>) -> Element {
    let program = element("dcc:software")
        .add(texts.own("dcc:name", "tumble"))
        .add(text("dcc:release", format!("v{VERSION}")))
        .add(text("dcc:type", "application"));
    element(name).add(program)
}

fn core_data(lab: &LabFile, texts: Texts<'_>) -> Element {
    let certificate = &lab.certificate;
    let day = |name, day: &Option<String>| day.as_ref().map(|day| text(name, day));
    element("dcc:coreData")
        .add(text("dcc:countryCodeISO3166_1", &certificate.country))
        .add(texts.declared().map(|code| text("dcc:usedLangCodeISO639_1", code)))
        .add(text("dcc:mandatoryLangCodeISO639_1", &certificate.language))
        .add(text("dcc:uniqueIdentifier", &certificate.id))
        .add(day("dcc:receiptDate", &certificate.received))
        .add(day("dcc:beginPerformanceDate", &certificate.begin))
        .add(day("dcc:endPerformanceDate", &certificate.end))
        .add(text("dcc:performanceLocation", certificate.location.name()))
        .add(text("dcc:issueDate", &certificate.issued))
}

/// Manufacturer, model and identifications of an item or a piece of equipment, in the schema's order.
fn made(item: &ItemFile, certificate: Option<&str>, texts: Texts<'_>) -> Vec<Element> {
    let manufacturer = item.manufacturer.as_ref();
    let manufacturer = manufacturer.map(|name| element("dcc:manufacturer").add(texts.own("dcc:name", name)));
    let model = item.model.as_ref().map(|model| text("dcc:model", model));
    let stated = item.identifications.iter().map(|identification| {
        let serial = identification.issuer == IssuerFile::Manufacturer;
        element("dcc:identification")
            .of_type(serial.then_some("basic_serialNumber"))
            .add(text("dcc:issuer", identification.issuer.name()))
            .add(text("dcc:value", &identification.value))
            .add(identification.name.as_ref().map(|name| texts.own("dcc:name", name)))
    });
    let certificate = certificate.map(|number| {
        element("dcc:identification")
            .add(text("dcc:issuer", IssuerFile::Other.name()))
            .add(text("dcc:value", number))
            .add(texts.said("dcc:name", |lang| say!(lang, "calibration-certificate").into()))
    });
    let all: Vec<Element> = stated.chain(certificate).collect();
    let all = (!all.is_empty()).then(|| element("dcc:identifications").add(all));
    [manufacturer, model, all].into_iter().flatten().collect()
}

fn contact(contact: &ContactFile, texts: Texts<'_>) -> Vec<Element> {
    let some = |name, value: &Option<String>| value.as_ref().map(|value| text(name, value));
    let address = &contact.address;
    let location = element("dcc:location")
        .add(some("dcc:street", &address.street))
        .add(some("dcc:streetNo", &address.number))
        .add(some("dcc:postCode", &address.post_code))
        .add(text("dcc:city", &address.city))
        .add(text("dcc:countryCode", &address.country));
    let named = texts.own("dcc:name", &contact.name).into_iter();
    named.chain(some("dcc:eMail", &contact.email)).chain(some("dcc:phone", &contact.phone)).chain(location).collect()
}

/// Method, software and equipment, in the place where a measurement result has them: the lab file's and the campaign's, which are one where they have one name.
pub(super) fn method_and_equipment(lab: &LabFile, campaign: &Identity, texts: Texts<'_>) -> Vec<Element> {
    let method = match &lab.method {
        Some(method) => texts.own("dcc:name", &method.name),
        None => texts.said("dcc:name", |lang| say!(lang, "dcc-method").into()),
    };
    let norms = lab.method.iter().flat_map(|method| &method.norms).map(|norm| text("dcc:norm", norm));
    let calibration = element("dcc:usedMethod")
        .of_type(Some("basic_calibrationMethod"))
        .add(method)
        .add(campaign.procedure.as_ref().map(|procedure| texts.own("dcc:description", procedure)))
        .add(norms);
    let uncertainty = element("dcc:usedMethod")
        .of_type(Some("basic_methodMeasurementUncertainty"))
        .add(texts.said("dcc:name", |lang| say!(lang, "dcc-uncertainty").into()))
        .add(text("dcc:norm", "JCGM 100:2008 (GUM)"));
    let named = |name: &str| campaign.instruments.iter().find(|instrument| instrument.name == name);
    let known = |instrument: &&Instrument| lab.equipment.iter().all(|entry| entry.name != instrument.name);
    let entry =
        |name: &str| ItemFile { name: name.into(), manufacturer: None, model: None, identifications: Vec::new() };
    let others = campaign.instruments.iter().filter(known).map(|i| (entry(&i.name), Some(i)));
    let equipment = lab.equipment.iter().map(|entry| (entry.clone(), named(&entry.name))).chain(others);
    let equipment: Vec<Element> = equipment.map(|(entry, instrument)| piece(&entry, instrument, texts)).collect();
    let equipment = (!equipment.is_empty()).then(|| element("dcc:measuringEquipments").add(equipment));
    let methods = element("dcc:usedMethods").add(calibration).add(uncertainty);
    [methods, software("dcc:usedSoftware", texts)].into_iter().chain(equipment).collect()
}

/// A piece of equipment, with what the campaign states of it.
fn piece(entry: &ItemFile, instrument: Option<&Instrument>, texts: Texts<'_>) -> Element {
    let stated = instrument.map(|instrument| (instrument.valid_to.as_deref(), instrument.traceable_to.as_deref()));
    let stated = stated.filter(|instrument| *instrument != (None, None)).map(|(valid_to, traceable_to)| {
        texts.said("dcc:description", |lang| {
            let valid = valid_to.map(|day| format!("{} {day}", say!(lang, "identity-valid-to")));
            let traceable = traceable_to.map(|to| format!("{} {to}", say!(lang, "identity-traceable-to")));
            valid.into_iter().chain(traceable).collect::<Vec<_>>().join(lang.comma())
        })
    });
    element("dcc:measuringEquipment")
        .of_type(Some("basic_measurementStandard"))
        .add(texts.own("dcc:name", &entry.name))
        .add(stated)
        .add(made(entry, instrument.and_then(|instrument| instrument.certificate.as_deref()), texts))
}
