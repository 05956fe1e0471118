//! Values of a file that may have several shapes, told apart by what they begin with: a fault inside keeps its own line and path, which serde's untagged
//! enumerations lose.

use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor, value};
use std::fmt;

/// The shapes of a `T`: what is made of a text, a number, a list and an object.
pub(super) struct Shapes<T, L = IgnoredAny, M = IgnoredAny> {
    expected: &'static str,
    text: Option<fn(String) -> T>,
    number: Option<fn(f64) -> T>,
    list: Option<fn(L) -> T>,
    object: Option<fn(M) -> T>,
}

/// A value of no shape yet; `expected` is what messages expect.
pub(super) fn shapes<T>(expected: &'static str) -> Shapes<T> {
    Shapes { expected, text: None, number: None, list: None, object: None }
}

impl<T, L, M> Shapes<T, L, M> {
    pub fn text(self, of: fn(String) -> T) -> Self {
        Shapes { text: Some(of), ..self }
    }

    #[allow(dead_code, reason = "files of missions alone have such values")]
    pub fn number(self, of: fn(f64) -> T) -> Self {
        Shapes { number: Some(of), ..self }
    }

    pub fn list<N>(self, of: fn(N) -> T) -> Shapes<T, N, M> {
        let Shapes { expected, text, number, object, .. } = self;
        Shapes { expected, text, number, list: Some(of), object }
    }

    pub fn object<N>(self, of: fn(N) -> T) -> Shapes<T, L, N> {
        let Shapes { expected, text, number, list, .. } = self;
        Shapes { expected, text, number, list, object: Some(of) }
    }
}

/// A type that a file has in several shapes: `shaped!(AxesFile, "a number, or [x, y, z]", number: AxesFile::All, list: AxesFile::Each);`
macro_rules! shaped {
    ($of:ty, $expected:expr, $($shape:ident: $make:expr),+) => {
        impl<'de> serde::Deserialize<'de> for $of {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
                $crate::wire::shapes::shapes($expected)$(.$shape($make))+.read(from)
            }
        }
    };
}

pub(super) use shaped;

impl<'de, T, L: Deserialize<'de>, M: Deserialize<'de>> Shapes<T, L, M> {
    pub fn read<D: Deserializer<'de>>(self, deserializer: D) -> Result<T, D::Error> {
        deserializer.deserialize_any(self)
    }

    fn or<E: Error, V>(&self, of: Option<fn(V) -> T>, found: Unexpected<'_>) -> Result<fn(V) -> T, E> {
        of.ok_or_else(|| E::invalid_type(found, self))
    }
}

impl<'de, T, L: Deserialize<'de>, M: Deserialize<'de>> Visitor<'de> for Shapes<T, L, M> {
    type Value = T;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }
    fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
        Ok(self.or(self.text, Unexpected::Str(text))?(text.to_string()))
    }
    fn visit_f64<E: Error>(self, value: f64) -> Result<T, E> {
        Ok(self.or(self.number, Unexpected::Float(value))?(value))
    }
    fn visit_i64<E: Error>(self, value: i64) -> Result<T, E> {
        Ok(self.or(self.number, Unexpected::Signed(value))?(value as f64))
    }
    fn visit_u64<E: Error>(self, value: u64) -> Result<T, E> {
        Ok(self.or(self.number, Unexpected::Unsigned(value))?(value as f64))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<T, A::Error> {
        let of = self.or(self.list, Unexpected::Seq)?;
        L::deserialize(value::SeqAccessDeserializer::new(list)).map(of)
    }
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        let of = self.or(self.object, Unexpected::Map)?;
        M::deserialize(value::MapAccessDeserializer::new(map)).map(of)
    }
}
