//! The front door for programs: questions from texts and files in one call.

use super::{
    BenchRef, Folder, Source, bench_file, campaign_from, campaign_of, locate, read_bench, read_campaign, read_rows_of,
};
use crate::bench::Bench;
use crate::campaign::Campaign;
use crate::error::{Fault, Malformed, Result};
use crate::fit::{Fit, Settings, streamed};
use crate::record::Record;
use std::path::Path;

/// Largest file that is read.
const MOST_BYTES: u64 = 1 << 30;

impl Campaign {
    /// A campaign from the text of its file; a bench that is named must be built in, readings must stand in the text.
    ///
    /// ```
    /// use tumble::{Campaign, fit};
    /// let campaign = Campaign::from_json(r#"{ "bench": { "id": "line", "sensors": { "y": { "model": "a + b*x" } } },
    ///     "estimate": { "a": {}, "b": {} }, "readings": [ {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 4} ] }"#)?;
    /// assert!((fit(&campaign, &Default::default())?.parameter("b")?.value.unwrap() - 1.5).abs() < 1e-15);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    ///
    /// Errors: what is wrong, with line, column and JSON path.
    pub fn from_json(text: &str) -> Result<Campaign> {
        read_campaign(&Source { name: "campaign".into(), text: text.into() }, &mut |name| {
            Err(Malformed::new(Fault::File, format!("'{name}' is a file, and a text cannot refer to files")).expected(
                "a built-in bench, or bench and readings in the text (Campaign::from_path looks in the folder of its file)",
            ))
        })
    }

    /// A campaign from its file; a bench, readings and samples that it names are looked for beside it.
    ///
    /// Errors: a file that cannot be read, and those of [`Campaign::from_json`].
    pub fn from_path(path: impl AsRef<Path>) -> Result<Campaign> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        read_campaign_beside(&source(path)?, folder)
    }
}

impl Bench {
    /// A built-in bench by its id, or a bench from the text of its file.
    ///
    /// ```
    /// assert_eq!(tumble::Bench::named("gyro-turntable")?.tilts().count(), 6);
    /// # Ok::<(), tumble::error::Malformed>(())
    /// ```
    pub fn named(id: &str) -> Result<Bench> {
        let found = crate::bench::built_in(id).ok_or_else(|| {
            let ids: Vec<&str> = crate::bench::built_ins().iter().map(|bench| bench.id).collect();
            Malformed::new(Fault::UnknownName, format!("no bench is called '{id}'")).expected(ids.join(", "))
        })?;
        Bench::from_json(found.text)
    }

    /// A bench from the text of its file. Errors: what is wrong, with line, column and JSON path.
    pub fn from_json(text: &str) -> Result<Bench> {
        read_bench(&Source { name: "bench".into(), text: text.into() })
    }
}

/// Read a campaign file; a bench, readings and samples that it names are looked for in a folder.
///
/// Errors: those of [`Campaign::from_path`].
pub fn read_campaign_beside(source: &Source, folder: &Path) -> Result<Campaign> {
    campaign_from(campaign_of(source)?, source, &mut Beside(folder))
}

/// Fit a campaign file whose readings are the rows of a record (`"samples": ..., "as": "rows"`), which may have any length; what it names is looked for in a
/// folder.
///
/// Errors: those of [`Campaign::from_path`] and of [`crate::fit::streamed::fit`]; a campaign of other readings.
pub fn fit_rows_beside(source: &Source, folder: &Path, settings: &Settings) -> Result<Fit> {
    let mut folder = Beside(folder);
    let (campaign, mut rows, sample) = read_rows_of(&campaign_of(source)?, source, &mut folder, Some(settings))?;
    streamed::fit(campaign, &mut rows, &sample, settings).map_err(|error| locate(error, source))
}

/// The folder of a campaign file.
struct Beside<'a>(&'a Path);

impl Folder for Beside<'_> {
    fn text(&mut self, name: &str) -> Result<Source> {
        source(&self.0.join(name))
    }

    fn record(&mut self, name: &str) -> Result<Record> {
        Record::at(&self.0.join(name))
    }
}

fn source(path: &Path) -> Result<Source> {
    let name = path.display().to_string();
    let fault = |what: String| Malformed::new(Fault::File, what).expected("a readable file").in_file(name.clone());
    let there = std::fs::metadata(path).map_err(|error| fault(format!("cannot read '{name}': {error}")))?;
    if !there.is_file() || there.len() > MOST_BYTES {
        return Err(fault(format!("'{name}' is no file of at most {} MiB", MOST_BYTES >> 20)));
    }
    let bytes = std::fs::read(path).map_err(|error| fault(format!("cannot read '{name}': {error}")))?;
    Source::from_bytes(name, bytes)
}

/// A built-in bench by its id, any other in full, so that the file stands alone.
pub fn bench_ref(campaign: &Campaign) -> BenchRef {
    let file = bench_file(&campaign.bench);
    if Bench::named(&campaign.bench.id).is_ok_and(|bench| bench_file(&bench) == file) {
        return BenchRef::Named(campaign.bench.id.clone());
    }
    BenchRef::Inline(Box::new(file))
}
