//! The links of a robot's file as a tree.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use drystone::Pose;

use super::element::{self, Joint};
use super::{Base, Options, geometry, inertia, massless};
use crate::error::SceneError;
use crate::links::{Assembled, Hold, Hulls, Link, Weight};
use crate::read::xml::Element;
use crate::scene::Scene;

/// The name of the link that is the world.
const WORLD: &str = "world";

/// A joint that follows another.
#[derive(Clone, Copy)]
struct Mimic<'a> {
    name: &'a str,
    of: &'a str,
    ratio: f32,
    offset: f32,
}

impl Mimic<'_> {
    /// Adds the coupling; otherwise why there is none.
    fn couple(&self, assembled: &Assembled, scene: &mut Scene) -> Result<(), String> {
        let Self { name, of, ratio, offset } = *self;
        if name == of {
            return Err("it mimics itself".to_owned());
        }
        let (own, other) = (assembled.coordinates.get(name), assembled.coordinates.get(of));
        let (Some(_), Some(_)) = (own, other) else {
            return Err(format!("it mimics '{of}', and not both are joints that turn or slide"));
        };
        if !(1.0e-6..=1.0e6).contains(&ratio.abs()) {
            return Err(format!("a multiplier of {ratio} is not followed"));
        }
        assembled.couple([name, of], [ratio, offset], scene);
        Ok(())
    }

    /// It as one that follows another, if both follow a third one.
    fn after(self, first: Self) -> Self {
        let ratio = self.ratio / first.ratio;
        Self { of: first.name, ratio, offset: self.offset - ratio * first.offset, ..self }
    }
}

/// Reads elements, and keeps the notes on them.
pub(super) struct Reader<'a> {
    folder: PathBuf,
    pub(super) notes: Vec<String>,
    mimics: Vec<Mimic<'a>>,
    /// Joints that were meant to move and do not.
    held: BTreeSet<String>,
    hulls: Hulls,
}

impl<'a> Reader<'a> {
    pub(super) fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_path_buf(),
            notes: Vec::new(),
            mimics: Vec::new(),
            held: BTreeSet::new(),
            hulls: Hulls::default(),
        }
    }

    /// Adds the couplings of joints that follow others. If a joint that others follow was held
    /// fast, the first of them leads the rest.
    pub(super) fn couple(&self, assembled: &Assembled, scene: &mut Scene) {
        let mut leaders: BTreeMap<&str, Mimic<'a>> = BTreeMap::new();
        for &mimic in &self.mimics {
            let made = if self.held.contains(mimic.name) {
                Err("it does not move".to_owned())
            } else if !self.held.contains(mimic.of) {
                mimic.couple(assembled, scene)
            } else if let Some(first) = leaders.get(mimic.of) {
                mimic.after(*first).couple(assembled, scene)
            } else {
                leaders.insert(mimic.of, mimic);
                let Mimic { name, of, .. } = mimic;
                let told = format!(
                    "joint {name}: for '{of}', which does not move, it leads its followers"
                );
                scene.notes.push(told);
                Ok(())
            };
            if let Err(why) = made {
                let note = format!("joint {}: its mimic is left out: {why}", mimic.name);
                scene.left_out.push(note.clone());
                scene.notes.push(note);
            }
        }
    }

    /// The links from the first one on, each behind its parent.
    pub(super) fn tree(
        &mut self,
        robot: &Element<'a>,
        options: &Options,
    ) -> Result<Vec<Link<'a>>, SceneError> {
        let elements: Vec<Element<'a>> = robot.all("link").collect();
        let mut number: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, link) in elements.iter().enumerate() {
            if number.insert(link.need("name")?, i).is_some() {
                return Err(link.error("another link has this name", "a name of its own"));
            }
        }
        if elements.is_empty() {
            return Err(robot.error("it has no link", "at least one"));
        }
        let is_drake = |e: &Element<'a>| e.prefix().is_none_or(|p| p == "drake");
        let joints: Vec<Element<'a>> =
            robot.children().filter(|e| e.tag() == "joint" && is_drake(e)).collect();
        let hangs_on_world = |joint: &Element<'_>| {
            joint.child("parent").is_some_and(|p| p.get("link") == Some(WORLD))
        };
        let mut count = elements.len();
        if !number.contains_key(WORLD) && joints.iter().any(hangs_on_world) {
            number.insert(WORLD, count);
            count += 1;
        }
        let name = |i: usize| {
            elements.get(i).map_or(WORLD, |link: &Element<'a>| link.get("name").unwrap_or_default())
        };
        let mut above: Vec<Option<Joint<'_>>> = (0..count).map(|_| None).collect();
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); count];
        let mut names: BTreeMap<&str, ()> = BTreeMap::new();
        for element in joints {
            if names.insert(element.need("name")?, ()).is_some() {
                return Err(element.error("another joint has this name", "a name of its own"));
            }
            let joint = self.joint(&element, &number)?;
            if let Some(other) = &above[joint.child] {
                let problem = format!(
                    "its child '{}' is the child of joint '{}' already",
                    name(joint.child),
                    other.name
                );
                return Err(element.error(problem, "a tree: one joint above each link"));
            }
            below[joint.parent].push(joint.child);
            let child = joint.child;
            above[child] = Some(joint);
        }
        let roots: Vec<usize> = (0..count).filter(|i| above[*i].is_none()).collect();
        let allowed = "a tree with one link that is no joint's child";
        let root = match roots[..] {
            [root] => root,
            [] => return Err(robot.error("its joints form a loop, no link is the first", allowed)),
            [a, b, ..] => {
                let problem = format!("no joint is above '{}', nor above '{}'", name(a), name(b));
                return Err(elements.get(b).unwrap_or(robot).error(problem, allowed));
            }
        };
        let mut links: Vec<Link<'a>> = Vec::with_capacity(count);
        let mut place: Vec<Option<usize>> = vec![None; count];
        let mut stack = vec![root];
        while let Some(i) = stack.pop() {
            let mut link = match elements.get(i) {
                Some(element) => self.link(element)?,
                None => Self::world(robot),
            };
            if let Some(joint) = above[i].take() {
                link.parent = place[joint.parent];
                link.pose = joint.origin;
                link.hold = joint.hold;
            }
            place[i] = Some(links.len());
            links.push(link);
            stack.extend(below[i].iter().rev());
        }
        if let Some(lost) = place.iter().position(Option::is_none) {
            let problem = "its joints form a loop that the first link is not in";
            return Err(elements.get(lost).unwrap_or(robot).error(problem, allowed));
        }
        massless::settle(&mut links, &mut self.held, &mut self.notes);
        links[0].hold = self.base(&links, options.base);
        massless::finish(&mut links, &mut self.notes);
        Ok(links)
    }

    /// The hold of the first link, which moves if it is free.
    fn base(&mut self, links: &[Link<'_>], base: Base) -> Hold {
        let mut is_base = vec![true; links.len()];
        let mut moving = 0;
        for (i, link) in links.iter().enumerate().skip(1) {
            let on_base = link.parent.is_some_and(|p| is_base[p]);
            is_base[i] = on_base && link.hold == Hold::Fast;
            moving += usize::from(on_base && matches!(link.hold, Hold::Joints(_)));
        }
        let name = &links[0].name;
        let others_free = links.iter().any(|l| l.hold == Hold::Free && l.parent.is_some());
        let (is_fixed, why) = match base {
            Base::Fixed => (true, String::new()),
            Base::Floating => (false, String::new()),
            Base::Auto if name == WORLD => (true, "it is called world".to_owned()),
            Base::Auto if massless::is_root(links) => (true, "it has no mass".to_owned()),
            Base::Auto if others_free => (true, "a link floats from it".to_owned()),
            Base::Auto => match moving {
                1 => (true, "one joint moves on it".to_owned()),
                n => (false, format!("{n} joints move on it")),
            },
        };
        if base == Base::Auto {
            let (state, other) =
                if is_fixed { ("fixed to the world", "floating") } else { ("free", "fixed") };
            self.notes.push(format!(
                "base '{name}': {state}, because {why}; --base {other} says otherwise"
            ));
        }
        if is_fixed { Hold::World } else { Hold::Free }
    }

    fn link(&mut self, element: &Element<'a>) -> Result<Link<'a>, SceneError> {
        let name = element.need("name")?.to_owned();
        let weight = match element.child("inertial") {
            Some(inertial) => {
                let (mass, note) = inertia::read(&inertial)?;
                self.notes.extend(note.map(|note| format!("{name}: {note}")));
                Weight::Given(mass)
            }
            None => Weight::Unsaid,
        };
        let material = element::material(element)?;
        let mut shapes = Vec::new();
        let mut left_out = None;
        for collision in element.all("collision") {
            let found = geometry::collision(&collision, &self.folder, &mut self.hulls)?;
            match found {
                Ok((shape, note)) => {
                    shapes.push(shape.with_material(material));
                    if let Some(note) = note {
                        self.notes.push(format!("{name}: {note}"));
                    }
                }
                Err(why) => {
                    self.notes.push(format!("{name}: a collision is left out: {why}"));
                    left_out.get_or_insert(why);
                }
            }
        }
        Ok(Link {
            name,
            element: *element,
            parent: None,
            pose: Pose::IDENTITY,
            hold: Hold::Fast,
            weight,
            shapes,
            left_out,
            gravity_scale: 1.0,
        })
    }

    /// The world as a link, for a file that hangs on it without having it.
    fn world(robot: &Element<'a>) -> Link<'a> {
        Link {
            name: WORLD.to_owned(),
            element: *robot,
            parent: None,
            pose: Pose::IDENTITY,
            hold: Hold::Fast,
            weight: Weight::Unsaid,
            shapes: Vec::new(),
            left_out: None,
            gravity_scale: 1.0,
        }
    }

    fn joint(
        &mut self,
        element: &Element<'a>,
        number: &BTreeMap<&str, usize>,
    ) -> Result<Joint<'a>, SceneError> {
        let read = element::joint(element, number)?;
        self.notes.extend(read.note.iter().cloned());
        if let Some((of, ratio, offset)) = read.mimic {
            self.mimics.push(Mimic { name: read.name, of, ratio, offset });
        }
        Ok(read)
    }
}
