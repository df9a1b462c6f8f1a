//! Bodies.

use drystone::breakage::{Bond, BondStrength, Fracture, Glue};
use drystone::math::Sym3;
use drystone::{AxisLocks, BodyDef, BodyKind, MassDef, ShapeDef, Vec3};

use super::reader::Reader;
use crate::error::SceneError;
use crate::own::document::{self, AxisName, Kind};
use crate::own::place::Place;
use crate::own::value::Mass;
use crate::scene::SceneBody;

impl Reader<'_> {
    pub(super) fn body(
        &mut self,
        place: &Place,
        body: &document::Body,
    ) -> Result<SceneBody, SceneError> {
        let mut def = BodyDef {
            kind: match body.kind {
                Some(Kind::Static) => BodyKind::Static,
                Some(Kind::Kinematic) => BodyKind::Kinematic,
                Some(Kind::Dynamic) | None => BodyKind::Dynamic,
            },
            locks: locks(&body.locks),
            sleep_speed: body.sleep_speed,
            ..BodyDef::default()
        };
        let pose = self.pose(place, body.position, body.rotation)?;
        (def.position, def.rotation) = (pose.position, pose.rotation);
        let vector = |v: Option<[f32; 3]>| v.map_or(Vec3::ZERO, Vec3::from);
        def.linear_velocity = vector(body.linear_velocity);
        def.angular_velocity = vector(body.angular_velocity);
        def.gravity_scale = body.gravity_scale.unwrap_or(def.gravity_scale);
        def.linear_damping = body.linear_damping.unwrap_or(def.linear_damping);
        def.angular_damping = body.angular_damping.unwrap_or(def.angular_damping);
        def.can_sleep = body.can_sleep.unwrap_or(def.can_sleep);
        def.asleep = body.asleep.unwrap_or(def.asleep);
        def.enabled = body.enabled.unwrap_or(def.enabled);
        def.user_data = body.user_data.unwrap_or(def.user_data);
        if let Some(mass) = &body.mass {
            def.mass = self.mass(&place.key("mass"), mass)?;
        }
        for (i, shape) in body.shapes.iter().enumerate() {
            let made = self.shape(&place.nth("shapes", i), shape)?;
            def.shapes.extend(made);
        }
        if let Some(glue) = &body.glue {
            def.glue = Some(self.glue(&place.key("glue"), glue, &def.shapes)?);
        }
        def.fracture = body.fracture.as_ref().map(fracture);
        def.validate().map_err(|e| self.refused_body(place, body, &e))?;
        let number = self.seats.len();
        let name = body.name.clone().unwrap_or_else(|| format!("#{number}"));
        Ok(SceneBody { name, def })
    }

    /// The engine's error about a body, at the field where the file has it.
    fn refused_body(
        &self,
        place: &Place,
        body: &document::Body,
        e: &drystone::DefError,
    ) -> SceneError {
        let field = e.field();
        let inner = field.strip_prefix("shapes[").and_then(|rest| rest.split_once("]."));
        if let Some((number, name)) = inner
            && let Ok(number) = number.parse::<usize>()
            && let Some(shape) = body.shapes.get(number)
            && let Some(key) = super::shape::key(shape)
        {
            let at = place.nth("shapes", number);
            let of_shape = ["pose", "density", "surface", "one_way", "reports", "material"];
            let at = match name.strip_prefix("pose.") {
                Some(name) => at.field(name),
                None if name == "shape" => at.key(key),
                None if of_shape.iter().any(|own| name.starts_with(own)) => at.field(name),
                None => at.key(key).field(name),
            };
            return self.fail(&at, format!("is {}", e.value()), e.allowed());
        }
        self.refused(place, e)
    }

    fn mass(&self, place: &Place, mass: &Mass) -> Result<MassDef, SceneError> {
        let full = match mass {
            Mass::Total(mass) => return Ok(MassDef::Mass(*mass)),
            Mass::Full(full) => full,
        };
        let inertia = match full.inertia[..] {
            [xx, yy, zz] => Sym3 { xx, yy, zz, xy: 0.0, xz: 0.0, yz: 0.0 },
            [xx, yy, zz, xy, xz, yz] => Sym3 { xx, yy, zz, xy, xz, yz },
            _ => {
                let problem = format!("is a list of {}", full.inertia.len());
                let allowed = "[xx, yy, zz] or [xx, yy, zz, xy, xz, yz]";
                return Err(self.fail(&place.key("inertia"), problem, allowed));
            }
        };
        let center = full.center.map_or(Vec3::ZERO, Vec3::from);
        Ok(MassDef::Exact { mass: full.mass, center, inertia })
    }

    fn glue(
        &self,
        place: &Place,
        glue: &document::Glue,
        shapes: &[ShapeDef],
    ) -> Result<Glue, SceneError> {
        let strength = glue.strength.map(strength);
        let Some(bonds) = &glue.bonds else {
            let strength = strength.ok_or_else(|| {
                let allowed = "what the bonds bear, or the bonds themselves";
                self.fail(place, "it has no strength and no bonds", allowed)
            })?;
            return Glue::touching(shapes, glue.gap.unwrap_or(1.0e-3), strength)
                .map_err(|e| self.refused(place, &e));
        };
        if glue.gap.is_some() {
            let allowed = "a gap without bonds: it is for bonds that are found";
            return Err(self.fail(&place.key("gap"), "there are bonds beside it", allowed));
        }
        let mut made = Vec::with_capacity(bonds.len());
        for (i, bond) in bonds.iter().enumerate() {
            let own = bond.strength.map(self::strength).or(strength).ok_or_else(|| {
                let allowed = "a strength of its own, or of the glue";
                self.fail(&place.nth("bonds", i), "it has no strength", allowed)
            })?;
            made.push(Bond {
                shapes: bond.shapes,
                point: bond.point.into(),
                normal: bond.normal.into(),
                area: bond.area,
                strength: own,
            });
        }
        Ok(Glue { bonds: made })
    }
}

fn strength(strength: document::Strength) -> BondStrength {
    BondStrength { tension: strength.tension.0, shear: strength.shear.0 }
}

fn fracture(fracture: &document::Fracture) -> Fracture {
    let default = Fracture::default();
    Fracture {
        impulse: fracture.impulse.map_or(default.impulse, |v| v.0),
        energy: fracture.energy.map_or(default.energy, |v| v.0),
        pieces: fracture.pieces.unwrap_or(default.pieces),
        min_size: fracture.min_size.unwrap_or(default.min_size),
        focus: fracture.focus.unwrap_or(default.focus),
        generations: fracture.generations.unwrap_or(default.generations),
        seed: fracture.seed.unwrap_or(default.seed),
    }
}

fn locks(axes: &[AxisName]) -> AxisLocks {
    let mut locks = AxisLocks::NONE;
    for axis in axes {
        match axis {
            AxisName::X => locks.linear[0] = true,
            AxisName::Y => locks.linear[1] = true,
            AxisName::Z => locks.linear[2] = true,
            AxisName::TurnX => locks.angular[0] = true,
            AxisName::TurnY => locks.angular[1] = true,
            AxisName::TurnZ => locks.angular[2] = true,
        }
    }
    locks
}
