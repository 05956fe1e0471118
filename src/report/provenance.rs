//! What a report was made from: names of the input files and digests of their bytes; the begin and the end of every page say them.

use super::VERSION;
use crate::document::Document;
#[cfg(feature = "cli")]
use crate::elements::Parts;
use crate::language::{Language, code, say};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
#[cfg(feature = "cli")]
use sha2::{Digest, Sha256};

/// An input file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Input {
    /// Its name, as the user gave it.
    pub name: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

#[cfg(feature = "cli")]
impl Input {
    /// An input of so many bytes.
    ///
    /// ```
    /// let input = tumble::report::Input::new("empty.json", b"");
    /// assert!(input.sha256.starts_with("e3b0c44298fc1c14"));
    /// ```
    pub fn new(name: impl Into<String>, bytes: &[u8]) -> Self {
        let sha256 = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Input { name: name.into(), sha256 }
    }

    /// An input that is read piece by piece.
    pub fn read(name: &str, from: &mut impl std::io::Read) -> std::io::Result<Self> {
        let (mut digest, mut piece) = (Sha256::new(), vec![0; 1 << 16]);
        loop {
            match from.read(&mut piece)? {
                0 => break,
                n => digest.update(piece.part(..n)),
            }
        }
        let sha256 = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Input { name: name.into(), sha256 })
    }
}

/// A document without sections, with version and inputs at its end.
pub(super) fn begin(title: impl Into<String>, inputs: &[Input], lang: Language) -> Document {
    let digest = |input: &Input| (say!(lang, "sha-of", name = input.name), code(&input.sha256));
    let version = (say!(lang, "made-by").to_string(), format!("tumble {VERSION}"));
    let colophon = [version].into_iter().chain(inputs.iter().map(digest)).collect();
    let mut document = Document::new(title);
    (document.language, document.colophon) = (lang, colophon);
    document
}
