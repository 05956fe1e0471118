//! A digital calibration certificate read back: structure by PTB's `dcc.xsd` 3.3.0 and `SI_Format.xsd` 2.2, numbers by the report,
//! identities by the lab file, and nothing written when an identity is missing.

use crate::markup::{Element, element};
use assert_cmd::Command;
use std::fs;
use std::path::Path;

const TABLE_1: &str = "data/campaigns/li2012-table1.campaign.json";
const LAB: &str = "tests/data/lab/lab.json";

fn tumble(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("tumble").unwrap().args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn certificate(campaign: &str, lab: &str) -> Element {
    let (code, text, errors) = tumble(&["fit", campaign, "--dcc", "-", "--lab", lab]);
    assert!(code != 1, "{errors}");
    element(&text)
}

/// Children in the order of the schema's sequences: `?` may be absent, `+` may repeat, `*` both. Elements not listed hold text only.
const SEQUENCES: &[(&str, &str)] = &[
    ("dcc:digitalCalibrationCertificate", "dcc:administrativeData dcc:measurementResults"),
    (
        "dcc:administrativeData",
        "dcc:dccSoftware dcc:coreData dcc:items dcc:calibrationLaboratory dcc:respPersons dcc:customer dcc:statements?",
    ),
    ("dcc:dccSoftware", "dcc:software+"),
    ("dcc:software", "dcc:name dcc:release dcc:type?"),
    (
        "dcc:coreData",
        "dcc:countryCodeISO3166_1 dcc:usedLangCodeISO639_1+ dcc:mandatoryLangCodeISO639_1+ dcc:uniqueIdentifier \
         dcc:receiptDate? dcc:beginPerformanceDate dcc:endPerformanceDate dcc:performanceLocation dcc:issueDate?",
    ),
    ("dcc:items", "dcc:item+"),
    ("dcc:item", "dcc:name dcc:manufacturer? dcc:model? dcc:identifications"),
    ("dcc:identifications", "dcc:identification+"),
    ("dcc:identification", "dcc:issuer dcc:value dcc:name?"),
    ("dcc:manufacturer", "dcc:name"),
    ("dcc:calibrationLaboratory", "dcc:calibrationLaboratoryCode? dcc:contact"),
    ("dcc:contact", "dcc:name dcc:eMail? dcc:phone? dcc:location"),
    ("dcc:customer", "dcc:name dcc:eMail? dcc:phone? dcc:location"),
    ("dcc:location", "dcc:street? dcc:streetNo? dcc:postCode? dcc:city dcc:countryCode"),
    ("dcc:respPersons", "dcc:respPerson+"),
    ("dcc:respPerson", "dcc:person dcc:role? dcc:mainSigner?"),
    ("dcc:person", "dcc:name"),
    ("dcc:statements", "dcc:statement+"),
    ("dcc:statement", "dcc:declaration"),
    ("dcc:declaration", "dcc:content+"),
    ("dcc:measurementResults", "dcc:measurementResult+"),
    (
        "dcc:measurementResult",
        "dcc:name dcc:description? dcc:usedMethods? dcc:usedSoftware dcc:measuringEquipments? dcc:influenceConditions? dcc:results",
    ),
    ("dcc:usedSoftware", "dcc:software+"),
    ("dcc:usedMethods", "dcc:usedMethod+"),
    ("dcc:usedMethod", "dcc:name dcc:description? dcc:norm*"),
    ("dcc:measuringEquipments", "dcc:measuringEquipment+"),
    ("dcc:measuringEquipment", "dcc:name dcc:description? dcc:manufacturer? dcc:model? dcc:identifications?"),
    ("dcc:results", "dcc:result+"),
    ("dcc:result", "dcc:name dcc:description? dcc:data"),
    ("dcc:description", "dcc:content+"),
    ("dcc:data", "dcc:text* dcc:quantity*"),
    ("dcc:text", "dcc:content+"),
    ("dcc:influenceConditions", "dcc:influenceCondition+"),
    ("dcc:influenceCondition", "dcc:name dcc:status? dcc:data"),
    ("dcc:measurementMetaData", "dcc:metaData+"),
    ("dcc:metaData", "dcc:declaration dcc:conformity dcc:data"),
    ("dcc:quantity", "dcc:name dcc:description? si:real? si:hybrid? si:realListXMLList? dcc:measurementMetaData?"),
    ("dcc:name", "dcc:content+"),
    ("si:hybrid", "si:real+"),
    ("si:real", "si:label? si:value si:unit si:measurementUncertaintyUnivariate?"),
    ("si:measurementUncertaintyUnivariate", "si:expandedMU? si:standardMU? si:coverageIntervalMU?"),
    (
        "si:coverageIntervalMU",
        "si:valueStandardMU? si:intervalMin si:intervalMax si:coverageProbability si:distribution?",
    ),
    ("si:standardMU", "si:valueStandardMU si:distribution?"),
    ("si:expandedMU", "si:valueExpandedMU si:coverageFactor si:coverageProbability si:distribution?"),
    ("si:realListXMLList", "si:labelXMLList? si:valueXMLList si:unitXMLList si:ellipsoidalRegionXMLList?"),
    ("si:ellipsoidalRegionXMLList", "si:covarianceMatrix si:coverageFactor si:coverageProbability si:distribution?"),
    ("si:covarianceMatrix", "si:column+"),
    ("si:column", "si:covariance+"),
    ("si:covariance", "si:value si:unit"),
];

/// Check one element and all below it against the sequences.
fn check_structure(element: &Element) {
    let Some((_, sequence)) = SEQUENCES.iter().find(|(name, _)| *name == element.name) else {
        assert!(element.children.is_empty(), "{} has children", element.name);
        assert!(!element.text.trim().is_empty(), "{} is empty", element.name);
        return;
    };
    let mut children = element.children.iter().map(|child| child.name.as_str()).peekable();
    for step in sequence.split_whitespace() {
        let name = step.trim_end_matches(['?', '+', '*']);
        let mut seen = 0;
        while children.next_if_eq(&name).is_some() {
            seen += 1;
        }
        let good = match step.chars().last() {
            Some('?') => seen <= 1,
            Some('+') => seen >= 1,
            Some('*') => true,
            _ => seen == 1,
        };
        assert!(good, "{}: {seen} of {step}", element.name);
    }
    assert_eq!(children.next(), None, "in {}", element.name);
    element.children.iter().for_each(check_structure);
}

#[test]
fn the_certificate_has_the_structure_of_the_schema() {
    for campaign in
        [TABLE_1, "data/campaigns/li2012-table2.campaign.json", "tests/data/simulated/imu-three-axis.campaign.json"]
    {
        let root = certificate(campaign, LAB);
        assert_eq!(root.attribute("schemaVersion"), Some("3.3.0"));
        assert_eq!(root.attribute("xmlns:dcc"), Some("https://ptb.de/dcc"));
        assert_eq!(root.attribute("xmlns:si"), Some("https://ptb.de/si"));
        check_structure(&root);
        for quantity in root.all("dcc:quantity") {
            let kinds = ["si:real", "si:hybrid", "si:realListXMLList"];
            assert_eq!(quantity.children.iter().filter(|c| kinds.contains(&c.name.as_str())).count(), 1);
        }
        for factor in root.all("si:coverageFactor") {
            assert!(factor.text.parse::<f64>().unwrap() >= 1.0 && !factor.text.contains(['e', 'E']));
        }
    }
}

/// Every campaign of the examples and of the built-in data that a certificate can be written of: its structure, and its units among those that
/// PTB's dsiUnits accepts (tests/scripts/dsi_units.py).
#[test]
fn certificates_of_every_example_have_the_structure_and_units_of_the_schema() {
    let table = fs::read_to_string("tests/data/lab/dsi_units.csv").unwrap();
    let accepted: std::collections::HashSet<&str> =
        table.lines().skip(1).filter_map(|line| line.rsplit(',').next()).collect();
    let mut campaigns: Vec<std::path::PathBuf> = Vec::new();
    for entry in fs::read_dir("examples").unwrap().chain(fs::read_dir("data").unwrap()) {
        let folder = entry.unwrap().path();
        if folder.is_dir() {
            campaigns.extend(fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()));
        }
    }
    campaigns.retain(|path| path.to_string_lossy().ends_with(".campaign.json"));
    campaigns.sort();
    let (mut certificates, mut units, mut refused) = (0, std::collections::BTreeSet::new(), Vec::new());
    // a campaign with a unit or a date of its own contradicts those of the lab file: one without
    let folder = tempfile::tempdir().unwrap();
    let mut labs = vec![LAB.to_string()];
    for (name, items, dates) in [("items", true, false), ("dates", false, true), ("both", true, true)] {
        let mut lab: serde_json::Value = serde_json::from_str(&fs::read_to_string(LAB).unwrap()).unwrap();
        if items {
            lab.as_object_mut().unwrap().remove("items");
        }
        for key in ["begin", "end", "issued"].iter().filter(|_| dates) {
            lab["certificate"].as_object_mut().unwrap().remove(*key);
        }
        if dates {
            lab["certificate"]["issued"] = "2099-01-01".into();
        }
        let path = folder.path().join(format!("{name}.json"));
        fs::write(&path, lab.to_string()).unwrap();
        labs.push(path.to_str().unwrap().to_string());
    }
    for path in &campaigns {
        let by = |lab: &String| tumble(&["fit", path.to_str().unwrap(), "--dcc", "-", "--lab", lab]);
        let mut tried = labs.iter().map(by).peekable();
        let first = tried.peek().unwrap().clone();
        let (code, text, errors) = tried.find(|(code, ..)| *code != 1).unwrap_or(first);
        if code == 1 {
            // the reason stands in a sentence
            assert!(errors.contains("error:") && errors.contains("expected"), "{}: {errors}", path.display());
            refused.push(format!("{}: {}", path.display(), errors.lines().next().unwrap_or_default()));
            continue;
        }
        let root = element(&text);
        check_structure(&root);
        certificates += 1;
        for name in ["si:unit", "si:unitXMLList"] {
            units.extend(
                root.all(name)
                    .iter()
                    .flat_map(|own| own.text.split_whitespace().map(str::to_string).collect::<Vec<_>>()),
            );
        }
    }
    // what D-SI has no name for begins with a bar
    let named = || units.iter().filter(|unit| !unit.starts_with('|'));
    let unknown: Vec<&String> = named().filter(|unit| !accepted.contains(unit.as_str())).collect();
    assert!(unknown.is_empty(), "units that tests/scripts/dsi_units.py has not tried: {unknown:?}");
    println!(
        "{certificates} certificates, {} units, {} of them with a name in D-SI; refused:\n{}",
        units.len(),
        named().count(),
        refused.join("\n")
    );
    assert!(certificates >= 32, "{certificates}: {refused:?}");
}

#[test]
fn the_numbers_are_those_of_the_report() {
    let root = certificate(TABLE_1, LAB);
    let (_, json, _) = tumble(&["fit", TABLE_1, "--json", "-"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let reals = root.all("si:real");
    let find = |id: &str, unit: &str| {
        let real = reals.iter().find(|r| r.text_of("si:label") == id && r.text_of("si:unit") == unit);
        real.unwrap_or_else(|| panic!("{id} in {unit}"))
    };
    let number = |element: &Element, name: &str| element.text_of(name).parse::<f64>().unwrap();
    for parameter in report["parameters"].as_array().unwrap() {
        let id = parameter["id"].as_str().unwrap();
        let angle = parameter["kind"] == "tilt";
        let real = find(id, if angle { "\\radian" } else { "\\volt" });
        // U has two significant digits, the value the same decimal places
        let value_and_u = |real: &Element, value: &serde_json::Value, u: &serde_json::Value| {
            let (value, u) = (value.as_f64().unwrap(), u.as_f64().unwrap());
            let place = 10f64.powi(u.log10().floor() as i32 - 1);
            assert!((number(real, "si:value") - value).abs() <= 0.500_001 * place, "{id}");
            assert!((number(real, "si:valueExpandedMU") - u).abs() <= 0.500_001 * place, "{id}");
            let places = |name: &str| real.text_of(name).split_once('.').map_or(0, |(_, places)| places.len());
            assert_eq!(places("si:value"), places("si:valueExpandedMU"));
            let text = real.text_of("si:valueExpandedMU");
            assert_eq!(text.replace('.', "").trim_start_matches('0').len(), 2, "{text}");
        };
        value_and_u(real, &parameter["value"], &parameter["U"]);
        // the schema's factor has no exponent: nine decimals
        assert!((number(real, "si:coverageFactor") - parameter["k"].as_f64().unwrap()).abs() < 1e-9);
        assert_eq!(number(real, "si:coverageProbability"), 0.95);
        if angle {
            value_and_u(find(id, "\\arcsecond"), &parameter["arcsec"]["value"], &parameter["arcsec"]["U"]);
        }
    }
    // the published table: 162.2 arcsec with the sign that the paper's own formula gives, and 24 degrees of freedom
    assert!((number(find("dtheta_y2", "\\arcsecond"), "si:value") + 162.2).abs() < 0.5);
    assert!((number(find("dtheta_y2", "\\radian"), "si:coverageFactor") - 2.0638985616).abs() < 1e-6);
}

#[test]
fn the_covariance_is_that_of_the_report() {
    let root = certificate(TABLE_1, LAB);
    let (_, json, _) = tumble(&["fit", TABLE_1, "--json", "-"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let columns = root.all("si:column");
    assert_eq!(columns.len(), 6);
    for (j, column) in columns.iter().enumerate() {
        for (i, entry) in column.children.iter().enumerate() {
            let value: f64 = entry.text_of("si:value").parse().unwrap();
            assert_eq!(value, report["covariance"]["matrix"][i][j].as_f64().unwrap());
        }
    }
    let list = &root.all("si:realListXMLList")[0];
    assert_eq!(list.text_of("si:labelXMLList"), "V0 dtheta_y0 dtheta_x0 dtheta_y1 dtheta_y2 dtheta_z2");
    assert_eq!(list.text_of("si:unitXMLList").split(' ').count(), 6);
    // k^2 = 6 F(0.95; 6, 24) with F = 2.508 (printed tables)
    let region = &root.all("si:ellipsoidalRegionXMLList")[0];
    let k: f64 = region.text_of("si:coverageFactor").parse().unwrap();
    assert!((k - (6.0_f64 * 2.508).sqrt()).abs() < 1e-3, "{k}");
}

#[test]
fn identities_come_from_the_lab_file_and_survive_markup() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "</dcc:name><x y='\"'>& ]]> \u{201c}\u{e4}\u{201d}";
    let mut lab: serde_json::Value = serde_json::from_str(&fs::read_to_string(LAB).unwrap()).unwrap();
    for key in ["laboratory", "customer"] {
        lab[key]["name"] = hostile.into();
    }
    lab["items"][0]["identifications"][0]["value"] = hostile.into();
    let path = folder.path().join("lab.json");
    fs::write(&path, lab.to_string()).unwrap();
    let root = certificate(TABLE_1, path.to_str().unwrap());
    check_structure(&root);
    assert_eq!(root.all("dcc:contact")[0].all("dcc:content")[0].text, hostile);
    assert_eq!(root.all("dcc:identification")[0].text_of("dcc:value"), hostile);
    assert_eq!(root.all("dcc:uniqueIdentifier")[0].text, "TT-2026-0017");
}

#[test]
fn a_missing_or_wrong_identity_is_refused_by_name_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let (lab_path, certificate) = (folder.path().join("lab.json"), folder.path().join("certificate.xml"));
    let good: serde_json::Value = serde_json::from_str(&fs::read_to_string(LAB).unwrap()).unwrap();
    let refused = |change: &dyn Fn(&mut serde_json::Value), words: &[&str]| {
        let mut lab = good.clone();
        change(&mut lab);
        fs::write(&lab_path, serde_json::to_string_pretty(&lab).unwrap()).unwrap();
        let arguments = ["fit", TABLE_1, "--dcc", certificate.to_str().unwrap(), "--lab", lab_path.to_str().unwrap()];
        let (code, _, errors) = tumble(&arguments);
        assert_eq!(code, 1, "{errors}");
        for word in words {
            assert!(errors.contains(word), "'{word}' is not in: {errors}");
        }
        assert!(!certificate.exists());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    };
    refused(
        &|lab| drop(lab["laboratory"].as_object_mut().unwrap().remove("name")),
        &["the key \"name\" is missing", "laboratory"],
    );
    refused(&|lab| drop(lab.as_object_mut().unwrap().remove("customer")), &["the key \"customer\" is missing"]);
    refused(
        &|lab| drop(lab["certificate"].as_object_mut().unwrap().remove("id")),
        &["the key \"id\" is missing", "certificate"],
    );
    refused(&|lab| lab["laboratory"]["name"] = "  ".into(), &["laboratory.name", "line"]);
    refused(&|lab| lab["persons"] = serde_json::json!([]), &["persons", "a responsible person"]);
    refused(&|lab| lab["persons"] = serde_json::json!([{ "name": "A. B." }]), &["nobody signs", "main_signer"]);
    refused(&|lab| lab["items"][0]["identifications"] = serde_json::json!([]), &["items[0].identifications"]);
    refused(&|lab| lab["certificate"]["country"] = "Germany".into(), &["certificate.country", "DE"]);
    refused(&|lab| lab["certificate"]["end"] = "2026-02-30".into(), &["certificate.end", "YYYY-MM-DD"]);
    refused(&|lab| lab["certificate"]["issued"] = "2026-05-01".into(), &["before"]);
    refused(&|lab| lab["certificate"]["location"] = "moon".into(), &["moon"]);
    refused(&|lab| lab["customer"]["name"] = "a\u{7}b".into(), &["customer.name", "U+0007"]);
    refused(&|lab| lab["seal"] = true.into(), &["seal"]);
    let (code, _, errors) = tumble(&["fit", TABLE_1, "--dcc", certificate.to_str().unwrap()]);
    assert!(code == 1 && errors.contains("--lab"), "{errors}");
    assert!(!Path::new(&certificate).exists());
}

/// Without days of its own a lab file takes the campaign's; a day of issue before them is a fault of the lab file.
#[test]
fn a_day_before_the_campaigns_stands_in_the_lab_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let read = |name: &str| -> serde_json::Value { serde_json::from_str(&fs::read_to_string(name).unwrap()).unwrap() };
    let (mut campaign, mut lab) = (read(TABLE_1), read(LAB));
    campaign["date"] = "2026-05-04".into();
    lab["certificate"].as_object_mut().unwrap().retain(|key, _| !["begin", "end", "received"].contains(&key.as_str()));
    lab["certificate"]["issued"] = "2026-05-01".into();
    for (name, text) in [("c.campaign.json", &campaign), ("lab.json", &lab)] {
        fs::write(path(name), serde_json::to_string_pretty(text).unwrap()).unwrap();
    }
    let arguments = ["fit", &path("c.campaign.json"), "--dcc", &path("d.xml"), "--lab", &path("lab.json")];
    let (code, _, errors) = tumble(&arguments);
    assert!(code == 1 && errors.contains("lab.json") && errors.contains("\"issued\": \"2026-05-01\""), "{errors}");
}

/// An azimuth of two components near zero has an interval that is not `value - U` to `value + U`; the largest of several deviations has a k of its own, and
/// what is said of it; the laboratory's note and limits as they were stated.
#[test]
fn what_is_no_interval_of_student_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flat.campaign.json");
    let rows: Vec<String> = (0..8)
        .map(|k| {
            format!(
                r#"{{ "n": 1, "x": {}, "y": {}, "A": {} }}"#,
                k % 2,
                k / 2 % 2,
                [3.0, 2.0, -3.0, -0.5, 0.2, 2.5, -4.0, 0.0][k]
            )
        })
        .collect();
    let text = format!(
        r#"{{ "bench": {{ "id": "flat", "sensors": {{ "A": {{ "unit": "V", "model": "a + b*x + c*y" }} }} }},
            "unit": {{ "serial": "TT-0017" }}, "note": "after repair 4711", "date": "2026-05-04",
            "estimate": {{ "a": {{ "unit": "V" }}, "b": {{ "unit": "V" }}, "c": {{ "unit": "V" }} }},
            "derived": {{ "direction": {{ "line": "atan2(b, c)", "unit": "deg" }} }},
            "limits": {{ "direction": {{ "between": [-38, null], "unit": "deg" }} }}, "readings": [ {} ] }}"#,
        rows.join(", ")
    );
    fs::write(&path, text).unwrap();
    let mut lab: serde_json::Value = serde_json::from_str(&fs::read_to_string(LAB).unwrap()).unwrap();
    lab.as_object_mut().unwrap().remove("items");
    let lab_path = folder.path().join("lab.json");
    fs::write(&lab_path, lab.to_string()).unwrap();
    let path = path.to_str().unwrap();
    let root = certificate(path, lab_path.to_str().unwrap());
    check_structure(&root);
    let (_, report, _) = tumble(&["fit", path, "--json", "-"]);
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let interval = &report["derived"][0]["interval"];
    // the ends are rounded to a degree
    let of = |name: &str| root.all(name)[0].text.parse::<f64>().unwrap();
    assert!((of("si:intervalMin") - interval[0].as_f64().unwrap()).abs() <= 0.5, "{interval}");
    assert!((of("si:intervalMax") - interval[1].as_f64().unwrap()).abs() <= 0.5, "{interval}");
    assert_eq!(root.all("si:expandedMU").len(), 3);
    let said = |text: &str| root.all("dcc:content").iter().any(|content| content.text.contains(text));
    assert!(said("after repair 4711") && said("it is not estimate - U to estimate + U"));
    assert!(root.all("si:value").iter().any(|value| value.text == "-38"));
}

#[test]
fn what_cannot_be_certified_is_refused() {
    let (code, _, errors) = tumble(&["fit", TABLE_1, "--level", "0.5", "--dcc", "-", "--lab", LAB]);
    assert!(code == 1 && errors.contains("coverage factor"), "{errors}");
    // a sensor without a unit leaves its coefficients without
    let folder = tempfile::tempdir().unwrap();
    let bare = folder.path().join("bare.campaign.json");
    let text = fs::read_to_string("tests/data/gum/h3.campaign.json").unwrap().replace("\"unit\": \"degC\", ", "");
    fs::write(&bare, text).unwrap();
    let (code, _, errors) = tumble(&["fit", &bare.display().to_string(), "--dcc", "-", "--lab", LAB]);
    assert!(code == 1 && errors.contains("unit"), "{errors}");
}

#[test]
fn what_is_not_estimable_is_named_and_not_given() {
    let root = certificate("tests/data/simulated/accelerometer-rank-defect.campaign.json", LAB);
    check_structure(&root);
    let labels: Vec<String> = root.all("si:label").iter().map(|l| l.text.clone()).collect();
    assert!(!labels.iter().any(|label| label == "V0") && labels.iter().any(|label| label == "dtheta_y2"));
    let remarks: Vec<String> = root.all("dcc:content").iter().map(|c| c.text.clone()).collect();
    assert!(remarks.iter().any(|r| r.contains("Not estimable") && r.contains("V0 + kI*dtheta_y0")));
}

/// A reading that the fit flags is in the certificate, too, with the unit of what it differs by; so is all that the report says beside the estimates.
#[test]
fn a_suspicious_reading_is_stated() {
    let mut campaign: serde_json::Value = serde_json::from_str(&fs::read_to_string(TABLE_1).unwrap()).unwrap();
    let read = campaign["readings"][4]["V"].as_f64().unwrap();
    campaign["readings"][4]["V"] = (read + 0.05).into();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrong.campaign.json");
    fs::write(&path, campaign.to_string()).unwrap();
    let path = path.to_str().unwrap();
    let (_, report, errors) = tumble(&["fit", path, "--json", "-"]);
    let report: serde_json::Value = serde_json::from_str(&report).unwrap_or_else(|e| panic!("{e}: {errors}"));
    let said: Vec<&str> =
        report["checks"]["verdict"].as_array().unwrap().iter().map(|said| said.as_str().unwrap()).collect();
    let suspicious = said.iter().find(|said| said.contains("reading 5 of V")).expect("the reading is flagged");
    assert!(suspicious.contains(" V from its prediction"), "{suspicious}");
    let root = certificate(path, LAB);
    check_structure(&root);
    let remarks: Vec<String> = root.all("dcc:content").iter().map(|c| c.text.clone()).collect();
    for said in said {
        // a sentence there begins with a capital and ends with a full stop
        let said = &said[1..];
        assert!(remarks.iter().any(|r| r.contains(said)), "{said}: {remarks:?}");
    }
    assert!(remarks.iter().all(|r| !r.contains('`') && !r.contains("tumble diagnose")), "{remarks:?}");
}

#[test]
fn the_lab_file_has_a_schema_and_the_example_obeys_it() {
    let schema = tumble::wire::schema("lab").unwrap();
    let lab: serde_json::Value = serde_json::from_str(&fs::read_to_string(LAB).unwrap()).unwrap();
    assert!(jsonschema::is_valid(&schema, &lab));
    assert!(!jsonschema::is_valid(&schema, &serde_json::json!({})));
}

/// What scatters has a result of its own, with the standard deviation and unit of every source.
#[test]
fn what_scatters_stands_in_the_certificate() {
    let campaign = "examples/20-position-scatter/with.campaign.json";
    let (_, text, errors) = tumble(&["fit", campaign, "--json", "-"]);
    let report: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {errors}"));
    let told: Vec<&serde_json::Value> =
        report["scatter"].as_array().unwrap().iter().filter(|s| !s["sd"].is_null()).collect();
    assert!(told.len() > 1);
    let text = {
        let (code, text, errors) = tumble(&["fit", campaign, "--dcc", "-", "--lab", LAB]);
        assert!(code != 1, "{errors}");
        text
    };
    check_structure(&element(&text));
    let section = text.split("Random effects").nth(1).expect("a result of its own");
    for (k, source) in told.iter().enumerate() {
        let own = section.split(&format!("id=\"scatter_{}\"", k + 1)).nth(1).unwrap();
        let value = own.split("<si:value>").nth(1).unwrap().split('<').next().unwrap();
        assert_eq!(value.parse::<f64>().unwrap(), source["sd"].as_f64().unwrap());
        assert!(own.contains(source["source"].as_str().unwrap()));
    }
}

/// As found and as left: two measurement results of one unit, each with its state, its conditions, its conformity and its correction.
#[test]
fn as_found_and_as_left_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let mut campaign: serde_json::Value = serde_json::from_str(&fs::read_to_string(TABLE_1).unwrap()).unwrap();
    campaign["unit"] = serde_json::json!({ "serial": "SN-12" });
    campaign["environment"] = serde_json::json!({ "temperature_c": 23.1, "air": "still" });
    campaign["limits"] = serde_json::json!({ "dtheta_y2": { "between": [-200, 200], "unit": "arcsec" },
        "dtheta_z2": { "between": [-1, 1], "unit": "arcsec" } });
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    fs::write(path("b.campaign.json"), campaign.to_string()).unwrap();
    let (code, _, errors) = tumble(&["fit", &path("b.campaign.json"), "--json", &path("found.fit.json")]);
    assert!(code != 1, "{errors}");
    let arguments =
        ["fit", &path("b.campaign.json"), "--dcc", "-", "--lab", LAB, "--as-found", &path("found.fit.json")];
    let (code, text, errors) = tumble(&arguments);
    assert!(code != 1, "{errors}");
    let root = element(&text);
    check_structure(&root);
    let status: Vec<String> = root.all("dcc:status").iter().map(|s| s.text.clone()).collect();
    assert_eq!(status, ["beforeAdjustment", "afterAdjustment"]);
    let results = root.all("dcc:measurementResult");
    assert_eq!(results.len(), 2);
    for result in &results {
        let conditions = result.all("dcc:influenceCondition");
        assert_eq!(conditions.len(), 3);
        let temperature = conditions.iter().find(|c| c.all("dcc:content")[0].text == "temperature_c").unwrap();
        let real = &temperature.all("si:real")[0];
        assert_eq!(real.text_of("si:value") + &real.text_of("si:unit"), "23.1\\degreecelsius");
        // 162 arcsec is inside 200, and beyond 1
        let judged: Vec<String> = result.all("dcc:conformity").iter().map(|c| c.text.clone()).collect();
        assert_eq!(judged, ["pass", "fail"]);
        let limits: Vec<String> =
            result.all("dcc:metaData")[0].all("si:real").iter().map(|r| r.text_of("si:value").to_string()).collect();
        assert_eq!(limits.iter().map(|v| v.parse::<f64>().unwrap().round()).collect::<Vec<_>>(), [-200.0, 200.0]);
        // the correction: bias and the row of the one input
        let lists = result.all("si:realListXMLList");
        let units: Vec<String> = lists.iter().map(|l| l.text_of("si:unitXMLList")).collect();
        assert!(
            ["\\volt", "\\degree\\second\\tothe{-1}\\volt\\tothe{-1}"]
                .iter()
                .all(|unit| units.iter().any(|own| own == unit)),
            "{units:?}"
        );
    }
    // every id once
    let ids: Vec<&str> =
        text.match_indices(" id=\"").map(|(at, _)| text[at + 5..].split('"').next().unwrap()).collect();
    let distinct: std::collections::BTreeSet<&&str> = ids.iter().collect();
    assert_eq!(distinct.len(), ids.len());
    // another unit is refused
    campaign["unit"]["serial"] = "SN-13".into();
    fs::write(path("b.campaign.json"), campaign.to_string()).unwrap();
    let (code, _, errors) = tumble(&arguments);
    assert!(code == 1 && errors.contains("another unit") && errors.contains("'SN-12'"), "{errors}");
}

/// The campaign's unit, date, place, operator, procedure and instruments fill the certificate, and what the lab file says otherwise is refused.
#[test]
fn the_campaigns_identity_fills_the_certificate() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let mut campaign: serde_json::Value = serde_json::from_str(&fs::read_to_string(TABLE_1).unwrap()).unwrap();
    let identity = serde_json::json!({
        "unit": { "serial": "T-0417", "type": "triad", "manufacturer": "ACME" }, "date": "2026-11-02",
        "place": "Lab 2\u{7}", "operator": "Lena", "procedure": "QP-12 rev 3",
        "instruments": [{ "name": "dividing head", "certificate": "DH-123", "traceable_to": "PTB", "valid_to": "2025-01-01" }],
        "environment": { "temperature_c": { "value": 23.0, "u": 0.5 }, "humidity_percent": [40, 50], "note\u{1}": "a\u{b}b" } });
    campaign.as_object_mut().unwrap().extend(identity.as_object().unwrap().clone());
    fs::write(path("id.campaign.json"), campaign.to_string()).unwrap();
    let mut lab: serde_json::Value = serde_json::from_str(&fs::read_to_string(LAB).unwrap()).unwrap();
    let run = |lab: &serde_json::Value| {
        fs::write(path("lab.json"), lab.to_string()).unwrap();
        tumble(&["fit", &path("id.campaign.json"), "--dcc", "-", "--lab", &path("lab.json")])
    };
    let (code, _, errors) = run(&lab);
    assert!(code == 1 && errors.contains("none of the lab file's items") && errors.contains("'T-0417'"), "{errors}");
    lab.as_object_mut().unwrap().remove("items");
    let (code, _, errors) = run(&lab);
    assert!(code == 1 && errors.contains("2026-11-02") && errors.contains("2026-05-04 to 2026-05-05"), "{errors}");
    for key in ["begin", "end"] {
        lab["certificate"].as_object_mut().unwrap().remove(key);
    }
    lab["certificate"]["issued"] = "2026-11-09".into();
    lab["certificate"]["received"] = "2026-11-03".into();
    let (code, _, errors) = run(&lab);
    assert!(code == 1 && errors.contains("before its received"), "{errors}");
    lab["certificate"]["received"] = "2026-10-30".into();
    let (code, text, errors) = run(&lab);
    assert!(code != 1, "{errors}");
    let root = element(&text);
    check_structure(&root);
    let one = |name: &str| root.all(name)[0].text.clone();
    assert_eq!(
        [one("dcc:receiptDate"), one("dcc:beginPerformanceDate"), one("dcc:endPerformanceDate")],
        ["2026-10-30", "2026-11-02", "2026-11-02"]
    );
    let item = &root.all("dcc:item")[0];
    assert_eq!(
        [item.text_of("dcc:model"), item.all("dcc:identification")[0].text_of("dcc:value")],
        ["triad", "T-0417"]
    );
    let equipment = root.all("dcc:measuringEquipment");
    assert_eq!(equipment.len(), 2);
    let said: Vec<String> = root.all("dcc:content").iter().map(|c| c.text.clone()).collect();
    let has = |text: &str| said.iter().any(|own| own.contains(text));
    for text in [
        "ACME",
        "Lena",
        "QP-12 rev 3",
        "Lab 2\u{fffd}",
        "valid to 2025-01-01",
        "relate only to the items calibrated",
        "by dividing head, DH-123, to PTB",
        "was valid to 2025-01-01",
    ] {
        assert!(has(text), "{text} is not in {said:?}");
    }
    let traced: Vec<Element> =
        root.all("dcc:statement").into_iter().filter(|own| own.attribute("refType").is_some()).collect();
    assert_eq!(traced.len(), 1);
    assert_eq!(traced[0].attribute("refType"), Some("basic_metrologicallyTraceableToSI"));
    assert!(traced[0].all("dcc:content")[0].text.contains("to PTB"));
    let software = root.all("dcc:usedSoftware")[0].all("dcc:software")[0].clone();
    assert_eq!(software.all("dcc:content")[0].text, "tumble");
    let of_type = |name: &str, wanted: &str| {
        let all = root.all(name);
        let found = all.iter().find(|own| own.attribute("refType") == Some(wanted));
        found.unwrap_or_else(|| panic!("{wanted}")).all("si:real")[0].clone()
    };
    assert_eq!(of_type("dcc:quantity", "basic_temperature").text_of("si:valueStandardMU"), "0.5");
    let [low, high] =
        ["basic_humidityRelativeMin", "basic_humidityRelativeMax"].map(|own| of_type("dcc:quantity", own));
    assert_eq!([low.text_of("si:value"), high.text_of("si:value"), high.text_of("si:unit")], ["40", "50", "\\percent"]);
    // what PTB's Schematron asks of the program's version, of languages and of non-SI units
    assert!(one("dcc:release").starts_with('v'));
    // one warning for people, too
    let (_, printed, _) = tumble(&["fit", &path("id.campaign.json")]);
    assert!(printed.contains("dividing head was valid to 2025-01-01"), "{printed}");
}

/// PTB's Schematron: a text with a language has every declared language, and each declared language is there once.
#[test]
fn texts_have_every_declared_language_or_say_none() {
    let folder = tempfile::tempdir().unwrap();
    for (own, lang) in [("en", "en"), ("de", "en"), ("en", "zh"), ("de", "zh")] {
        let mut lab: serde_json::Value = serde_json::from_str(&fs::read_to_string(LAB).unwrap()).unwrap();
        lab["certificate"]["language"] = own.into();
        let path = folder.path().join("lab.json");
        fs::write(&path, lab.to_string()).unwrap();
        let (code, text, errors) =
            tumble(&["fit", TABLE_1, "--dcc", "-", "--lab", path.to_str().unwrap(), "--lang", lang]);
        assert!(code != 1, "{errors}");
        let root = element(&text);
        let declared: std::collections::BTreeSet<String> =
            root.all("dcc:usedLangCodeISO639_1").iter().map(|l| l.text.clone()).collect();
        assert_eq!(declared.len(), root.all("dcc:usedLangCodeISO639_1").len());
        assert!(declared.contains(own) && declared.contains(lang), "{declared:?}");
        for name in ["dcc:name", "dcc:description", "dcc:declaration", "dcc:text"] {
            for element in root.all(name) {
                let said: Vec<&str> = element.children.iter().filter_map(|own| own.attribute("lang")).collect();
                let distinct: std::collections::BTreeSet<String> = said.iter().map(|own| own.to_string()).collect();
                assert!(
                    said.is_empty() || (distinct == declared && said.len() == declared.len()),
                    "{own} {lang}: {said:?}"
                );
            }
        }
    }
}

/// Both languages stand in the certificate where Chinese is asked for, and its core data say so.
#[test]
fn a_certificate_in_chinese_has_both_languages() {
    let (code, text, errors) = tumble(&["fit", TABLE_1, "--dcc", "-", "--lab", LAB, "--lang", "zh"]);
    assert!(code != 1, "{errors}");
    let root = element(&text);
    check_structure(&root);
    let used: Vec<String> = root.all("dcc:usedLangCodeISO639_1").iter().map(|l| l.text.clone()).collect();
    assert!(used.contains(&"zh".to_string()) && used.contains(&"en".to_string()), "{used:?}");
    let of = |lang: &str| -> Vec<String> {
        let all = root.all("dcc:content");
        all.iter().filter(|c| c.attribute("lang") == Some(lang)).map(|c| c.text.clone()).collect()
    };
    assert!(of("en").contains(&"Estimates".to_string()));
    assert!(of("zh").contains(&"估计结果".to_string()));
    assert!(of("zh").iter().any(|text| text.contains("自由度")));
}

/// Numbers as `si:decimalType` has them: U with two significant digits, the value with the places of U (GUM 7.2.6), factors without an exponent.
#[test]
fn numbers_are_as_the_schema_has_them() {
    let cases = [
        (-162.0687, 1.2356, ["-162.1", "1.2"]),
        (-7.857_6e-4, 5.99e-6, ["-0.0007858", "0.0000060"]),
        (0.25, 0.0996, ["0.25", "0.10"]),
        (56_789.0, 1234.0, ["56.8e3", "1.2e3"]),
        (-1e-9, 0.3, ["0.00", "0.30"]),
    ];
    // U = k u with k = Phi^-1(0.975)
    let k = 1.959_963_984_540_054;
    let names: Vec<String> = (0..cases.len()).map(|i| format!("c{i}")).collect();
    let object = |each: &dyn Fn(usize) -> serde_json::Value, key: &dyn Fn(usize) -> String| -> serde_json::Value {
        (0..cases.len()).map(|i| (key(i), each(i))).collect::<serde_json::Map<_, _>>().into()
    };
    let mut row = object(&|i| cases[i].0.into(), &|i| format!("y{i}"));
    for (i, case) in cases.iter().enumerate() {
        row[format!("y{i}_u")] = (case.1 / k).into();
    }
    let campaign = serde_json::json!({
        "bench": { "id": "direct", "sensors": object(&|i| serde_json::json!({ "unit": "V", "model": names[i] }), &|i| format!("y{i}")) },
        "estimate": object(&|_| serde_json::json!({}), &|i| names[i].clone()),
        "readings": [row],
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("direct.campaign.json");
    fs::write(&path, campaign.to_string()).unwrap();
    let root = certificate(path.to_str().unwrap(), LAB);
    check_structure(&root);
    for (name, (_, _, [value, expanded])) in names.iter().zip(cases) {
        let id = format!("quantity_{name}");
        let all = root.all("dcc:quantity");
        let own = all.iter().find(|own| own.attribute("id").is_some_and(|own| own.ends_with(&id))).expect("a quantity");
        let text = |key: &str| own.all(key).first().map(|own| own.text.trim().to_string()).expect("a number");
        assert_eq!([text("si:value"), text("si:valueExpandedMU")], [value, expanded], "{name}");
        assert_eq!([text("si:coverageFactor"), text("si:coverageProbability")], ["1.959963985", "0.95"]);
    }
    // the covariance matrix has all digits of the fit: a decimal, with an exponent where it is small
    let lists: Vec<String> = root.all("si:valueXMLList").iter().map(|own| own.text.clone()).collect();
    let written: Vec<&str> = lists.iter().flat_map(|list| list.split_whitespace()).collect();
    for expected in ["-162.0687", "-0.00078576", "0.25", "56789", "-1e-9"] {
        assert!(written.contains(&expected), "{expected} is not in {written:?}");
    }
}
