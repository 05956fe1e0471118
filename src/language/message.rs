//! A message with its arguments, to be said later in any language.

use super::Language;
use fluent_bundle::FluentValue;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// A sentence of a report. Its JSON is the English text.
///
/// ```
/// use tumble::language::{Argument, Language, Sentence};
/// let sentence = Sentence::new("error-of", vec![("id", Argument::Text("kI".into()))]);
/// assert_eq!(sentence.to_string(), "error of kI");
/// assert_eq!(sentence.say(Language::Chinese), "kI 的误差");
/// assert_eq!(serde_json::to_string(&sentence).unwrap(), "\"error of kI\"");
/// ```
#[derive(Debug, Clone)]
pub struct Sentence(Kind);

#[derive(Debug, Clone)]
enum Kind {
    Message(&'static str, Vec<(&'static str, Argument)>),
    /// Read back from JSON.
    Text(String),
    /// Clauses one after the other, as a list.
    Clauses(Vec<Sentence>),
}

impl Sentence {
    /// A message of the catalogues.
    pub fn new(key: &'static str, arguments: Vec<(&'static str, Argument)>) -> Self {
        Sentence(Kind::Message(key, arguments))
    }

    /// Text that is the same in every language.
    pub fn text(text: impl Into<String>) -> Self {
        Sentence(Kind::Text(text.into()))
    }

    /// Clauses parted by semicolons.
    pub(crate) fn clauses(clauses: Vec<Sentence>) -> Self {
        Sentence(Kind::Clauses(clauses))
    }

    /// The sentence in a language; what was read back from JSON stays as it was.
    pub fn say(&self, language: Language) -> String {
        match &self.0 {
            Kind::Message(key, arguments) => language.message(key, arguments),
            Kind::Text(text) => text.clone(),
            Kind::Clauses(clauses) => {
                let clauses: Vec<String> = clauses.iter().map(|clause| clause.say(language)).collect();
                clauses.join(language.semicolon())
            }
        }
    }
}

impl fmt::Display for Sentence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.say(Language::English))
    }
}

impl PartialEq for Sentence {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}

impl Serialize for Sentence {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.to_string())
    }
}

impl<'de> Deserialize<'de> for Sentence {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Sentence::text)
    }
}

impl JsonSchema for Sentence {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "String".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        String::json_schema(generator)
    }
}

/// An argument of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Argument {
    /// Text, as it is.
    Text(String),
    /// How many: chooses the plural.
    Count(usize),
    /// A sentence within a sentence.
    Sentence(Box<Sentence>),
}

impl Argument {
    pub(super) fn value(&self, language: Language) -> FluentValue<'_> {
        match self {
            Argument::Text(text) => FluentValue::from(text.as_str()),
            Argument::Count(n) => FluentValue::from(*n),
            Argument::Sentence(sentence) => FluentValue::from(sentence.say(language)),
        }
    }
}

/// What can be an argument.
pub trait Value {
    /// It as an argument.
    fn argument(&self) -> Argument;
}

impl<T: Value + ?Sized> Value for &T {
    fn argument(&self) -> Argument {
        (**self).argument()
    }
}

impl Value for str {
    fn argument(&self) -> Argument {
        Argument::Text(self.to_string())
    }
}

/// `yes` or `no`, between which a message selects.
impl Value for bool {
    fn argument(&self) -> Argument {
        Argument::Text(if *self { "yes" } else { "no" }.to_string())
    }
}

impl Value for String {
    fn argument(&self) -> Argument {
        Argument::Text(self.clone())
    }
}

impl Value for Cow<'_, str> {
    fn argument(&self) -> Argument {
        Argument::Text(self.to_string())
    }
}

impl Value for usize {
    fn argument(&self) -> Argument {
        Argument::Count(*self)
    }
}

impl Value for u64 {
    fn argument(&self) -> Argument {
        Argument::Text(self.to_string())
    }
}

impl Value for f64 {
    fn argument(&self) -> Argument {
        Argument::Text(self.to_string())
    }
}

impl Value for Sentence {
    fn argument(&self) -> Argument {
        Argument::Sentence(Box::new(self.clone()))
    }
}
