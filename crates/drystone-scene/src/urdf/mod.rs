//! URDF, the Unified Robot Description Format: links, and the joints between them, as a tree.
//!
//! Read with an XML parser that keeps the line of every element, not with `urdf-rs`
//! (`docs/decisions/019-robot-files.md`). Links that fixed joints hold are one body with their
//! parent. Links with a joint between them do not collide, nor do links that overlap as the file
//! has them. Elements that only concern pictures, motors or sensors are left out; those that could
//! matter are noted.

mod element;
mod overlap;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use drystone::{BodyDef, Pose, ShapeDef, vec3};

use self::element::{Joint, JointType};
use crate::error::SceneError;
use crate::links::{Anchored, Assembled, Hold, Hulls, Link, Weight, assemble};
use crate::read::xml::{self, Element};
use crate::scene::Scene;

/// The name of the link that is the world.
const WORLD: &str = "world";

/// Whether the first link is held by the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Base {
    /// As it looks. A link called `world` is held, and so is one on which exactly one joint moves,
    /// as an arm's does. A link with several joints, as on legs or wheels, is free, and so is a
    /// single body.
    #[default]
    Auto,
    /// Held.
    Fixed,
    /// Free.
    Floating,
}

/// How to read a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The base of the first link.
    pub base: Base,
    /// Height of a ground to add [m]; `None`: there is none, as the format has none.
    pub ground: Option<f32>,
}

/// Reads a `.urdf` file.
///
/// # Errors
/// A line that names the file, the place in it, what is wrong and what is allowed.
pub fn load(path: &Path, options: &Options) -> Result<Scene, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let text = xml::file(path)?;
    from_text(&text, folder, options).map_err(|e| e.in_file(path))
}

/// Reads a scene from the text of a `.urdf` file whose meshes are beside or above `folder`.
///
/// # Errors
/// A line that names the place in the file, what is wrong and what is allowed.
pub fn from_text(text: &str, folder: &Path, options: &Options) -> Result<Scene, SceneError> {
    let document = xml::parse(text)?;
    let robot = Element::root(&document, "robot")?;
    let mut scene = Scene::new(robot.get("name").unwrap_or("robot"), "");
    scene.config.gravity = vec3(0.0, 0.0, -9.81);
    if let Some(height) = options.ground {
        let ground = ShapeDef::half_space([0.0, 0.0, 1.0], height);
        scene.add("ground", BodyDef::fixed().with_shape(ground));
    }
    let mut reader = Reader {
        folder: folder.to_path_buf(),
        notes: Vec::new(),
        ignored: BTreeMap::new(),
        unused_limits: false,
        mimics: Vec::new(),
        hulls: Hulls::default(),
    };
    let links = reader.tree(&robot, options)?;
    scene.left_out.extend(reader.notes.iter().filter(|n| n.contains("left out")).cloned());
    scene.notes.append(&mut reader.notes);
    for (what, count) in &reader.ignored {
        let note = format!("{count} {what}");
        scene.left_out.push(note.clone());
        scene.notes.push(note);
    }
    if reader.unused_limits {
        let why = "bound motors, and nothing drives the joints: not read";
        scene.notes.push(format!("limits of effort and velocity: they {why}"));
    }
    let first = scene.bodies.len();
    let mut assembled = assemble(&links, Anchored::Passes, &mut scene)?;
    for mimic in &reader.mimics {
        mimic.couple(&assembled, &mut scene)?;
    }
    overlap::exclude(&links, &mut assembled, first, &mut scene);
    let joints = links.iter().filter(|l| matches!(l.hold, Hold::Joints(_))).count();
    scene.summary = format!("a robot of {} links and {joints} joints that move", links.len());
    Ok(scene)
}

/// A joint that follows another.
struct Mimic<'a> {
    element: Element<'a>,
    name: &'a str,
    of: &'a str,
    ratio: f32,
    offset: f32,
}

impl Mimic<'_> {
    fn couple(&self, assembled: &Assembled, scene: &mut Scene) -> Result<(), SceneError> {
        let Self { name, of, ratio, offset, .. } = *self;
        let (own, other) = (assembled.coordinates.get(name), assembled.coordinates.get(of));
        let (Some(own), Some(other)) = (own, other) else {
            let problem = format!("it mimics '{of}', which is no joint that turns or slides");
            return Err(self.element.error(problem, "revolute, continuous and prismatic joints"));
        };
        if name == of {
            return Err(self.element.error("it mimics itself", "another joint"));
        }
        if !(1.0e-6..=1.0e6).contains(&ratio.abs()) {
            scene.notes.push(format!("joint {name}: a multiplier of {ratio} is not followed"));
            return Ok(());
        }
        scene.couplings.push(own.follow(other, ratio, offset));
        Ok(())
    }
}

/// Reads elements, and keeps the notes on them.
struct Reader<'a> {
    folder: PathBuf,
    notes: Vec<String>,
    /// Things of a kind that are left out, counted.
    ignored: BTreeMap<String, usize>,
    unused_limits: bool,
    mimics: Vec<Mimic<'a>>,
    hulls: Hulls,
}

impl<'a> Reader<'a> {
    fn ignore(&mut self, what: &str) {
        *self.ignored.entry(what.to_owned()).or_default() += 1;
    }

    /// The links from the first one on, each behind its parent.
    fn tree(
        &mut self,
        robot: &Element<'a>,
        options: &Options,
    ) -> Result<Vec<Link<'a>>, SceneError> {
        for element in robot.children() {
            match element.tag() {
                "link" | "joint" | "material" => {}
                other => self.ignore(&format!("<{other}>: not read")),
            }
        }
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
        let hangs_on_world = |joint: Element<'_>| {
            joint.child("parent").is_some_and(|p| p.get("link") == Some(WORLD))
        };
        let mut count = elements.len();
        if !number.contains_key(WORLD) && robot.all("joint").any(hangs_on_world) {
            number.insert(WORLD, count);
            count += 1;
        }
        let name = |i: usize| {
            elements.get(i).map_or(WORLD, |link: &Element<'a>| link.get("name").unwrap_or_default())
        };
        let mut above: Vec<Option<Joint<'_>>> = (0..count).map(|_| None).collect();
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); count];
        let mut names: BTreeMap<&str, ()> = BTreeMap::new();
        for element in robot.all("joint") {
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
        links[0].hold = self.base(&links, options.base);
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
            Some(inertial) => Weight::Given(element::inertial(&inertial)?),
            None => Weight::Unsaid,
        };
        let material = element::material(element)?;
        let mut shapes = Vec::new();
        let mut left_out = None;
        for collision in element.all("collision") {
            let found = element::collision(&collision, &self.folder, &mut self.hulls)?;
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
        for child in element.children() {
            if !["inertial", "visual", "collision", "contact"].contains(&child.tag()) {
                self.ignore(&format!("<{}> of links: not read", child.tag()));
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
        self.unused_limits |= read.has_motor_limits;
        for child in element.children() {
            let known = ["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"];
            if !known.contains(&child.tag()) {
                self.ignore(&format!("<{}> of joints: not read", child.tag()));
            }
        }
        if let Some((of, ratio, offset)) = read.mimic
            && read.kind != JointType::Fixed
        {
            self.mimics.push(Mimic { element: *element, name: read.name, of, ratio, offset });
        }
        Ok(read)
    }
}
