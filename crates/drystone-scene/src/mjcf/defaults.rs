//! Default classes: what an element says by its class and the classes around that one.

use std::collections::BTreeMap;

use drystone::Vec3;

use crate::error::SceneError;
use crate::read::xml::Element;

/// Most elements of a class, and most classes around it: each element of a file goes through all of
/// them.
const MOST_ELEMENTS: usize = 256;
const MOST_DEEP: usize = 64;

/// A class of defaults.
#[derive(Clone, Debug)]
struct Class<'a> {
    parent: Option<usize>,
    /// Classes around it.
    depth: usize,
    /// The class's defaults for each kind of element, in order.
    elements: Vec<Element<'a>>,
}

/// All classes of a model; the first is the one around all others, if there is any.
#[derive(Clone, Debug, Default)]
pub(super) struct Defaults<'a> {
    classes: Vec<Class<'a>>,
    names: BTreeMap<&'a str, usize>,
}

impl<'a> Defaults<'a> {
    /// Adds a `<default>` of the model and the classes in it; `children` are the elements inside
    /// one.
    pub(super) fn add(
        &mut self,
        section: &Element<'a>,
        children: impl Fn(&Element<'a>) -> Result<Vec<Element<'a>>, SceneError>,
    ) -> Result<(), SceneError> {
        let mut stack = vec![(*section, None)];
        while let Some((element, parent)) = stack.pop() {
            let known = if parent.is_none() && !self.classes.is_empty() { Some(0) } else { None };
            let number = known.unwrap_or(self.classes.len());
            if known.is_none() {
                let name = match parent {
                    None => element.get("class").unwrap_or("main"),
                    Some(_) => element.need("class")?,
                };
                if self.names.insert(name, number).is_some() {
                    return Err(element.error(
                        format!("another class is called \"{name}\""),
                        "a name of its own",
                    ));
                }
                let depth = parent.map_or(0, |p: usize| self.classes[p].depth + 1);
                if depth > MOST_DEEP {
                    let allowed = format!("up to {MOST_DEEP} classes within each other");
                    return Err(element.error("its class stands too deep", &allowed));
                }
                self.classes.push(Class { parent, depth, elements: Vec::new() });
            }
            let mut inner = Vec::new();
            for child in children(&element)? {
                if child.tag() == "default" {
                    inner.push((child, Some(number)));
                } else {
                    self.classes[number].elements.push(child);
                    if self.classes[number].elements.len() > MOST_ELEMENTS {
                        let allowed = format!("up to {MOST_ELEMENTS} elements in a class");
                        return Err(child.error("its class says too much", &allowed));
                    }
                }
            }
            stack.extend(inner.into_iter().rev());
        }
        Ok(())
    }

    /// The class that an attribute of an element names, if it is there.
    pub(super) fn named(
        &self,
        element: &Element<'a>,
        attribute: &str,
    ) -> Result<Option<usize>, SceneError> {
        let Some(name) = element.get(attribute) else { return Ok(None) };
        match self.names.get(name) {
            Some(class) => Ok(Some(*class)),
            None => Err(element.wrong(attribute, "a class of <default>")),
        }
    }

    /// The element with its defaults: of its own class, else of `around`, else of the first.
    pub(super) fn view(
        &self,
        element: Element<'a>,
        around: Option<usize>,
    ) -> Result<View<'a>, SceneError> {
        let tag = match element.tag() {
            "connect" | "weld" => "equality",
            "joint" if element.get("joint1").is_some() => "equality",
            "spatial" | "fixed" => "tendon",
            other => other,
        };
        let mut sources = vec![element];
        sources.extend(self.said(&element, around, &[tag])?);
        Ok(View { sources })
    }

    /// The elements of an element's classes by elements of these tags, the nearest first.
    pub(super) fn said(
        &self,
        element: &Element<'a>,
        around: Option<usize>,
        tags: &[&str],
    ) -> Result<Vec<Element<'a>>, SceneError> {
        let first = (!self.classes.is_empty()).then_some(0);
        let mut class = self.named(element, "class")?.or(around).or(first);
        let mut out = Vec::new();
        while let Some(number) = class {
            let Class { parent, elements, .. } = &self.classes[number];
            out.extend(elements.iter().rev().filter(|e| tags.contains(&e.tag())));
            class = *parent;
        }
        Ok(out)
    }
}

/// An element with its defaults.
#[derive(Clone, Debug)]
pub(super) struct View<'a> {
    /// The element, then what its classes say, the nearest first.
    sources: Vec<Element<'a>>,
}

impl<'a> View<'a> {
    /// Without defaults.
    pub(super) fn bare(element: Element<'a>) -> Self {
        Self { sources: vec![element] }
    }

    /// With what its classes say, the nearest first.
    pub(super) fn of(element: Element<'a>, said: &[Element<'a>]) -> Self {
        Self { sources: [&[element], said].concat() }
    }

    pub(super) fn element(&self) -> &Element<'a> {
        &self.sources[0]
    }

    /// The nearest of these attributes, and the element that has it.
    pub(super) fn first(&self, names: &[&'static str]) -> Option<(&'static str, Element<'a>)> {
        self.sources.iter().find_map(|source| {
            names.iter().find(|n| source.get(n).is_some()).map(|n| (*n, *source))
        })
    }

    /// The element that says this attribute; the element itself if none does.
    pub(super) fn source(&self, name: &str) -> Element<'a> {
        let has = self.sources.iter().find(|s| s.get(name).is_some());
        *has.unwrap_or(&self.sources[0])
    }

    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        self.sources.iter().find_map(|s| s.get(name))
    }

    pub(super) fn number(&self, name: &str) -> Result<Option<f32>, SceneError> {
        self.source(name).number(name)
    }

    pub(super) fn at_least_zero(&self, name: &str) -> Result<f32, SceneError> {
        Ok(self.source(name).at_least_zero(name)?.unwrap_or(0.0))
    }

    pub(super) fn numbers<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<[f32; N]>, SceneError> {
        self.source(name).numbers(name)
    }

    pub(super) fn list(&self, name: &str, most: usize) -> Result<Vec<f32>, SceneError> {
        Ok(self.source(name).list(name, most)?.unwrap_or_default())
    }

    pub(super) fn vec3(&self, name: &str) -> Result<Option<Vec3>, SceneError> {
        self.source(name).vec3(name)
    }

    pub(super) fn wrong(&self, name: &str, allowed: &str) -> SceneError {
        self.source(name).wrong(name, allowed)
    }

    /// Whether a range holds: as `limited` says, else if there is one.
    pub(super) fn is_limited(&self, automatic: bool) -> Result<bool, SceneError> {
        match self.get("limited") {
            None | Some("auto") => Ok(automatic && self.get("range").is_some()),
            Some("true") => Ok(true),
            Some("false") => Ok(false),
            Some(_) => Err(self.wrong("limited", "true, false or auto")),
        }
    }
}
