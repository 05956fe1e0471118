//! The correction to apply, as a result of its own: bias and matrix of the first order, and where it holds.

use super::texts::{Texts, Xml, text, told, within};
use super::{decimal, units};
use crate::language::{Language, say};
use crate::report::validity_sentence;
use crate::wire::CorrectionFile;
use std::io;

/// `inputs = matrix (readings - bias)`, a quantity for the bias and one for each row; nothing where nothing is corrected.
pub(super) fn write(
    xml: &mut Xml,
    correction: Option<&CorrectionFile>,
    prefix: &str,
    texts: Texts<'_>,
) -> io::Result<()> {
    let Some(correction) = correction else { return Ok(()) };
    let solved: Vec<_> = correction.inputs.iter().filter(|input| input.solved).zip(&correction.matrix).collect();
    if solved.is_empty() || correction.sensors.is_empty() {
        return Ok(());
    }
    let sensors: Vec<&str> = correction.sensors.iter().map(|sensor| sensor.id.as_str()).collect();
    let unit = |input: &str, sensor: &str| match (input, sensor) {
        (input, "") => units::d_si(&[input]),
        ("", sensor) => units::d_si(&[&format!("1/({sensor})")]),
        (input, sensor) => units::d_si(&[&format!("({input})/({sensor})")]),
    };
    within(xml, "dcc:result", |xml| {
        told(xml, "dcc:name", texts, |lang| say!(lang, "the-correction-to-apply").into())?;
        told(xml, "dcc:description", texts, |lang| {
            let about = say!(lang, "dcc-correction", frame = lang.name(&correction.frame));
            format!("{about}{}{}", lang.space(), validity_sentence(correction, lang))
        })?;
        within(xml, "dcc:data", |xml| {
            let units: Vec<String> = correction.sensors.iter().map(|sensor| units::d_si(&[&sensor.unit])).collect();
            let id = format!("{prefix}correction_bias");
            row(xml, &id, |lang| say!(lang, "bias").into(), &sensors, &correction.bias, &units, texts)?;
            solved.iter().try_for_each(|(input, values)| {
                let units: Vec<String> =
                    correction.sensors.iter().map(|sensor| unit(&input.unit, &sensor.unit)).collect();
                let id = format!("{prefix}correction_{}", input.id);
                row(xml, &id, |lang| say!(lang, "dcc-row", input = input.id), &sensors, values, &units, texts)
            })
        })
    })
}

/// One list of numbers, each with the sensor that it belongs to and its unit.
fn row(
    xml: &mut Xml,
    id: &str,
    name: impl Fn(Language) -> String,
    sensors: &[&str],
    values: &[f64],
    units: &[String],
    texts: Texts<'_>,
) -> io::Result<()> {
    let values: Vec<String> = values.iter().map(|value| decimal(*value)).collect();
    xml.create_element("dcc:quantity").with_attribute(("id", id)).write_inner_content(|xml| {
        told(xml, "dcc:name", texts, name)?;
        within(xml, "si:realListXMLList", |xml| {
            text(xml, "si:labelXMLList", &sensors.join(" "))?;
            text(xml, "si:valueXMLList", &values.join(" "))?;
            text(xml, "si:unitXMLList", &units.join(" "))
        })
    })?;
    Ok(())
}
