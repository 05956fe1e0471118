//! Names of model lines that resemble an input along an axis, a column under another name, or a missing factor.

use super::{Campaign, Kind, Parameter, Role};
use crate::algebra::{Expression, Scratch, Tape};
use crate::bench::Bench;
use crate::elements::Elements;
use crate::error::{Fault, Malformed, Result};
use crate::record::title;
use crate::units::Unit;

/// Do a name of a model line and a column differ by letter case, blanks, marks and a unit at their end alone?
fn looks_like(name: &str, column: &str) -> bool {
    let plain =
        |text: &str| -> String { text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect() };
    // the whole name, and its parts before each unit
    let forms = |text: &str| {
        let whole = title(text).0.replace(' ', "_");
        let mut forms = vec![plain(&whole)];
        let mut part = whole.as_str();
        while let Some((stem, end)) = part.rsplit_once('_')
            && !stem.is_empty()
            && (Unit::parse(end).is_ok() || crate::units::of_column(part).is_some())
        {
            forms.push(plain(stem));
            part = stem;
        }
        forms
    };
    let of_column = forms(column);
    forms(name).iter().any(|form| of_column.contains(form))
}

impl Campaign {
    /// Refuse a table where one of these columns was meant by a name that is taken as zero: a table of which only some columns are kept.
    pub fn refuse_unread<'a>(&self, columns: impl IntoIterator<Item = &'a str>) -> Result<()> {
        let columns: Vec<String> = columns.into_iter().map(str::to_string).collect();
        let zero = self.parameters.iter().filter(|p| p.role == Role::AssumedZero && p.kind != Kind::Tilt);
        zero.map(|p| p.id.as_str()).try_for_each(|name| refuse_meant(&self.bench, &columns, name))
    }

    /// The column that was meant by a sensor without a value: its name under another letter case, or its unit spelled out.
    pub(crate) fn meant_for_a_sensor(&self) -> Option<(&str, &str)> {
        self.bench.sensors.iter().find_map(|sensor| {
            let unit = Unit::parse(&sensor.unit).ok();
            let same = |column: &str| unit.as_ref().zip(Unit::parse(column).ok()).is_some_and(|(a, b)| a.is_same(&b));
            let columns = self.readings.columns.iter().filter(|column| is_unused(&self.bench, column));
            let mut columns = columns.filter(|column| looks_like(&sensor.id, column) || same(column));
            Some((sensor.id.as_str(), columns.next()?.as_str()))
        })
    }
}

/// Refuse a coefficient that is neither known nor estimated where an input of the bench or an unused column was meant.
pub(super) fn refuse_meant(bench: &Bench, columns: &[String], name: &str) -> Result<()> {
    let neither = format!("'{name}' in a model line is neither known nor estimated");
    let (what, expected) = if let Some(input) = super::input_meant(bench, name) {
        (format!("{neither}: is the input '{input}' meant?"), format!("{input} in the model line"))
    } else if let Some(column) = columns.iter().find(|column| is_unused(bench, column) && looks_like(name, column)) {
        (
            format!("{neither}, and no column has this name: is the column '{column}' meant?"),
            format!("a column '{name}' (\"columns\": {{ \"{name}\": \"{column}\" }} names it)"),
        )
    } else {
        return Ok(());
    };
    let expected = format!("{expected}, or '{name}' in known or estimate where it is a coefficient");
    Err(Malformed::new(Fault::UnknownName, what).expected(expected).at_path("bench"))
}

/// Does no model line read this column, nor a joint?
fn is_unused(bench: &Bench, column: &str) -> bool {
    !super::is_of_joint(bench, column) && !bench.sensors.iter().any(|sensor| sensor.model.names().contains(&column))
}

/// Refuse an estimated coefficient whose terms are all zero, since it is multiplied by a factor that is taken as zero.
pub(super) fn refuse_without_factor(bench: &Bench, parameters: &[Parameter]) -> Result<()> {
    let is_zero =
        |name: &str| parameters.iter().any(|p| p.id == name && p.role == Role::AssumedZero && p.kind != Kind::Tilt);
    let lines: Vec<&Expression> = bench.sensors.iter().map(|sensor| &sensor.model).collect();
    if !lines.iter().any(|line| line.names().iter().any(|name| is_zero(name))) {
        return Ok(());
    }
    for parameter in parameters.iter().filter(|p| matches!(p.role, Role::Estimated { .. }) && p.kind != Kind::Tilt) {
        let mut factor = None;
        for line in lines.iter().filter(|line| line.names().contains(&parameter.id.as_str())) {
            factor = zero_factor(line, &parameter.id, &is_zero)?;
            if factor.is_none() {
                break;
            }
        }
        if let Some(factor) = factor {
            let what = format!(
                "'{}' occurs only multiplied by '{factor}', which is neither a column, known nor estimated",
                parameter.id
            );
            return Err(Malformed::new(Fault::UnknownName, what)
                .expected(format!(
                    "'{factor}' in the readings, in known or in estimate, so that '{}' can be estimated",
                    parameter.id
                ))
                .found(format!("'{factor}' taken as zero"))
                .at_path(format!("estimate.{}", parameter.id)));
        }
    }
    Ok(())
}

/// The name that multiplies a coefficient in a line: the line's slope is zero where the name is zero, and not elsewhere.
fn zero_factor(line: &Expression, id: &str, is_zero: &dyn Fn(&str) -> bool) -> Result<Option<String>> {
    let names = line.names();
    let tape = Tape::compile(line, &names)?;
    let depends = |free: &dyn Fn(&str) -> bool| {
        // numbers at which nothing cancels
        let value =
            |(k, name): (usize, &&str)| if is_zero(name) && !free(name) { 0.0 } else { 0.3 + 0.7 / (k as f64 + 1.6) };
        let point: Vec<f64> = names.iter().enumerate().map(value).collect();
        let mut gradient = vec![0.0; names.len()];
        tape.gradient(&point, &mut Scratch::default(), &mut gradient);
        names.iter().position(|name| *name == id).is_some_and(|k| gradient.at(k) != 0.0)
    };
    if depends(&|_| false) {
        return Ok(None);
    }
    let alone = names.iter().filter(|name| is_zero(name)).find(|name| depends(&|free| free == **name));
    Ok(alone.map(|name| name.to_string()))
}
