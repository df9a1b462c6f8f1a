//! A file being read: the names that are known so far, and the values that all its parts have.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use drystone::{DefError, Filter, Material, Pose, Quat, Shape, Vec3};

use super::loading::Loading;
use super::surface;
use crate::error::SceneError;
use crate::own::document::{self, Layer};
use crate::own::place::Place;
use crate::own::value::{Or, Ref, Triple, Turn};
use crate::scene::Scene;

/// A file being read.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    pub(super) folder: &'a Path,
    pub(super) loading: &'a mut Loading,
    pub(super) layers: Vec<String>,
    pub(super) materials: BTreeMap<String, Material>,
    /// One each, but several where a mesh is taken apart.
    pub(super) shapes: BTreeMap<String, Vec<Shape>>,
    /// Numbers of bodies.
    pub(super) names: BTreeMap<String, usize>,
    /// Numbers of joints.
    pub(super) joints: BTreeMap<String, usize>,
    /// Where bodies are at the start, by their numbers.
    pub(super) seats: Vec<Pose>,
    pub(super) scene: Scene,
}

impl Reader<'_> {
    /// An error at a place.
    pub(super) fn fail(
        &self,
        place: &Place,
        problem: impl core::fmt::Display,
        allowed: &str,
    ) -> SceneError {
        let (line, column) = place.find(self.text);
        let shown = place.to_string();
        let colon = if shown.is_empty() { "" } else { ": " };
        let place = format!("line {line} column {column}{colon}{shown}");
        SceneError::new(Path::new(""), &place, problem, allowed)
    }

    /// The engine's error about a definition at a place.
    pub(super) fn refused(&self, place: &Place, e: &DefError) -> SceneError {
        self.fail(&place.field(e.field()), format!("is {}", e.value()), e.allowed())
    }

    /// Takes in a body with its name and place.
    pub(super) fn learn(
        &mut self,
        place: &Place,
        name: &str,
        seat: Pose,
    ) -> Result<(), SceneError> {
        if self.names.insert(name.to_owned(), self.seats.len()).is_some() {
            let problem = format!("another body is called \"{name}\" too");
            return Err(self.fail(&place.key("name"), problem, "a name of its own"));
        }
        self.seats.push(seat);
        Ok(())
    }

    pub(super) fn learn_joint(
        &mut self,
        place: &Place,
        name: &str,
        number: usize,
    ) -> Result<(), SceneError> {
        if !name.is_empty() && self.joints.insert(name.to_owned(), number).is_some() {
            let problem = format!("another joint is called \"{name}\" too");
            return Err(self.fail(&place.key("name"), problem, "a name of its own"));
        }
        Ok(())
    }

    /// The number of a body.
    pub(super) fn body_number(&self, place: &Place, body: &Ref) -> Result<usize, SceneError> {
        self.number(place, body, &self.names, (self.seats.len(), "bodies"))
    }

    pub(super) fn joint_number(&self, place: &Place, joint: &Ref) -> Result<usize, SceneError> {
        self.number(place, joint, &self.joints, (self.scene.joints.len(), "joints"))
    }

    pub(super) fn number(
        &self,
        place: &Place,
        which: &Ref,
        names: &BTreeMap<String, usize>,
        (count, what): (usize, &str),
    ) -> Result<usize, SceneError> {
        match which {
            Ref::Name(name) => names.get(name).copied().ok_or_else(|| {
                let all = known(names.keys());
                self.fail(place, format!("is \"{name}\", which none of the {what} is"), &all)
            }),
            Ref::Number(n) if *n < count => Ok(*n),
            Ref::Number(n) => {
                let allowed = match count {
                    0 => format!("none: there are no {what}"),
                    _ => format!("0 to {} ({what})", count - 1),
                };
                Err(self.fail(place, format!("is {n}"), &allowed))
            }
        }
    }

    pub(super) fn layers(&self, place: &Place, layers: &[Layer]) -> Result<u64, SceneError> {
        let mut bits = 0;
        for (i, layer) in layers.iter().enumerate() {
            let number = match layer {
                Layer::Number(n) => usize::from(*n),
                Layer::Name(name) => {
                    self.layers.iter().position(|known| known == name).ok_or_else(|| {
                        let problem = format!("is \"{name}\", which no layer is called");
                        self.fail(&place.item(i), problem, &known(self.layers.iter()))
                    })?
                }
            };
            bits |= 1 << number;
        }
        Ok(bits)
    }

    pub(super) fn filter(
        &self,
        place: &Place,
        filter: &document::Filter,
    ) -> Result<Filter, SceneError> {
        let mut made = Filter::default();
        if let Some(layers) = &filter.layers {
            made.layers = self.layers(&place.key("layers"), layers)?;
        }
        if let Some(mask) = &filter.mask {
            made.mask = self.layers(&place.key("mask"), mask)?;
        }
        if let Some(exclude) = &filter.exclude {
            made.exclude = self.layers(&place.key("exclude"), exclude)?;
        }
        Ok(made)
    }

    /// A rotation; one by four numbers is taken as it is, and checked with the thing that has it.
    pub(super) fn turn(&self, place: &Place, turn: Turn) -> Result<Quat, SceneError> {
        match turn {
            Turn::Quaternion(q) => {
                let quat = Quat::from(q);
                let square: f32 = q.iter().map(|v| v * v).sum();
                if (0.9..1.1).contains(&square) {
                    return Ok(quat);
                }
                let value = format!("is [{}, {}, {}, {}]", q[0], q[1], q[2], q[3]);
                Err(self.fail(place, value, "a unit quaternion [x, y, z, w]"))
            }
            Turn::About(about) => {
                let axis = self.direction(&place.key("axis"), about.axis)?;
                let angle = about.degrees * (core::f32::consts::PI / 180.0);
                Ok(Quat::from_axis_angle(axis, angle))
            }
        }
    }

    /// A direction of any length but none.
    pub(super) fn direction(&self, place: &Place, v: Triple) -> Result<Vec3, SceneError> {
        Vec3::from(v).try_normalize().ok_or_else(|| {
            let value = format!("is [{}, {}, {}]", v[0], v[1], v[2]);
            self.fail(place, value, "a direction of some length")
        })
    }

    /// A pose from its two parts, each of which may be left out.
    pub(super) fn pose(
        &self,
        place: &Place,
        position: Option<Triple>,
        rotation: Option<Turn>,
    ) -> Result<Pose, SceneError> {
        let rotation = match rotation {
            Some(turn) => self.turn(&place.key("rotation"), turn)?,
            None => Quat::IDENTITY,
        };
        Ok(Pose::new(position.map_or(Vec3::ZERO, Vec3::from), rotation))
    }

    pub(super) fn material(
        &self,
        place: &Place,
        material: &document::Material,
    ) -> Result<Material, SceneError> {
        let made = surface::material(material);
        made.validate().map_err(|e| self.refused(place, &e))?;
        Ok(made)
    }

    pub(super) fn material_of(
        &self,
        place: &Place,
        material: &Or<document::Material>,
    ) -> Result<Material, SceneError> {
        match material {
            Or::Here(material) => self.material(place, material),
            Or::Name(name) => self.materials.get(name).copied().ok_or_else(|| {
                let problem = format!("is \"{name}\", which no material is called");
                self.fail(place, problem, &known(self.materials.keys()))
            }),
        }
    }

    /// A file that this one names, whose path is relative to it.
    pub(super) fn path(&self, place: &Place, file: &str) -> Result<PathBuf, SceneError> {
        let relative = Path::new(file);
        let is_up = |c: &Component<'_>| matches!(c, Component::ParentDir);
        let is_near = relative.components().filter(is_up).count() <= 8;
        if file.is_empty() || file.contains('\0') || file.contains("://") || !relative.is_relative()
        {
            return Err(self.fail(place, format!("is \"{file}\""), "a path relative to this file"));
        }
        if !is_near {
            let allowed = "a path of a file near this one";
            return Err(self.fail(place, format!("is \"{file}\""), allowed));
        }
        Ok(self.folder.join(relative))
    }
}

/// The names that are known, for errors.
pub(super) fn known<'a>(names: impl ExactSizeIterator<Item = &'a String>) -> String {
    let count = names.len();
    if count == 0 {
        return "none: none is named".to_owned();
    }
    let shown: Vec<String> = names.take(12).map(|name| format!("\"{name}\"")).collect();
    let more = if count > 12 { format!(" and {} more", count - 12) } else { String::new() };
    format!("{}{more}", shown.join(", "))
}
