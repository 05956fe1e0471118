//! `--reports FOLDER`: a page of its own for each device that is not in order or stands apart, to which the summary leads.

use super::devices::{DeviceTable, Passed};
use super::pages::{self, Texts};
use crate::batch::Verdict;
use crate::document::html;
use crate::error::Result;
use crate::fit::{self, Settings};
use crate::language::Language;
use crate::report::{self, BatchReport};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Most devices that get a page.
const MOST: usize = 100;

/// Pages of devices, and where the summary finds them.
#[derive(Debug, Default)]
pub(super) struct Reports {
    pub(super) texts: Texts,
    pub(super) links: BTreeMap<String, String>,
}

/// Read the table again and fit those devices by themselves; `summary` is the page that leads to them.
pub(super) fn reports(
    table: &DeviceTable<'_>,
    folder: &Path,
    summary: Option<&Path>,
    report: &BatchReport,
    settings: &Settings,
    lang: Language,
) -> Result<Reports> {
    let fitted =
        report.not_in_order.iter().filter(|entry| entry.verdict != Verdict::Malformed).map(|entry| &entry.label);
    let mut wanted: Vec<&String> = Vec::new();
    for label in fitted
        .chain(report.outlying.iter().map(|entry| &entry.label))
        .chain(report.noisy.iter().map(|entry| &entry.label))
    {
        if !wanted.contains(&label) && wanted.len() < MOST {
            wanted.push(label);
        }
    }
    let names = names(&wanted);
    let inputs = table.inputs()?;
    let mut made = Reports::default();
    table.read(&mut |passed| {
        let Passed::Devices(devices, layout) = passed else {
            made = Reports::default();
            return Ok(true);
        };
        for device in &devices {
            let Some(name) = names.get(&device.label) else { continue };
            // what is wrong with a device that cannot be fitted stands in its row
            let Ok(fit) = table.campaign(layout, device).and_then(|campaign| fit::fit_owned(campaign, settings)) else {
                continue;
            };
            let mut page = pages::document_of(&fit, &report::fit_report(&fit), &inputs, lang);
            page.title = format!("{}: {}", device.label, page.title);
            let path = folder.join(name);
            made.links.insert(device.label.clone(), link(summary, &path));
            made.texts.push((path, html::render(&page)?.into_bytes()));
        }
        Ok(true)
    })?;
    Ok(made)
}

/// A file name for each label: letters, digits, `-`, `_` and `.` stay, everything else becomes `_`; two of one name are numbered.
fn names(labels: &[&String]) -> BTreeMap<String, String> {
    let mut taken = BTreeSet::new();
    let mut names = BTreeMap::new();
    for label in labels {
        let keeps = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        let plain: String = label.chars().take(80).map(|c| if keeps(c) { c } else { '_' }).collect();
        let plain = plain.trim_start_matches('.');
        let mut name = format!("{plain}.html");
        let mut number = 2;
        // files of one folder may not differ in capitals alone
        while !taken.insert(name.to_lowercase()) {
            name = format!("{plain}-{number}.html");
            number += 1;
        }
        names.insert((*label).clone(), name);
    }
    names
}

/// The way from a page to a file: relative where the file lies below the page's folder.
fn link(from: Option<&Path>, to: &Path) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let to = absolute(to);
    let folder = from.map(absolute).and_then(|page| page.parent().map(Path::to_path_buf));
    let below: PathBuf = match folder.and_then(|folder| to.strip_prefix(folder).ok().map(Path::to_path_buf)) {
        Some(below) => below,
        None => to,
    };
    let part = |part: Component<'_>| match part {
        Component::Normal(part) => Some(encoded(&part.to_string_lossy())),
        _ => None,
    };
    let parts: Vec<String> = below.components().filter_map(part).collect();
    format!("{}{}", if below.is_absolute() { "file:///" } else { "" }, parts.join("/"))
}

/// Bytes that an address does not have, in hexadecimal.
fn encoded(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => out.push(char::from(byte)),
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}
