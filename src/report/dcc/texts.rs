//! Elements of the certificate, and the languages of its texts.

use crate::language::Language;
use quick_xml::Writer;
use quick_xml::events::BytesText;
use std::io;

pub(super) type Xml = Writer<Vec<u8>>;

/// The languages of the certificate's texts. A text that is there in every declared language says which is which; others say nothing, as PTB's
/// Schematron wants it.
#[derive(Clone, Copy)]
pub(super) struct Texts<'a> {
    lang: Language,
    /// The language of the laboratory's texts.
    lab: &'a str,
}

impl<'a> Texts<'a> {
    pub(super) fn new(lang: Language, lab: &'a str) -> Self {
        Texts { lang, lab }
    }

    /// The languages that this program's texts are in.
    fn program(&self) -> impl Iterator<Item = Language> + use<> {
        let english = (self.lang != Language::English).then_some(Language::English);
        [self.lang].into_iter().chain(english)
    }

    /// Every language that texts are in, the laboratory's first.
    pub(super) fn declared(&self) -> impl Iterator<Item = &'a str> {
        let lab = self.lab;
        std::iter::once(lab)
            .chain(self.program().map(|lang| -> &'a str { lang.code() }).filter(move |code| *code != lab))
    }

    /// An element of `dcc:textType` with a text of the laboratory or the campaign.
    pub(super) fn own(&self, xml: &mut Xml, name: &str, value: &str) -> io::Result<()> {
        let language = (self.declared().count() == 1).then_some(self.lab);
        within(xml, name, |xml| content(xml, value, language))
    }
}

/// An element of `dcc:textType` that this program words: in the language asked for, and in English.
pub(super) fn told(xml: &mut Xml, name: &str, texts: Texts<'_>, said: impl Fn(Language) -> String) -> io::Result<()> {
    let all = texts.declared().count() == texts.program().count();
    within(xml, name, |xml| texts.program().try_for_each(|lang| content(xml, &said(lang), all.then(|| lang.code()))))
}

pub(super) fn within(xml: &mut Xml, name: &str, inside: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
    xml.create_element(name).write_inner_content(inside)?;
    Ok(())
}

/// The same with a type of PTB's lists of good practice, where there is one.
pub(super) fn of_type(
    xml: &mut Xml,
    name: &str,
    ref_type: Option<&str>,
    inside: impl FnOnce(&mut Xml) -> io::Result<()>,
) -> io::Result<()> {
    let attribute = ref_type.map(|ref_type| ("refType", ref_type));
    xml.create_element(name).with_attributes(attribute).write_inner_content(inside)?;
    Ok(())
}

pub(super) fn text(xml: &mut Xml, name: &str, value: &str) -> io::Result<()> {
    xml.create_element(name).write_text_content(BytesText::new(&printable(value)))?;
    Ok(())
}

/// A `dcc:content`, in a language where that is said.
fn content(xml: &mut Xml, value: &str, language: Option<&str>) -> io::Result<()> {
    let element = xml.create_element("dcc:content").with_attributes(language.map(|code| ("lang", code)));
    element.write_text_content(BytesText::new(&printable(value)))?;
    Ok(())
}

/// Characters that XML 1.0 cannot hold become replacement characters.
fn printable(value: &str) -> String {
    let bad = |c: char| (c.is_control() && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}');
    value.chars().map(|c| if bad(c) { '\u{fffd}' } else { c }).collect()
}
