//! The settings of `<option>`.

use drystone::{Vec3, vec3};

use super::model::Model;
use crate::error::SceneError;
use crate::read::xml::Element;

/// The settings of `<option>` that are read.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "the flags of the format")]
pub(super) struct Options {
    pub(super) gravity: Vec3,
    pub(super) timestep: Option<f32>,
    pub(super) contacts: bool,
    pub(super) limits: bool,
    pub(super) friction: bool,
    pub(super) springs: bool,
    pub(super) equalities: bool,
}

impl Options {
    pub(super) fn read(model: &Model<'_>) -> Result<Self, SceneError> {
        let mut out = Self {
            gravity: vec3(0.0, 0.0, -9.81),
            timestep: None,
            contacts: true,
            limits: true,
            friction: true,
            springs: true,
            equalities: true,
        };
        for option in model.sections("option") {
            out.gravity = option.vec3("gravity")?.unwrap_or(out.gravity);
            if option.get("timestep").is_some() {
                out.timestep = Some(option.above_zero("timestep")?);
            }
            for flags in option.all("flag") {
                out.flags(&flags)?;
            }
        }
        Ok(out)
    }

    fn flags(&mut self, flags: &Element<'_>) -> Result<(), SceneError> {
        for (name, value) in flags.attributes() {
            let on = match value {
                "enable" => true,
                "disable" => false,
                _ => return Err(flags.wrong(name, "enable or disable")),
            };
            match name {
                "constraint" if !on => {
                    self.contacts = false;
                    self.limits = false;
                    self.friction = false;
                    self.equalities = false;
                }
                "contact" => self.contacts = on,
                "limit" => self.limits = on,
                "frictionloss" => self.friction = on,
                "equality" => self.equalities = on,
                "passive" | "spring" => self.springs = on,
                "gravity" if !on => self.gravity = Vec3::ZERO,
                _ => {}
            }
        }
        Ok(())
    }
}
