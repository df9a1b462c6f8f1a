//! The description of a robot: joints and sites as the walk finds them, then tendons, actuators,
//! sensors and keyframes of all models.

mod actuator;
mod keyframe;
mod laws;
mod sensor;
mod tendon;

use core::cell::RefCell;
use std::collections::BTreeMap;

use drystone::{Pose, Vec3};

use super::defaults::View;
use super::model::Model;
use super::walk::{Instance, Named, Walk};
use crate::error::SceneError;
use crate::read::xml::Element;
use crate::robot::{Joint, JointType, Robot};

/// Most numbers of a list such as `damping` or `gear`.
const MOST: usize = 16;

/// A joint, `pose` being that of the frame around it on the link; its link and its coordinates are
/// set by [`place`].
pub(super) fn joint<'a>(
    view: &View<'a>,
    model: &Model<'a>,
    pose: &Pose,
    name: &str,
) -> Result<Joint, SceneError> {
    let is_free = view.element().tag() == "freejoint";
    let kind = match view.get("type") {
        _ if is_free => JointType::Free,
        Some("free") => JointType::Free,
        Some("ball") => JointType::Ball,
        Some("slide") => JointType::Slide,
        _ => JointType::Hinge,
    };
    // The classes of a free joint say nothing of it.
    let own = if is_free { &View::bare(*view.element()) } else { view };
    let turns = |x: f32| if kind == JointType::Slide { x } else { model.radians(x) };
    let has_coordinate = matches!(kind, JointType::Slide | JointType::Hinge);
    let angle = |name: &'static str| {
        let x = if has_coordinate { own.number(name)? } else { None };
        Ok::<f32, SceneError>(turns(x.unwrap_or(0.0)))
    };
    let axis = own.vec3("axis")?.unwrap_or(Vec3::Z).try_normalize().unwrap_or(Vec3::Z);
    let is_limited = kind != JointType::Free && own.is_limited(model.settings.autolimits)?;
    let range = if is_limited { own.numbers::<2>("range")? } else { None };
    let spring_damper = own.numbers::<2>("springdamper")?.filter(|s| s.iter().all(|x| *x > 0.0));
    Ok(Joint {
        name: name.to_owned(),
        link: String::new(),
        kind,
        axis: if has_coordinate { pose.direction(axis) } else { Vec3::Z },
        anchor: match kind {
            JointType::Free => Vec3::ZERO,
            _ => pose.point(own.vec3("pos")?.unwrap_or(Vec3::ZERO)),
        },
        q: 0,
        v: 0,
        reference: angle("ref")?,
        range: range.map(|r| r.map(turns)),
        margin: own.number("margin")?.unwrap_or(0.0),
        stiffness: powers(own, "stiffness")?,
        spring_reference: angle("springref")?,
        damping: powers(own, "damping")?,
        spring_damper,
        armature: own.number("armature")?.unwrap_or(0.0),
        friction: own.number("frictionloss")?.unwrap_or(0.0),
        force_range: bounds(own, model, "actuatorfrclimited", "actuatorfrcrange")?,
        gravity_by_actuators: own.get("actuatorgravcomp") == Some("true"),
    })
}

/// A factor, and those of the next two powers.
fn powers(view: &View<'_>, name: &str) -> Result<[f32; 3], SceneError> {
    let mut out = [0.0; 3];
    out.iter_mut().zip(view.list(name, MOST)?).for_each(|(to, x)| *to = x);
    Ok(out)
}

/// A range that holds if an attribute says so, or if it is there.
fn bounds(
    view: &View<'_>,
    model: &Model<'_>,
    limited: &str,
    range: &str,
) -> Result<Option<[f32; 2]>, SceneError> {
    let numbers = view.numbers::<2>(range)?;
    let holds = match view.get(limited) {
        None | Some("auto") => model.settings.autolimits,
        Some("true") => true,
        Some("false") => false,
        Some(_) => return Err(view.wrong(limited, "true, false or auto")),
    };
    Ok(numbers.filter(|_| holds))
}

/// Gives the joints from number `first` on their link, whose pose is `at`, and their coordinates.
pub(super) fn place(robot: &mut Robot, first: usize, link: &str, at: &Pose) {
    let (mut q, mut v) = match first.checked_sub(1).and_then(|i| robot.joints.get(i)) {
        Some(last) => (last.q + last.kind.positions(), last.v + last.kind.velocities()),
        None => (0, 0),
    };
    for joint in robot.joints.iter_mut().skip(first) {
        link.clone_into(&mut joint.link);
        (joint.q, joint.v) = (q, v);
        q += joint.kind.positions();
        v += joint.kind.velocities();
        match joint.kind {
            JointType::Free => {
                robot.start.extend(at.position.to_array());
                let r = at.rotation;
                robot.start.extend([r.w, r.x, r.y, r.z]);
            }
            JointType::Ball => robot.start.extend([1.0, 0.0, 0.0, 0.0]),
            JointType::Slide | JointType::Hinge => robot.start.push(joint.reference),
        }
    }
}

/// The description of what a walk found.
pub(super) fn robot(mut walk: Walk<'_>) -> Result<Robot, SceneError> {
    let robot = core::mem::take(&mut walk.robot);
    let mut instances = core::mem::take(&mut walk.instances);
    for instance in &mut instances {
        instance.bodies.entry("world".to_owned()).or_insert_with(|| vec![(String::new(), 0)]);
    }
    let mut out =
        Describe { walk: &walk, robot, copy_of_tendons: Vec::new(), copy_of_actuators: Vec::new() };
    // A sensor may be of any actuator, and an actuator of any tendon.
    let all = || instances.iter().enumerate().map(|(i, instance)| (i == 0, instance));
    let mut found: Vec<Own> = instances.iter().map(|_| Own::default()).collect();
    for ((is_main, instance), own) in all().zip(&mut found) {
        out.tendons(instance, is_main, own)?;
    }
    for ((is_main, instance), own) in all().zip(&mut found) {
        out.actuators(instance, is_main, own)?;
    }
    for ((is_main, instance), own) in all().zip(&found) {
        out.sensors(instance, is_main, own)?;
    }
    for (is_main, instance) in all() {
        out.keyframes(instance, is_main)?;
    }
    Ok(out.robot)
}

/// Tendons and actuators of an instance by their names, as numbers in the description.
#[derive(Default)]
struct Own {
    tendons: Named<usize>,
    actuators: Named<usize>,
}

/// A thing in the making: the copy that it is in, its name, and what stands behind that.
struct Made<'a, T> {
    copy: usize,
    raw: &'a str,
    suffix: String,
    thing: T,
}

/// More tendons, actuators or sensors than this, with those of copies, are refused.
const MAX_MADE: usize = 200_000;

/// Refuses what is too much, before it is made.
fn limit(count: usize, element: &Element<'_>) -> Result<(), SceneError> {
    if count < MAX_MADE {
        return Ok(());
    }
    let problem = format!("the model has more than {MAX_MADE} tendons, actuators or sensors here");
    Err(element.error(problem, "fewer"))
}

/// In the order of MuJoCo's compiler: what is in no copy, then copy by copy.
fn in_order<T>(mut made: Vec<Made<'_, T>>) -> Vec<Made<'_, T>> {
    made.sort_by_key(|m| m.copy);
    made
}

/// A description in the making.
struct Describe<'w, 'a> {
    walk: &'w Walk<'a>,
    robot: Robot,
    /// Numbers of the copies that tendons and actuators are in.
    copy_of_tendons: Vec<usize>,
    copy_of_actuators: Vec<usize>,
}

impl<'a> Describe<'_, 'a> {
    fn model(&self, instance: &Instance) -> &'a Model<'a> {
        &self.walk.models[instance.model]
    }

    /// The copies of an element, by what stands behind their names, with their numbers: one, unless
    /// it names what there are several of.
    fn copies<'n>(
        &self,
        named: impl IntoIterator<Item = Option<(Kind, &'n Vec<(String, usize)>)>>,
    ) -> Vec<(String, usize)> {
        let longest = named.into_iter().flatten().max_by_key(|(_, list)| list.len());
        let Some((kind, list)) = longest else { return vec![(String::new(), 0)] };
        let numbers = match kind {
            Kind::Joint => &self.walk.copy_of.joints,
            Kind::Site => &self.walk.copy_of.sites,
            Kind::Body => &self.walk.copy_of.links,
            Kind::Tendon => &self.copy_of_tendons,
            Kind::Actuator => &self.copy_of_actuators,
        };
        let copy = |number: usize| numbers.get(number).copied().unwrap_or(0);
        match list.as_slice() {
            // It is one of a copy, called by its whole name.
            [_] => vec![(String::new(), 0)],
            list => list.iter().map(|(suffix, n)| (suffix.clone(), copy(*n))).collect(),
        }
    }

    fn leave_out(&mut self, element: &Element<'a>, why: &str) {
        self.robot.left_out.push(format!("{}: {why}: left out", element.place()));
    }
}

/// Finds what an element names among the things of an instance.
struct Finder<'f> {
    instance: &'f Instance,
    own: &'f Own,
    is_main: bool,
    /// Numbers by what stands behind a name, for names of several things.
    copies: RefCell<BTreeMap<(Kind, String), BTreeMap<String, usize>>>,
}

/// Kinds of things with names.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Joint,
    Tendon,
    Actuator,
    Site,
    Body,
}

impl<'f> Finder<'f> {
    fn new(instance: &'f Instance, own: &'f Own, is_main: bool) -> Self {
        Self { instance, own, is_main, copies: RefCell::default() }
    }

    /// The thing of a list for a copy: its own, else the first.
    fn of_copy(
        &self,
        kind: Kind,
        name: &str,
        list: &[(String, usize)],
        suffix: &str,
    ) -> Option<usize> {
        let first = list.first().map(|(_, number)| *number);
        if list.len() < 2 {
            return first;
        }
        let mut copies = self.copies.borrow_mut();
        let map = copies.entry((kind, name.to_owned())).or_insert_with(|| {
            // If things have the same name, the first counts.
            list.iter().rev().map(|(behind, number)| (behind.clone(), *number)).collect()
        });
        map.get(suffix).copied().or(first)
    }

    /// All things of a name, with their kind.
    fn all(&self, kind: Kind, name: &str) -> Option<(Kind, &Vec<(String, usize)>)> {
        Some((kind, self.list(kind, name)?))
    }

    fn list(&self, kind: Kind, name: &str) -> Option<&Vec<(String, usize)>> {
        match kind {
            Kind::Joint => self.instance.joints.get(name),
            Kind::Tendon => self.own.tendons.get(name),
            Kind::Actuator => self.own.actuators.get(name),
            Kind::Site => self.instance.site_numbers.get(name),
            Kind::Body => self.instance.bodies.get(name),
        }
    }

    /// The number of a thing for a copy; `None`: its part of an attached model is not there.
    fn find(
        &self,
        element: &Element<'_>,
        kind: Kind,
        name: &str,
        suffix: &str,
    ) -> Result<Option<usize>, SceneError> {
        match self.list(kind, name) {
            Some(list) => Ok(self.of_copy(kind, name, list, suffix)),
            None if !self.is_main => Ok(None),
            None => {
                let what = match kind {
                    Kind::Joint => "joint",
                    Kind::Tendon => "tendon",
                    Kind::Actuator => "actuator",
                    Kind::Site => "site",
                    Kind::Body => "body",
                };
                Err(element.error(format!("there is no {what} '{name}'"), "one of the file"))
            }
        }
    }
}
