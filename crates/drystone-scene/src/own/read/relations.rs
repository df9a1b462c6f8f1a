//! Relations of bodies: couplings, frames, pairs that never collide, rules of surfaces.

use drystone::Vec3;
use drystone::contact::{ContactSoftness, SurfaceRule};

use super::joint;
use super::reader::Reader;
use crate::error::SceneError;
use crate::own::document::{Document, Softness};
use crate::own::place::Place;
use crate::scene::{SceneCoupling, SceneFrame};

impl Reader<'_> {
    pub(super) fn couplings(&mut self, document: &Document) -> Result<(), SceneError> {
        let mut made = Vec::with_capacity(document.couplings.len());
        for (i, coupling) in document.couplings.iter().enumerate() {
            let place = Place::default().nth("couplings", i);
            made.push(SceneCoupling {
                joint_a: self.joint_number(&place.key("joint_a"), &coupling.joint_a)?,
                axis_a: joint::axis_of(coupling.axis_a),
                joint_b: self.joint_number(&place.key("joint_b"), &coupling.joint_b)?,
                axis_b: joint::axis_of(coupling.axis_b),
                ratio: coupling.ratio,
                offset: coupling.offset.unwrap_or(0.0),
            });
        }
        // The couplings of parts are there already.
        made.append(&mut self.scene.couplings);
        self.scene.couplings = made;
        Ok(())
    }

    pub(super) fn frames(&mut self, document: &Document) -> Result<(), SceneError> {
        let mut made = Vec::with_capacity(document.frames.len());
        let mut taken: Vec<&str> = self.scene.frames.iter().map(|f| f.name.as_str()).collect();
        for (i, frame) in document.frames.iter().enumerate() {
            let place = Place::default().nth("frames", i);
            if self.names.contains_key(&frame.name) || taken.contains(&frame.name.as_str()) {
                let problem = format!("another body or frame is called \"{}\" too", frame.name);
                return Err(self.fail(&place.key("name"), problem, "a name of its own"));
            }
            taken.push(&frame.name);
            let pose = self.pose(&place, frame.position, frame.rotation)?;
            made.push(SceneFrame {
                name: frame.name.clone(),
                body: self.body_number(&place.key("body"), &frame.body)?,
                pose,
                center: frame.center.map_or(pose.position, Vec3::from),
            });
        }
        made.append(&mut self.scene.frames);
        self.scene.frames = made;
        Ok(())
    }

    pub(super) fn rules(&mut self, document: &Document) -> Result<(), SceneError> {
        for (i, pair) in document.never_collide.iter().enumerate() {
            let place = Place::default().nth("never_collide", i);
            let a = self.body_number(&place.item(0), &pair[0])?;
            let b = self.body_number(&place.item(1), &pair[1])?;
            self.scene.never_collide.push([a, b]);
        }
        for (i, rule) in document.surfaces_between.iter().enumerate() {
            let place = Place::default().nth("surfaces_between", i);
            let bodies = place.key("bodies");
            let a = self.body_number(&bodies.item(0), &rule.bodies[0])?;
            let b = self.body_number(&bodies.item(1), &rule.bodies[1])?;
            if a == b {
                let problem = "both are the same body".to_owned();
                return Err(self.fail(&bodies, problem, "two bodies"));
            }
            let made = SurfaceRule {
                friction: rule.friction,
                kinetic_friction: rule.kinetic_friction,
                restitution: rule.restitution,
                softness: rule.softness.map(softness_of),
                ..SurfaceRule::ANY
            };
            made.validate().map_err(|e| self.refused(&place, &e))?;
            self.scene.surfaces_between.push(([a, b], made));
        }
        let mut rules = Vec::with_capacity(document.surface_rules.len());
        for (i, rule) in document.surface_rules.iter().enumerate() {
            let place = Place::default().nth("surface_rules", i);
            let made = SurfaceRule {
                first: self.layers(&place.key("first"), &rule.first)?,
                second: self.layers(&place.key("second"), &rule.second)?,
                friction: rule.friction,
                kinetic_friction: rule.kinetic_friction,
                restitution: rule.restitution,
                softness: rule.softness.map(softness_of),
            };
            made.validate().map_err(|e| self.refused(&place, &e))?;
            rules.push(made);
        }
        rules.append(&mut self.scene.surface_rules);
        if rules.len() > 256 {
            let problem = format!("there are {}", rules.len());
            return Err(self.fail(&Place::default().key("surface_rules"), problem, "at most 256"));
        }
        self.scene.surface_rules = rules;
        Ok(())
    }
}

const fn softness_of(softness: Softness) -> ContactSoftness {
    ContactSoftness { hertz: softness.hertz, damping_ratio: softness.damping_ratio }
}
