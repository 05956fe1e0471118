//! XML and HTML read back as a tree, for the tests of pages and certificates.
#![allow(dead_code, reason = "each test uses its part")]

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// An element with its text and its children.
#[derive(Debug, Clone, Default)]
pub struct Element {
    pub name: String,
    pub attributes: Vec<(String, String)>,
    pub text: String,
    pub children: Vec<Element>,
}

impl Element {
    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// Every element of this name at or below this one, in document order.
    pub fn all(&self, name: &str) -> Vec<Element> {
        let own = (self.name == name).then(|| self.clone());
        own.into_iter().chain(self.children.iter().flat_map(|child| child.all(name))).collect()
    }

    /// The text of the first element of this name below; empty if there is none.
    pub fn text_of(&self, name: &str) -> String {
        self.all(name).first().map(|element| element.text.clone()).unwrap_or_default()
    }
}

/// The root element of a well-formed text; panics where it is not well-formed.
pub fn element(text: &str) -> Element {
    let mut reader = Reader::from_str(text);
    let mut open = vec![Element::default()];
    loop {
        match reader.read_event().unwrap() {
            Event::Start(start) => open.push(started(&start)),
            Event::Empty(start) => {
                let element = started(&start);
                open.last_mut().unwrap().children.push(element);
            }
            Event::End(_) => {
                let mut element = open.pop().unwrap();
                if !element.children.is_empty() {
                    element.text = element.text.trim().to_string();
                }
                let within = open.last_mut().unwrap();
                // the words of a link are words of the sentence
                if element.name == "a" {
                    within.text.push_str(&element.text);
                }
                within.children.push(element);
            }
            Event::Text(text) => open.last_mut().unwrap().text.push_str(&text.xml10_content()),
            Event::GeneralRef(reference) => {
                let name = reference.xml10_content().to_string();
                let text = match quick_xml::escape::resolve_predefined_entity(&name) {
                    Some(text) => text.to_string(),
                    None => reference.resolve_char_ref().unwrap().unwrap().to_string(),
                };
                open.last_mut().unwrap().text.push_str(&text);
            }
            Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(open.len(), 1, "an element is not closed");
    open.remove(0).children.remove(0)
}

fn started(start: &BytesStart<'_>) -> Element {
    Element {
        name: start.name().as_ref().to_string(),
        attributes: start
            .attributes()
            .map(|attribute| attribute.unwrap())
            .map(|a| {
                (
                    a.key.as_ref().to_string(),
                    a.normalized_value(quick_xml::XmlVersion::Implicit1_0).unwrap().to_string(),
                )
            })
            .collect(),
        ..Element::default()
    }
}
