//! XML whose every element has its place, so that a wrong value can be named; nothing of the
//! content is trusted.

use core::fmt::Display;
use std::borrow::Cow;
use std::path::Path;

use drystone::Vec3;
use roxmltree::{Document, Error, Node, ParsingOptions};

use super::text;
use crate::error::SceneError;

/// More elements, attributes and texts than this are refused.
const MAX_NODES: u32 = 4_000_000;

/// The text of a file.
pub(crate) fn file(path: &Path) -> Result<String, SceneError> {
    text(path, "an XML file")
}

/// Most prefixes of names that no element declares.
const MAX_PREFIXES: usize = 16;

/// The text, with what the XML readers of robot simulators let pass and the standard does not: an
/// XML declaration or a DOCTYPE without entities behind the start of the file becomes spaces, a
/// prefix that no element declares is declared by the outermost one, and zeros at the end, as C
/// writes them, are no text. Lines keep their numbers.
pub(crate) fn mended(text: &str) -> Cow<'_, str> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end_matches('\0');
    let mut out = Cow::Borrowed(text);
    let mut at = 0;
    loop {
        at += out[at..].len() - out[at..].trim_start().len();
        let rest = &out[at..];
        let end = |mark: &str| rest.find(mark).map(|i| at + i + mark.len());
        let (end, is_blanked) = if rest.starts_with("<!--") {
            (end("-->"), false)
        } else if rest.starts_with("<?") {
            (end("?>"), at > 0 && rest.starts_with("<?xml") && !rest.starts_with("<?xml-"))
        } else if rest.starts_with("<!DOCTYPE") {
            let end = end(">");
            (end, end.is_some_and(|end| !out[at..end].contains('[')))
        } else {
            break;
        };
        let Some(end) = end else { break };
        if is_blanked {
            let blank = |c: char| if c == '\n' { '\n' } else { ' ' };
            let spaces: String = out[at..end].chars().map(blank).collect();
            out.to_mut().replace_range(at..end, &spaces);
            at += spaces.len();
        } else {
            at = end;
        }
    }
    for _ in 0..MAX_PREFIXES {
        let Err(Error::UnknownNamespace(prefix, _)) = document(&out) else { break };
        let name = out[at..].find(|c: char| c.is_whitespace() || c == '>' || c == '/');
        let Some(name) = name else { break };
        out.to_mut().insert_str(at + name, &format!(" xmlns:{prefix}=\"{prefix}\""));
    }
    out
}

fn document(text: &str) -> Result<Document<'_>, Error> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..Default::default() };
    Document::parse_with_options(text, options)
}

/// The document of a text. Entities of its own, which can blow a file up, are refused with the DTD
/// that would declare them.
pub(crate) fn parse(text: &str) -> Result<Document<'_>, SceneError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let document = document(text).map_err(|e| {
        let place = format!("line {}", e.pos().row);
        SceneError::new(Path::new(""), &place, format!("broken XML: {e}"), "well-formed XML")
    })?;
    Ok(document)
}

/// An element of a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Element<'a> {
    node: Node<'a, 'a>,
    /// The file it is in, if that is not the requested one.
    file: &'a str,
}

impl<'a> Element<'a> {
    /// The outermost element, which must be `tag`.
    pub(crate) fn root(document: &'a Document<'a>, tag: &str) -> Result<Self, SceneError> {
        let root = Self::outermost(document, "");
        if root.tag() == tag {
            return Ok(root);
        }
        Err(root.error(format!("the outermost element is <{}>", root.tag()), &format!("<{tag}>")))
    }

    /// The outermost element of a document read from `file`; empty: the requested file.
    pub(crate) fn outermost(document: &'a Document<'a>, file: &'a str) -> Self {
        Self { node: document.root_element(), file }
    }

    /// The file it is in; empty: the requested one.
    pub(crate) fn file(&self) -> &'a str {
        self.file
    }

    pub(crate) fn tag(&self) -> &'a str {
        self.node.tag_name().name()
    }

    /// The prefix of its tag, as of `drake:joint`.
    pub(crate) fn prefix(&self) -> Option<&'a str> {
        self.node.lookup_prefix(self.node.tag_name().namespace()?)
    }

    /// Its tag with the prefix.
    pub(crate) fn full_tag(&self) -> Cow<'a, str> {
        match self.prefix() {
            Some(prefix) => Cow::Owned(format!("{prefix}:{}", self.tag())),
            None => Cow::Borrowed(self.tag()),
        }
    }

    /// `line 7, <joint name="knee">`.
    pub(crate) fn place(&self) -> String {
        let line = self.node.document().text_pos_at(self.node.range().start).row;
        let name = self.get("name").map_or_else(String::new, |n| format!(" name=\"{n}\""));
        let file = if self.file.is_empty() { "" } else { &format!("{} ", self.file) };
        format!("{file}line {line}, <{}{name}>", self.full_tag())
    }

    pub(crate) fn error(&self, problem: impl Display, allowed: &str) -> SceneError {
        SceneError::new(Path::new(""), &self.place(), problem, allowed)
    }

    /// An error about an attribute that is there.
    pub(crate) fn wrong(&self, name: &str, allowed: &str) -> SceneError {
        let value = self.get(name).unwrap_or_default();
        self.error(format!("{name}=\"{value}\""), allowed)
    }

    /// The elements inside, in order.
    pub(crate) fn children(&self) -> impl Iterator<Item = Element<'a>> + use<'a> {
        let file = self.file;
        self.node.children().filter(Node::is_element).map(move |node| Element { node, file })
    }

    /// The elements inside called `tag`.
    pub(crate) fn all(&self, tag: &'static str) -> impl Iterator<Item = Element<'a>> + use<'a> {
        self.children().filter(move |e| e.tag() == tag)
    }

    /// The first element inside called `tag`.
    pub(crate) fn child(&self, tag: &'static str) -> Option<Element<'a>> {
        self.all(tag).next()
    }

    pub(crate) fn attributes(&self) -> impl Iterator<Item = (&'a str, &'a str)> + use<'a> {
        self.node.attributes().map(|a| (a.name(), a.value()))
    }

    pub(crate) fn get(&self, name: &str) -> Option<&'a str> {
        self.node.attribute(name)
    }

    pub(crate) fn need(&self, name: &str) -> Result<&'a str, SceneError> {
        self.get(name).ok_or_else(|| self.error(format!("{name} is missing"), "it to be given"))
    }

    /// Up to `most` finite numbers, if the attribute is there.
    pub(crate) fn list(&self, name: &str, most: usize) -> Result<Option<Vec<f32>>, SceneError> {
        let Some(text) = self.get(name) else { return Ok(None) };
        numbers(text, most).map(Some).map_err(|allowed| self.wrong(name, &allowed))
    }

    /// Exactly `N` finite numbers, if the attribute is there.
    pub(crate) fn numbers<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<[f32; N]>, SceneError> {
        let Some(list) = self.list(name, N)? else { return Ok(None) };
        let count = if N == 1 { "a finite number" } else { &format!("{N} finite numbers") };
        list.try_into().map(Some).map_err(|_| self.wrong(name, count))
    }

    pub(crate) fn number(&self, name: &str) -> Result<Option<f32>, SceneError> {
        Ok(self.numbers::<1>(name)?.map(|[x]| x))
    }

    /// A number above 0.
    pub(crate) fn above_zero(&self, name: &str) -> Result<f32, SceneError> {
        self.need(name)?;
        match self.number(name)? {
            Some(x) if x > 0.0 => Ok(x),
            _ => Err(self.wrong(name, "a number above 0")),
        }
    }

    /// A number of at least 0, if the attribute is there.
    pub(crate) fn at_least_zero(&self, name: &str) -> Result<Option<f32>, SceneError> {
        match self.number(name)? {
            Some(x) if x < 0.0 => Err(self.wrong(name, "a number of at least 0")),
            x => Ok(x),
        }
    }

    pub(crate) fn vec3(&self, name: &str) -> Result<Option<Vec3>, SceneError> {
        Ok(self.numbers::<3>(name)?.map(Vec3::from))
    }
}

/// Up to `most` finite numbers; otherwise the values that are allowed.
pub(crate) fn numbers(text: &str, most: usize) -> Result<Vec<f32>, String> {
    let mut out = Vec::new();
    for word in text.split_whitespace() {
        let number = word.parse::<f32>().ok().filter(|x| x.is_finite());
        match number {
            Some(x) if out.len() < most => out.push(x),
            Some(_) => {
                return Err(if most == 1 {
                    "a finite number".to_owned()
                } else {
                    format!("up to {most} finite numbers")
                });
            }
            None if most == 1 => return Err("a finite number".to_owned()),
            None => return Err("finite numbers".to_owned()),
        }
    }
    Ok(out)
}
