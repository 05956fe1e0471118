//! Answers: given as options, or asked for at a terminal.

use crate::cli::{session, show_error};
use crate::error::{Fault, Malformed, Result};
use crate::units::Unit;
use std::io::{BufRead, IsTerminal, Write};

pub(super) struct Answers {
    /// Is somebody there to be asked?
    pub(super) asks: bool,
}

/// An option and the question that it answers.
type Question<'a> = (&'a str, &'a str);

impl Answers {
    /// Somebody at a terminal, if there is one and this is the program itself.
    pub(super) fn here() -> Self {
        let asks = !session::is_embedded() && std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
        Answers { asks }
    }

    /// One answer. `proposal` is the answer for an empty line, and where nobody can be asked.
    ///
    /// Errors: an option that cannot be read; no option, no proposal and nobody to ask.
    pub(super) fn one<T>(
        &self,
        given: Option<&str>,
        (option, question): Question<'_>,
        proposal: Option<&str>,
        read: impl Fn(&str) -> Result<T>,
    ) -> Result<T> {
        match (given, self.asks, proposal) {
            (Some(text), _, _) => read(text),
            (None, true, _) => loop {
                let text = self.line(question, proposal)?;
                let text = if text.is_empty() { proposal.unwrap_or_default() } else { &text };
                match read(text) {
                    Ok(answer) => return Ok(answer),
                    Err(error) => show_error::show(&error),
                }
            },
            (None, false, Some(proposal)) => read(proposal),
            (None, false, None) => Err(missing(option, question)),
        }
    }

    /// Any number of answers, one a line; an empty line ends them.
    pub(super) fn several<T>(
        &self,
        given: &[String],
        question: &str,
        read: impl Fn(&str) -> Result<T>,
    ) -> Result<Vec<T>> {
        let mut all = given.iter().map(|text| read(text)).collect::<Result<Vec<T>>>()?;
        if self.asks && given.is_empty() {
            loop {
                let text = self.line(&format!("{question}, one a line; an empty line ends them"), Some(""))?;
                if text.is_empty() {
                    break;
                }
                match read(&text) {
                    Ok(answer) => all.push(answer),
                    Err(error) => show_error::show(&error),
                }
            }
        }
        Ok(all)
    }

    fn line(&self, question: &str, proposal: Option<&str>) -> Result<String> {
        let proposal = proposal.filter(|text| !text.is_empty()).map_or(String::new(), |text| format!(" [{text}]"));
        let mut out = std::io::stderr().lock();
        let _ = write!(out, "{question}{proposal}: ").and_then(|()| out.flush());
        let mut text = String::new();
        match std::io::stdin().lock().read_line(&mut text) {
            Ok(0) => Err(Malformed::new(Fault::Missing, "the answers end here").expected(question)),
            Ok(_) => Ok(text.trim().to_string()),
            Err(error) => Err(Malformed::new(Fault::File, format!("cannot read the answer: {error}"))),
        }
    }
}

/// The error where nobody can be asked.
fn missing(option: &str, question: &str) -> Malformed {
    Malformed::new(Fault::Missing, format!("not given, and no terminal to ask at: {question}")).expected(option)
}

/// The two sides of `NAME=TEXT`.
pub(super) fn pair(text: &str) -> Result<(String, String)> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().into(), value.trim().into())),
        _ => {
            Err(Malformed::new(Fault::Value, "there is no '=' here").expected("NAME=VALUE").found(format!("'{text}'")))
        }
    }
}

/// `NAME=VALUE[+-U] [UNIT]`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Quantity {
    pub name: String,
    pub value: f64,
    pub u: Option<f64>,
    pub unit: Option<String>,
}

impl Quantity {
    /// Errors: no number, no name of these parameters, a unit that does not convert to the parameter's.
    pub(super) fn of(text: &str, parameters: &[(String, String)]) -> Result<Self> {
        let (name, said) = pair(text)?;
        let Some((_, own)) = parameters.iter().find(|(id, _)| *id == name) else {
            let ids: Vec<&str> = parameters.iter().map(|(id, _)| id.as_str()).collect();
            return Err(Malformed::new(Fault::UnknownName, format!("the bench has no parameter '{name}'"))
                .expected(format!("one of {}", ids.join(", "))));
        };
        let said = said.replace('\u{b1}', "+-");
        let (value, u) = match said.split_once("+-") {
            Some((value, u)) => (number(value)?, Some(number(u)?)),
            None => (number(&said)?, None),
        };
        let unit = [u.as_ref().map(|(_, unit)| unit), Some(&value.1)];
        let unit = unit.into_iter().flatten().find(|unit| !unit.is_empty()).cloned();
        if let Some(unit) = unit.as_deref().filter(|_| !own.is_empty()) {
            Unit::parse_any(unit)?.0.conversion_for(&Unit::parse_any(own)?.0, &name)?;
        }
        Ok(Quantity { name, value: value.0, u: u.map(|(u, _)| u), unit })
    }

    /// Is it zero without more said: no part of the model?
    pub(super) fn is_zero(&self) -> bool {
        self.value == 0.0 && self.u.is_none() && self.unit.is_none()
    }
}

fn number(text: &str) -> Result<(f64, String)> {
    let text = text.trim();
    let ends = text.char_indices().map(|(at, c)| at + c.len_utf8()).rev();
    let read = ends.filter_map(|end| Some((text.get(..end)?.parse().ok()?, text.get(end..)?.trim().to_string())));
    let mut read = read.filter(|(value, _): &(f64, String)| value.is_finite());
    read.next().ok_or_else(|| {
        Malformed::new(Fault::Value, "there is no number here").expected("VALUE[+-U] [UNIT]").found(format!("'{text}'"))
    })
}
