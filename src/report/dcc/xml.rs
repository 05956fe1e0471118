//! The certificate as a tree of elements, and the languages of its texts.

use crate::document::xml::printable;
use crate::language::Language;
use quick_xml::Writer;
use quick_xml::events::BytesText;
use std::io;

/// An element: its attributes, and a text or what is inside.
pub(super) struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    text: Option<String>,
    inside: Vec<Element>,
}

/// An element with nothing inside yet.
pub(super) fn element(name: &'static str) -> Element {
    Element { name, attributes: Vec::new(), text: None, inside: Vec::new() }
}

/// An element with a text.
pub(super) fn text(name: &'static str, value: impl AsRef<str>) -> Element {
    Element { text: Some(printable(value.as_ref())), ..element(name) }
}

impl Element {
    /// Put an attribute to it.
    pub(super) fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.attributes.push((name, value.into()));
        self
    }

    /// Put a type of PTB's lists of good practice to it, where there is one.
    pub(super) fn of_type(self, ref_type: Option<&str>) -> Self {
        ref_type.into_iter().fold(self, |element, ref_type| element.with("refType", ref_type))
    }

    /// Put elements into it: none, one or many.
    pub(super) fn add(mut self, inside: impl IntoIterator<Item = Element>) -> Self {
        self.inside.extend(inside);
        self
    }

    pub(super) fn write(&self, xml: &mut Writer<Vec<u8>>) -> io::Result<()> {
        let attributes = self.attributes.iter().map(|(name, value)| (*name, value.as_str()));
        let element = xml.create_element(self.name).with_attributes(attributes);
        match &self.text {
            Some(text) => element.write_text_content(BytesText::new(text))?,
            None => element.write_inner_content(|xml| self.inside.iter().try_for_each(|child| child.write(xml)))?,
        };
        Ok(())
    }
}

/// One element is what stands in another.
impl IntoIterator for Element {
    type Item = Element;
    type IntoIter = std::iter::Once<Element>;

    fn into_iter(self) -> Self::IntoIter {
        std::iter::once(self)
    }
}

/// The languages of the certificate's texts. A text that is there in every declared language says which is which; others say nothing, as PTB's
/// Schematron wants it.
#[derive(Clone, Copy)]
pub(super) struct Texts<'a> {
    pub lang: Language,
    /// The language of the laboratory's texts.
    pub lab: &'a str,
}

impl<'a> Texts<'a> {
    /// The languages that this program's texts are in.
    fn program(&self) -> impl Iterator<Item = Language> + use<> {
        let english = (self.lang != Language::English).then_some(Language::English);
        [self.lang].into_iter().chain(english)
    }

    /// Every language that texts are in, the laboratory's first.
    pub(super) fn declared(&self) -> impl Iterator<Item = &'a str> {
        let lab = self.lab;
        let program = self.program().map(|lang| -> &'a str { lang.code() });
        std::iter::once(lab).chain(program.filter(move |code| *code != lab))
    }

    /// An element of `dcc:textType` with a text of the laboratory or the campaign.
    pub(super) fn own(&self, name: &'static str, value: &str) -> Element {
        let language = (self.declared().count() == 1).then_some(self.lab);
        element(name).add(content(value, language))
    }

    /// An element of `dcc:textType` that this program words: in the language asked for, and in English.
    pub(super) fn said(&self, name: &'static str, said: impl Fn(Language) -> String) -> Element {
        let all = self.declared().count() == self.program().count();
        element(name).add(self.program().map(|lang| content(&said(lang), all.then(|| lang.code()))))
    }
}

/// A `dcc:content`, in a language where that is said.
fn content(value: &str, language: Option<&str>) -> Element {
    language.into_iter().fold(text("dcc:content", value), |element, code| element.with("lang", code))
}
