//! The campaign file: what is asked of every device, and which columns of a table answer it.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;
use tumble::batch::{Device, Layout, Parts, Use};
use tumble::bench::Bench;
use tumble::campaign::{Campaign, Readings};
use tumble::fit::{Estimator, Settings};
use tumble::record::Column;
use tumble::wire::{self, CampaignFile, ReadingsRef, Source};

/// A campaign without its readings, self-contained: it can be sent to other machines.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Question {
    name: String,
    text: String,
    /// Files that the campaign names (its bench), with their texts.
    files: Vec<(String, String)>,
    linear: bool,
    /// Bits of the coverage probability.
    level: u64,
}

/// What the fit of a device says: its columns.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Quantities {
    /// Estimated parameters, then derived quantities.
    pub names: Vec<String>,
    /// Are there limits to be judged by?
    pub limited: bool,
}

/// A question about the columns of a table.
#[derive(Debug)]
pub(crate) struct Bound {
    pub template: Campaign,
    pub layout: Layout,
    pub settings: Settings,
    /// `None` where each device's rows are needed together.
    pub parts: Option<Parts>,
    /// Places in the layout of what a position is: inputs but `n` and standard uncertainties.
    pub position: Vec<usize>,
    /// For each sensor that is read: its index, the place of its values, the place of its uncertainties.
    pub sensors: Vec<(usize, usize, Option<usize>)>,
    /// The place of the numbers of samples.
    pub samples: Option<usize>,
}

impl Question {
    /// Read a campaign file, and the bench file that it may name; its readings, if any, are not looked at.
    ///
    /// # Errors
    ///
    /// Files that cannot be read, or are no campaign.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let read = |path: &Path| -> tumble::Result<Source> {
            let name = path.display().to_string();
            let bytes = std::fs::read(path).map_err(|error| {
                tumble::Malformed::new(tumble::error::Fault::File, format!("cannot read '{name}': {error}"))
                    .expected("a campaign or a bench as a JSON file")
            })?;
            Source::from_bytes(name, bytes)
        };
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Question::new(read(path)?, &mut |name| read(&folder.join(name)))
    }

    /// From the text of a campaign; `fetch` gives the files that it names.
    ///
    /// # Errors
    ///
    /// A text that is no campaign, and what `fetch` says.
    pub fn new(source: Source, fetch: wire::Fetch<'_>) -> Result<Self> {
        let file = wire::campaign_of(&source)?;
        let mut files = Vec::new();
        file.resolved_bench(&mut |name| {
            let found = fetch(name)?;
            files.push((name.to_string(), found.text.clone()));
            Ok(found)
        })
        .map_err(|error| wire::locate(error, &source))?;
        let level = Settings::default().level.to_bits();
        Ok(Question { name: source.name, text: source.text, files, linear: false, level })
    }

    /// One linear step from the start values, also for a model that is not linear.
    #[must_use]
    pub fn linear(self, linear: bool) -> Self {
        Question { linear, ..self }
    }

    /// Another coverage probability of expanded uncertainties than 0.95.
    #[must_use]
    pub fn level(self, level: f64) -> Self {
        Question { level: level.to_bits(), ..self }
    }

    fn source(&self) -> Source {
        Source { name: self.name.clone(), text: self.text.clone() }
    }

    fn file(&self) -> Result<(CampaignFile, Bench)> {
        let source = self.source();
        let mut file = wire::campaign_of(&source)?;
        let bench = file
            .resolved_bench(&mut |name| {
                let text = self.files.iter().find(|(own, _)| own == name).map(|(_, text)| text.clone());
                Ok(Source { name: name.into(), text: text.unwrap_or_default() })
            })
            .map_err(|error| wire::locate(error, &source))?;
        if !file.columns.is_empty() {
            return Err(Error::Question(
                "\"columns\" of the campaign are for one CSV of one device; in SQL name the columns: SELECT \"Angle (deg)\" AS theta_deg, ... FROM ..."
                    .into(),
            ));
        }
        file.readings = ReadingsRef::Inline(Vec::new());
        Ok((file, bench))
    }

    /// The names of what is estimated and derived.
    pub(crate) fn quantities(&self) -> Result<Quantities> {
        let (file, _) = self.file()?;
        let names = file.estimate.0.iter().map(|(name, _)| name.clone());
        let names: Vec<String> = names.chain(file.derived.0.iter().map(|(name, _)| name.clone())).collect();
        Ok(Quantities { names, limited: !file.limits.is_empty() })
    }

    /// Which of these columns answer the question, in their order.
    pub(crate) fn columns(&self, names: &[String]) -> Result<Vec<String>> {
        let (_, bench) = self.file()?;
        let layout = layout(&bench, names);
        if layout.sensors().next().is_none() {
            let sensors: Vec<&str> = bench.sensors.iter().map(|sensor| sensor.id.as_str()).collect();
            return Err(Error::Question(format!(
                "no column has readings: expected {}; found {}",
                sensors.join(" or "),
                names.join(", ")
            )));
        }
        let twice = |key: &&String| names.iter().filter(|own| own == key).count() > 1;
        if let Some(key) = layout.keys.iter().find(twice) {
            return Err(Error::Question(format!("the column {key} stands there twice")));
        }
        Ok(layout.keys)
    }

    /// The question about columns of these names and this order.
    pub(crate) fn bind(&self, keys: &[String], exact: bool) -> Result<Bound> {
        let source = self.source();
        let (file, bench) = self.file()?;
        let layout = layout(&bench, keys);
        let estimator = if self.linear { Estimator::Linear } else { Estimator::Exact };
        let settings = Settings { estimator, level: f64::from_bits(self.level), ..Settings::default() };
        if !file.scatter.is_empty() {
            return Err(Error::Question(
                "the campaign says what scatters (\"scatter\"), which needs all readings with their labels at hand: tumble fit CAMPAIGN --by COLUMN --readings FILES"
                    .into(),
            ));
        }
        let readings = Readings { columns: layout.numeric(&bench), rows: Vec::new() };
        let template = file.with(bench, readings).map_err(|error| wire::locate(error, &source))?;
        let parts = match exact {
            true => None,
            false => Some(Parts::new(&template, &settings).map_err(|error| Error::Step(wire::locate(error, &source)))?),
        };
        let place = |key: &str| layout.keys.iter().position(|own| own == key);
        let sensors = layout
            .sensors()
            .filter_map(|k| {
                let id = &template.bench.sensors.get(k)?.id;
                Some((k, place(id)?, place(&format!("{id}_u"))))
            })
            .collect::<Vec<_>>();
        let samples = place("n");
        let weights = |k: &usize| samples == Some(*k) || sensors.iter().any(|(_, _, u)| *u == Some(*k));
        let position =
            (0..layout.keys.len()).filter(|k| layout.uses.get(*k) == Some(&Use::Input) && !weights(k)).collect();
        Ok(Bound { template, settings, parts, position, sensors, samples, layout })
    }
}

impl Bound {
    /// The campaign of a device.
    pub(crate) fn campaign(&self, device: &Device) -> tumble::Result<Campaign> {
        let readings = wire::device_readings(&self.template.bench, &self.layout, device)?;
        Ok(self.template.with_readings(readings))
    }
}

fn layout(bench: &Bench, names: &[String]) -> Layout {
    let column = |name: &String| Column { name: name.clone(), title: name.clone(), unit: None };
    let columns: Vec<Column> = names.iter().map(column).collect();
    Layout::of(bench, &columns, None, |_| false)
}
