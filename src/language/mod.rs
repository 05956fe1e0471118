//! The languages in which a result is shown: every fixed sentence and term is in one catalogue per language.
//!
//! ```text
//! result value -> shown in a Language: say!(language, "key", name = value) -> data/language/<code>.ftl -> text
//! ```
//!
//! The catalogues are Fluent files (<https://projectfluent.org>) with the same keys and the same named arguments, which a test compares. Numbers,
//! names and units are formatted before they enter a message. What is stored in a report as a sentence is a [`Sentence`]: its JSON is English
//! whatever the language, since keys and vocabularies of JSON never change.
//!
//! | file | subject |
//! |---|---|
//! | `catalogue.rs` | the files, read once |
//! | `message.rs` | a message with its arguments, to be said later |
//! | `names.rs` | texts that are data: names of benches and effects, notes of a computation |
//!
//! Deliberately absent: a current language; the language is an argument of whatever shows a result. Formatting of numbers: it is the same in
//! both languages (decimal point, SI symbols).

mod catalogue;
mod message;
mod names;

pub use catalogue::keys;
pub use message::{Argument, Sentence, Value};
pub use names::names;

use std::borrow::Cow;
use std::sync::OnceLock;

/// A language in which results are shown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Language {
    /// English.
    #[default]
    English,
    /// Chinese in simplified characters, with the terms of GB/T, GJB and JJF.
    Chinese,
}

/// All that a language consists of.
struct Parts {
    /// ISO 639-1.
    code: &'static str,
    /// BCP 47.
    tag: &'static str,
    /// Sentences and punctuation, in Fluent.
    sentences: &'static str,
    /// Texts that the program has as data, by their English form; JSON.
    names: &'static str,
    /// The glossary of the guide.
    #[cfg(feature = "html")]
    glossary: &'static str,
}

impl Language {
    /// All of them.
    pub const ALL: [Language; 2] = [Language::English, Language::Chinese];

    const fn parts(self) -> Parts {
        match self {
            Language::English => Parts {
                code: "en",
                tag: "en",
                sentences: include_str!("../../data/language/en.ftl"),
                names: "{}",
                #[cfg(feature = "html")]
                glossary: include_str!("../../docs/guide/glossary.md"),
            },
            Language::Chinese => Parts {
                code: "zh",
                tag: "zh-CN",
                sentences: include_str!("../../data/language/zh.ftl"),
                names: include_str!("../../data/language/names.zh.json"),
                #[cfg(feature = "html")]
                glossary: include_str!("../../docs/guide/glossary.zh.md"),
            },
        }
    }

    /// Its ISO 639-1 code: `en`, `zh`.
    pub fn code(self) -> &'static str {
        self.parts().code
    }

    /// Its BCP 47 tag, as pages carry it: `en`, `zh-CN`.
    pub(crate) fn tag(self) -> &'static str {
        self.parts().tag
    }

    /// The page of the guide that explains terms.
    #[cfg(feature = "html")]
    pub(crate) const fn glossary(self) -> &'static str {
        self.parts().glossary
    }

    /// The language of a code.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::of("zh"), Some(Language::Chinese));
    /// assert_eq!(Language::of("tlh"), None);
    /// ```
    pub fn of(code: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|language| language.code() == code)
    }

    /// A message without arguments; the key itself where there is none.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::English.word("normality"), "normality");
    /// assert_eq!(Language::Chinese.word("normality"), "正态性");
    /// ```
    pub fn word(self, key: &'static str) -> &'static str {
        catalogue::of(self).word(key).unwrap_or(key)
    }

    /// A message with arguments; the key itself where there is none.
    pub(crate) fn message(self, key: &str, arguments: &[(&'static str, Argument)]) -> String {
        catalogue::of(self).message(key, arguments).unwrap_or_else(|| key.to_string())
    }

    /// A word of a closed vocabulary of the reports (`free`, `at-bound`), by the message `term`; the word itself where that has none.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::Chinese.term("not-estimable"), "不可估计");
    /// assert_eq!(Language::Chinese.term("anything else"), "anything else");
    /// ```
    pub fn term(self, word: &str) -> String {
        say!(self, "term", word)
    }

    /// A text that the program has as data (of a built-in bench, comparison or effect, a note of a computation) in this language; a text that is
    /// not known stays as it is.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::Chinese.name("third-order nonlinearity along I"), "沿 I 的三阶非线性");
    /// assert_eq!(Language::Chinese.name("my own effect"), "my own effect");
    /// ```
    pub fn name(self, text: &str) -> Cow<'_, str> {
        names::say(self, text).map_or(Cow::Borrowed(text), Cow::Owned)
    }

    /// A word as a title: with a capital letter where the language has them.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::English.title("effect"), "Effect");
    /// ```
    pub fn title(self, word: &str) -> String {
        let mut letters = word.chars();
        match letters.next() {
            Some(first) if self.has_capitals() => first.to_uppercase().chain(letters).collect(),
            _ => word.to_string(),
        }
    }

    fn has_capitals(self) -> bool {
        self.word("has-capitals") == "yes"
    }

    /// So many of something: the message `count-<what>` with its plural.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::English.count(1, "reading"), "1 reading");
    /// assert_eq!(Language::English.count(30, "reading"), "30 readings");
    /// assert_eq!(Language::Chinese.count(30, "reading"), "30 个读数");
    /// ```
    pub fn count(self, n: usize, what: &str) -> String {
        self.message(&format!("count-{what}"), &[("n", Argument::Count(n))])
    }

    /// A list as prose: `a, b and c`.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::English.list(&["a", "b", "c"]), "a, b and c");
    /// assert_eq!(Language::Chinese.list(&["a", "b", "c"]), "a、b 和 c");
    /// ```
    pub fn list<T: AsRef<str>>(self, items: &[T]) -> String {
        match items.split_last() {
            None => String::new(),
            Some((last, [])) => last.as_ref().to_string(),
            Some((last, before)) => {
                let before: Vec<&str> = before.iter().map(AsRef::as_ref).collect();
                say!(self, "list-and", before = before.join(self.comma()), last = last.as_ref())
            }
        }
    }

    /// Names as prose, each in code type: `a` and `b`; `none` where there are none.
    pub(crate) fn names<T: AsRef<str>>(self, names: impl IntoIterator<Item = T>) -> String {
        let names: Vec<String> = names.into_iter().map(|name| code(name.as_ref())).collect();
        if names.is_empty() { say!(self, "none").into() } else { self.list(&names) }
    }

    /// The first of many, and how many more there are.
    pub(crate) fn first_of<T: AsRef<str>>(self, items: &[T], most: usize, separator: &str) -> String {
        let shown = items.iter().take(most).map(AsRef::as_ref).collect::<Vec<_>>().join(separator);
        match items.len().saturating_sub(most) {
            0 => shown,
            more => say!(self, "and-more", shown, more = more.to_string()),
        }
    }

    /// The separator of the items of a list.
    pub(crate) fn comma(self) -> &'static str {
        self.word("mark-comma")
    }

    /// The separator of the clauses of a sentence.
    pub(crate) fn semicolon(self) -> &'static str {
        self.word("mark-semicolon")
    }

    /// The separator of two parts of a clause.
    pub(crate) fn clause(self) -> &'static str {
        self.word("mark-clause")
    }

    /// The mark between a heading and what it announces.
    pub(crate) fn colon(self) -> &'static str {
        self.word("mark-colon")
    }

    /// A text in parentheses.
    pub(crate) fn in_parentheses(self, text: &str) -> String {
        say!(self, "in-parentheses", text)
    }

    /// The separator of two sentences of a paragraph.
    pub(crate) fn space(self) -> &'static str {
        self.word("mark-space")
    }

    /// A clause as a sentence: a capital letter where the language has them and a word begins it (the name of a parameter stays as it is), and a full
    /// stop; nothing stays nothing.
    ///
    /// ```
    /// use tumble::language::Language;
    /// assert_eq!(Language::English.sentence("it holds"), "It holds.");
    /// assert_eq!(Language::English.sentence("dtheta_y2 is free"), "dtheta_y2 is free.");
    /// assert_eq!(Language::Chinese.sentence("成立"), "成立。");
    /// ```
    pub fn sentence(self, clause: &str) -> String {
        let mut letters = clause.chars();
        let first = letters.next();
        let word = clause.split_whitespace().next().unwrap_or_default().trim_end_matches([',', ':', '.']);
        let is_word =
            word.chars().all(|c| c.is_lowercase() || c == '-' || c == '\'') && (word.len() > 1 || word == "a");
        let begin: String = match first {
            Some(c) if is_word && self.has_capitals() => c.to_uppercase().collect(),
            first => first.into_iter().collect(),
        };
        let ended = clause.ends_with(['.', '!', '?', '\u{3002}', '\u{ff01}', '\u{ff1f}']);
        let stop = if ended || clause.is_empty() { "" } else { self.word("mark-stop") };
        format!("{begin}{}{stop}", letters.as_str())
    }
}

/// A name in code type, its own backticks doubled; one without a letter stays as it is.
pub(crate) fn code(name: &str) -> String {
    let (mark, doubled) = (if name.trim_matches('`').is_empty() { "" } else { "`" }, name.replace('`', "``"));
    format!("{mark}{doubled}{mark}")
}

/// The runs of a text: is it in code type, and its letters. What stands between two backticks is; two in a row are one that belongs to the text, and so is
/// one without its pair.
pub(crate) fn runs(text: &str) -> Vec<(bool, String)> {
    let (mut runs, mut is_code, mut run, mut rest) = (Vec::new(), false, String::new(), text);
    while let Some((before, marked)) = rest.find('`').map(|at| rest.split_at(at)) {
        let after = marked.trim_start_matches('`');
        let marks = marked.len() - after.len();
        let is_paired = is_code || after.split(|c| c != '`').any(|marks| marks.len() % 2 == 1);
        let own = "`".repeat(if is_paired { marks / 2 } else { marks.div_ceil(2) });
        run += before;
        run += if is_code { own.as_str() } else { "" };
        if marks % 2 == 1 && is_paired {
            runs.push((is_code, std::mem::take(&mut run)));
            is_code = !is_code;
            run += if is_code { own.as_str() } else { "" };
        } else if !is_code {
            run += &own;
        }
        rest = after;
    }
    runs.push((is_code, run + rest));
    runs
}

/// A text without what sets its names in code type.
pub(crate) fn bare(text: &str) -> String {
    runs(text).into_iter().map(|(_, run)| run).collect()
}

/// Something that is made once for each language.
pub(crate) struct Each<T>([OnceLock<T>; Language::ALL.len()]);

impl<T> Each<T> {
    pub(crate) const fn new() -> Self {
        Each([const { OnceLock::new() }; Language::ALL.len()])
    }

    pub(crate) fn of(&self, language: Language, make: impl FnOnce(Language) -> T) -> &T {
        let [english, ..] = &self.0;
        // every language has its place: the array is as long as the list of them
        self.0.get(language as usize).unwrap_or(english).get_or_init(|| make(language))
    }
}

/// A message in a language: `say!(language, "key")` is a `&'static str`, `say!(language, "key", name = value, ..)` a `String`.
macro_rules! say {
    ($language:expr, $key:literal $(,)?) => {
        $language.word($key)
    };
    ($language:expr, $key:literal, $($name:ident $(= $value:expr)?),+ $(,)?) => {
        $language.message($key, &[$((stringify!($name), $crate::language::argument!($name $(= $value)?))),+])
    };
}

/// A message to be said later: `sentence!("key", name = value, ..)`.
macro_rules! sentence {
    ($key:literal $(, $name:ident $(= $value:expr)?)* $(,)?) => {
        $crate::language::Sentence::new($key, vec![$((stringify!($name), $crate::language::argument!($name $(= $value)?))),*])
    };
}

/// An argument, by its name alone or with a value.
macro_rules! argument {
    ($name:ident) => {
        $crate::language::Value::argument(&$name)
    };
    ($name:ident = $value:expr) => {
        $crate::language::Value::argument(&$value)
    };
}

pub(crate) use {argument, say, sentence};
