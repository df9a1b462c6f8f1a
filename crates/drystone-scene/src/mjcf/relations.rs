//! Relations of two bodies that have sections of their own: excludes, equalities, tendons.

use std::collections::BTreeMap;

use drystone::joint::SixDof;
use drystone::{BodyKind, JointKind, Pose, Vec3};

use super::defaults::View;
use super::walk::{Instance, Named, Walk};
use crate::error::SceneError;
use crate::links::Assembled;
use crate::read::xml::Element;
use crate::scene::{Scene, SceneJoint};

/// Adds them all to the scene.
pub(super) fn add(
    walk: &mut Walk<'_>,
    assembled: &mut Assembled,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let mut instances = core::mem::take(&mut walk.instances);
    for instance in &mut instances {
        // The world is a body by this name in every model, without an element of its own.
        instance.bodies.entry("world".to_owned()).or_insert_with(|| vec![(String::new(), 0)]);
    }
    for (number, instance) in instances.iter().enumerate() {
        let relations = Relations { walk, instance, assembled, is_main: number == 0 };
        relations.add(scene)?;
    }
    Ok(())
}

struct Relations<'r, 'a> {
    walk: &'r mut Walk<'a>,
    instance: &'r Instance,
    assembled: &'r mut Assembled,
    is_main: bool,
}

/// A point of a link.
type Point = (usize, Vec3);

impl<'a> Relations<'_, 'a> {
    fn add(mut self, scene: &mut Scene) -> Result<(), SceneError> {
        let model = &self.walk.models[self.instance.model];
        for section in model.sections("contact").collect::<Vec<_>>() {
            for element in model.children(&section)? {
                match element.tag() {
                    "exclude" => self.exclude(&element, scene)?,
                    other => self.ignore(&format!("<{other}> of contacts: not read")),
                }
            }
        }
        for section in model.sections("equality").collect::<Vec<_>>() {
            for element in model.children(&section)? {
                let view = model.defaults.view(element, None)?;
                let is_off = view.get("active") == Some("false") || !self.walk.option.equalities;
                match element.tag() {
                    _ if is_off => {}
                    "connect" | "weld" => self.equality(&view, scene)?,
                    "joint" if element.get("joint2").is_some() => self.couple(&view, scene)?,
                    other => self.ignore(&format!("<{other}> of equalities: not read")),
                }
            }
        }
        for section in model.sections("tendon").collect::<Vec<_>>() {
            for element in model.children(&section)? {
                self.tendon(&model.defaults.view(element, None)?, scene)?;
            }
        }
        Ok(())
    }

    /// Counted once, not for each time a model is attached.
    fn ignore(&mut self, what: &str) {
        if self.is_main || !self.walk.ignored.contains_key(what) {
            self.walk.ignore(what);
        }
    }

    /// Things with these names: one set, or one for each copy.
    fn sets<T: Copy>(
        &self,
        element: &Element<'a>,
        names: &[&'a str],
        known: &Named<T>,
        what: &str,
    ) -> Result<Vec<Vec<T>>, SceneError> {
        let mut lists = Vec::new();
        for name in names {
            match known.get(*name) {
                Some(list) => lists.push(list),
                // Only a part of an attached model may be there.
                None if !self.is_main => return Ok(Vec::new()),
                None => {
                    let problem = format!("there is no {what} '{name}'");
                    return Err(element.error(problem, "one of the file"));
                }
            }
        }
        let Some(longest) = lists.iter().max_by_key(|l| l.len()) else { return Ok(Vec::new()) };
        // If things have the same name, the first counts.
        let by_suffix: Vec<BTreeMap<&str, T>> = lists
            .iter()
            .map(|list| {
                list.iter().rev().map(|(suffix, thing)| (suffix.as_str(), *thing)).collect()
            })
            .collect();
        let of_copy = |suffix: &str| -> Option<Vec<T>> {
            let one = |(list, by): (&&Vec<(String, T)>, &BTreeMap<&str, T>)| match list.as_slice() {
                [(_, only)] => Some(*only),
                _ => by.get(suffix).copied(),
            };
            lists.iter().zip(&by_suffix).map(one).collect()
        };
        Ok(longest.iter().filter_map(|(suffix, _)| of_copy(suffix)).collect())
    }

    fn exclude(&mut self, element: &Element<'a>, scene: &mut Scene) -> Result<(), SceneError> {
        let names = [element.need("body1")?, element.need("body2")?];
        for pair in self.sets(element, &names, &self.instance.bodies, "body")? {
            self.assembled.exclude(scene, pair[0], pair[1]);
        }
        Ok(())
    }

    /// Where a link is at rest.
    fn pose(&self, link: usize, scene: &Scene) -> Pose {
        let (body, on) = self.assembled.place[link];
        let def = &scene.bodies[body].def;
        Pose::new(def.position, def.rotation).compose(&on)
    }

    fn equality(&mut self, view: &View<'a>, scene: &mut Scene) -> Result<(), SceneError> {
        let element = *view.element();
        let is_weld = element.tag() == "weld";
        let mut pairs: Vec<[Point; 2]> = Vec::new();
        if element.get("site1").is_some() || element.get("site2").is_some() {
            let names = [element.need("site1")?, element.need("site2")?];
            let sets = self.sets(&element, &names, &self.instance.sites, "site")?;
            pairs.extend(sets.into_iter().map(|s| [s[0], s[1]]));
        } else {
            let anchor = view.vec3("anchor")?.unwrap_or(Vec3::ZERO);
            let mut names = vec![element.need("body1")?];
            names.extend(element.get("body2"));
            for set in self.sets(&element, &names, &self.instance.bodies, "body")? {
                let (a, b) = (set[0], set.get(1).copied().unwrap_or(0));
                // The anchor of a weld is on the second body, that of a connection on the first.
                let (first, second) = (self.pose(a, scene), self.pose(b, scene));
                let at = if is_weld { second.point(anchor) } else { first.point(anchor) };
                pairs.push([(a, first.local_point(at)), (b, second.local_point(at))]);
            }
        }
        for [a, b] in pairs {
            let (first, second) = (self.pose(a.0, scene), self.pose(b.0, scene));
            let kind = if is_weld {
                let turn = (first.rotation.conjugate() * second.rotation).normalized();
                JointKind::SixDof(SixDof { frame_a: turn, ..SixDof::FIXED })
            } else {
                JointKind::Ball
            };
            if is_weld && view.get("relpose").is_some() {
                self.ignore("relpose of welds: the pose of the file is held");
            }
            self.hold(a, b, kind, scene);
        }
        Ok(())
    }

    /// One joint follows another: of its polynomial the straight part.
    fn couple(&mut self, view: &View<'a>, scene: &mut Scene) -> Result<(), SceneError> {
        let element = *view.element();
        let names = [element.need("joint1")?, element.need("joint2")?];
        let terms = view.list("polycoef", 5)?;
        let at = |i: usize| terms.get(i).copied();
        let (offset, ratio) = (at(0).unwrap_or(0.0), at(1).unwrap_or(1.0));
        if (2..5).any(|i| at(i).is_some_and(|t| t.abs() > 0.0)) {
            self.ignore("<joint> of equalities: of the polynomial the straight part is read");
        }
        for set in self.sets(&element, &names, &self.instance.joints, "joint")? {
            let [own, other] = [set[0], set[1]]
                .map(|n| self.assembled.coordinates.get(&self.walk.joint_names[n]).copied());
            match (own, other) {
                (Some(_), Some(_)) if (1.0e-6..=1.0e6).contains(&ratio.abs()) => {
                    let names = [set[0], set[1]].map(|n| self.walk.joint_names[n].as_str());
                    self.assembled.couple(names, [ratio, offset], scene);
                }
                _ => self.ignore("<joint> of equalities: only hinges and slides follow each other"),
            }
        }
        Ok(())
    }

    /// Adds a joint between points of two links, which go on to collide.
    fn hold(&self, a: Point, b: Point, kind: JointKind, scene: &mut Scene) {
        let ends = [a, b].map(|(link, at)| {
            let (body, on) = self.assembled.place[link];
            (body, on.point(at), on.rotation)
        });
        let moves = |i: usize| scene.bodies[i].def.kind == BodyKind::Dynamic;
        let [(body_a, anchor_a, turn_a), (body_b, anchor_b, turn_b)] = ends;
        if body_a == body_b || !(moves(body_a) || moves(body_b)) {
            scene
                .notes
                .push("a constraint within one body, or of bodies at rest: left out".to_owned());
            return;
        }
        let kind = match kind {
            JointKind::SixDof(six) => JointKind::SixDof(SixDof {
                frame_a: (turn_a * six.frame_a).normalized(),
                frame_b: (turn_b * six.frame_b).normalized(),
                ..six
            }),
            other => other,
        };
        scene.joints.push(SceneJoint {
            collide_connected: true,
            ..SceneJoint::new((body_a, anchor_a), (body_b, anchor_b), kind)
        });
    }

    /// A tendon between two sites with a greatest length is a string, or a rod.
    fn tendon(&mut self, view: &View<'a>, scene: &mut Scene) -> Result<(), SceneError> {
        let element = *view.element();
        let model = &self.walk.models[self.instance.model];
        let path = model.children(&element)?;
        let is_straight =
            element.tag() == "spatial" && path.len() == 2 && path.iter().all(|e| e.tag() == "site");
        if !is_straight || !view.is_limited(model.settings.autolimits)? {
            self.ignore("tendons that are no string between two sites: not read");
            return Ok(());
        }
        let Some([min, max]) = view.numbers::<2>("range")?.filter(|[a, b]| *a >= 0.0 && a <= b)
        else {
            return Err(view.wrong("range", "two lengths, the first no more than the second"));
        };
        if !self.walk.option.limits {
            return Ok(());
        }
        let names = [path[0].need("site")?, path[1].need("site")?];
        for set in self.sets(&path[0], &names, &self.instance.sites, "site")? {
            self.hold(set[0], set[1], JointKind::Distance { min, max, spring: None }, scene);
        }
        Ok(())
    }
}
