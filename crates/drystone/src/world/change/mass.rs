//! Mass properties of bodies, when bodies are added and when shapes are added or removed.

use crate::base::double::DVec3;
use crate::base::limits;
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::mass::MassProperties;
use crate::geometry::solid::Solid;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::MassSource;
use crate::state::def::{BodyDef, BodyKind, DefError, MassDef, ShapeDef, all_within, within};
use crate::state::tables::Tables;
use crate::world::World;

/// Limits on the propagation of a load change to the supporting bodies: the maximum number of
/// shares, and the minimum size of a share. The impulses are only the start of the next solve, so
/// small shares do not matter.
const SHARES: usize = 10_000;
const MIN_SHARE: f32 = 0.01;

/// The mass properties of a definition.
pub(crate) fn mass_of(def: &BodyDef) -> Result<MassProperties, DefError> {
    if def.kind != BodyKind::Dynamic {
        return Ok(MassProperties::default());
    }
    let parts: Vec<(Pose, MassProperties)> = def
        .shapes
        .iter()
        .filter(|s| !s.sensor && s.density > 0.0)
        .map(|s| (s.pose, MassProperties::of(&s.shape, s.density)))
        .collect();
    let each = def.shapes.iter();
    let reach = each.map(|s| Solid::of(&s.shape).max_extent(Vec3::ZERO) + s.pose.position.length());
    given_or_sum(def.mass, &MassProperties::combine(&parts), reach)
}

/// The mass properties of a body from its mass definition and those of its shapes together.
/// `reach`: distance that each shape reaches from the origin [m].
fn given_or_sum(
    mass: MassDef,
    shapes: &MassProperties,
    reach: impl Iterator<Item = f32>,
) -> Result<MassProperties, DefError> {
    let is_solid = shapes.mass > 0.0 && shapes.mass.is_finite();
    match mass {
        MassDef::FromShapes if is_solid => Ok(*shapes),
        MassDef::FromShapes => {
            let allowed = "above 0: add shapes with volume and density, or give an exact mass";
            Err(DefError::unsuitable("mass", shapes.mass, allowed))
        }
        MassDef::Mass(mass) => {
            if is_solid {
                return Ok(shapes.scaled_to(mass));
            }
            // A mass without a volume gets the inertia of a ball of the shapes' size, so that it
            // can rotate.
            let radius = reach.fold(0.0_f32, f32::max);
            let r = if radius > 0.0 { radius } else { 0.5 };
            let moment = 0.4 * mass * r * r;
            let inertia = crate::base::sym3::Sym3::diagonal(Vec3::splat(moment));
            Ok(MassProperties { mass, center: Vec3::ZERO, inertia })
        }
        MassDef::Exact { mass, center, inertia } => Ok(MassProperties { mass, center, inertia }),
    }
}

/// Principal moments and axes. Rounding may leave a tiny moment of either sign in place of 0. Such
/// moments become 0, which locks the axis.
pub(crate) fn principal_moments(mass: &MassProperties) -> (Vec3, Quat) {
    let (moments, principal) = mass.inertia.eigen();
    let minimum = 1.0e-9 * moments.max_element();
    let moment = |m: f32| if m > minimum { m } else { 0.0 };
    (vec3(moment(moments.x), moment(moments.y), moment(moments.z)), principal)
}

/// Checks the mass [kg] and the principal moments [kg m²] of a dynamic body.
pub(crate) fn check_mass(mass: f32, moments: Vec3) -> Result<(), DefError> {
    within("mass", mass, &limits::MASS)?;
    all_within("inertia", moments, &limits::MOMENT)
}

/// Checks the kinetic energy of a body with this mass [kg] and these principal moments [kg m²].
pub(crate) fn check_energy(
    mass: f32,
    moments: Vec3,
    [linear, angular]: [Vec3; 2],
) -> Result<(), DefError> {
    let squared = |v: Vec3| {
        let v = DVec3::from(v);
        v.dot(v)
    };
    let largest = f64::from(moments.max_element());
    for (field, inertia, velocity) in
        [("linear_velocity", f64::from(mass), linear), ("angular_velocity", largest, angular)]
    {
        if !(0.5 * inertia * squared(velocity) <= f64::from(limits::ENERGY.maximum)) {
            return Err(DefError::of_vec(field, velocity, limits::ENERGY.allowed));
        }
    }
    Ok(())
}

/// The mass definition of a body, whatever its current kind.
pub(crate) fn mass_def(bodies: &Bodies, row: u32) -> MassDef {
    match bodies.at(row).inertia.source {
        MassSource::Shapes => MassDef::FromShapes,
        MassSource::Mass(mass) => MassDef::Mass(mass),
        MassSource::Exact => {
            let given = bodies.given.get(&row).expect("what was given in full is kept");
            let MassProperties { mass, center, inertia } = *given;
            MassDef::Exact { mass, center, inertia }
        }
    }
}

impl World {
    /// Updates center of mass, inertia and, unless it was given, mass of a dynamic body after its
    /// shapes changed. No effect if the mass is exact, or if no shape with a mass is left.
    pub(crate) fn refresh_mass(&mut self, row: u32) {
        // A small remaining shape may have a mass below the allowed range.
        let can_be =
            |mass: &MassProperties| check_mass(mass.mass, principal_moments(mass).0).is_ok();
        if let Some(mass) = self.mass_with(row, None).filter(can_be) {
            self.set_mass(row, &mass);
        }
        self.refresh_extent(row);
        self.refresh_bounds(row);
    }

    /// The mass properties of a mass definition with the current shapes of a body.
    pub(crate) fn mass_from(&self, row: u32, mass: MassDef) -> Result<MassProperties, DefError> {
        let shapes = self.tables.bodies.at(row).ties.shapes.iter();
        let shapes = shapes.map(|s| self.tables.shapes.at(*s));
        let parts = self.parts(row);
        let reach = shapes.map(|s| s.solid.max_extent(Vec3::ZERO) + s.local.position.length());
        let mass = given_or_sum(mass, &MassProperties::combine(&parts), reach)?;
        check_mass(mass.mass, principal_moments(&mass).0)?;
        Ok(mass)
    }

    /// The local poses and mass properties of the body's shapes that have a mass.
    fn parts(&self, row: u32) -> Vec<(Pose, MassProperties)> {
        let shapes = self.tables.bodies.at(row).ties.shapes.iter();
        let solid = shapes.map(|s| self.tables.shapes.at(*s));
        solid
            .filter(|s| !s.sensor && s.density > 0.0)
            .map(|s| (s.local, MassProperties::of(&s.shape, s.density)))
            .collect()
    }

    /// The mass properties of a dynamic body with its shapes and one more. `None` if they do not
    /// depend on the shapes: the mass is exact, or no shape has a mass.
    pub(crate) fn mass_with(&self, row: u32, more: Option<&ShapeDef>) -> Option<MassProperties> {
        let body = self.tables.bodies.at(row);
        if body.kind != BodyKind::Dynamic || body.inertia.source == MassSource::Exact {
            return None;
        }
        let mut parts = self.parts(row);
        if let Some(def) = more.filter(|def| !def.sensor && def.density > 0.0) {
            let pose = Pose { rotation: def.pose.rotation.normalized(), ..def.pose };
            parts.push((pose, MassProperties::of(&def.shape, def.density)));
        }
        let total = MassProperties::combine(&parts);
        if !(total.mass > 0.0 && total.mass.is_finite()) {
            return None;
        }
        match body.inertia.source {
            MassSource::Mass(mass) => Some(total.scaled_to(mass)),
            MassSource::Shapes | MassSource::Exact => Some(total),
        }
    }

    /// Sets the mass and center of a body. Its shapes, joints and contacts keep their places in the
    /// world.
    pub(crate) fn set_mass(&mut self, row: u32, mass: &MassProperties) {
        let tables = &mut self.tables;
        let body = tables.bodies.at_mut(row);
        let shift = mass.center - body.inertia.local_center;
        let moved = body.rotation.rotate(shift);
        body.v = body.velocity_at(moved);
        body.center += moved;
        body.inertia.local_center = mass.center;
        body.inertia.mass = mass.mass;
        (body.inertia.moments, body.inertia.principal) = principal_moments(mass);
        for shape in body.ties.shapes.clone() {
            let s = tables.shapes.at_mut(shape);
            s.centered.position -= shift;
        }
        // The set of joints solved as trees depends on masses.
        tables.colors.bodies_changed = true;
        for joint in tables.bodies.at(row).ties.joints.clone() {
            let joint = tables.joints.at_mut(joint);
            if joint.body_a == row {
                joint.anchor_a -= shift;
            } else {
                joint.anchor_b -= shift;
            }
        }
        for attachment in
            tables.particles.attachments.iter_mut().filter(|attachment| attachment.body == row)
        {
            attachment.anchor -= shift;
        }
        let links: Vec<(u32, u32)> = tables.contacts.of_body(tables.bodies.at(row)).collect();
        for (contact, side) in links {
            tables.contacts.shift_center(contact, side, shift);
        }
    }

    /// Adds a weight change of `more` [kg] to the stored impulses of the contacts below a body,
    /// down to static and kinematic bodies. They then carry it from the first substep on. Otherwise
    /// a body that lost most of its mass would be thrown up, together with everything on top of it,
    /// by the old impulses.
    pub(crate) fn follow_weight(&mut self, row: u32, more: f32) {
        let gravity = self.tables.config.gravity * self.tables.bodies.at(row).forces.gravity_scale;
        let Some(up) = (-gravity).try_normalize() else { return };
        let whole = more * gravity.length() * self.last_h;
        if !whole.is_finite() {
            return;
        }
        let mut loads = vec![(row, whole)];
        // Several supports share a load, until a share is negligible.
        for _ in 0..SHARES {
            let Some((body, load)) = loads.pop() else { return };
            let Tables { bodies, contacts, .. } = &self.tables;
            if !bodies.at(body).is_dynamic() {
                continue;
            }
            let mut carry: Vec<(u32, u32, f32)> = Vec::new();
            for (contact, side) in contacts.of_body(bodies.at(body)) {
                let c = contacts.at(contact);
                let (sign, other) = if side == 1 { (1.0, c.body_a) } else { (-1.0, c.body_b) };
                let pressed = c.points().iter().fold(0.0, |sum, p| sum + p.impulse);
                let lift = sign * pressed * c.normal.dot(up);
                if !c.sensor && lift > 0.0 {
                    carry.push((contact, other, lift));
                }
            }
            let all = carry.iter().fold(0.0, |sum, (.., lift)| sum + lift);
            if !(all > 0.0) {
                continue;
            }
            // A contact cannot pull, so the factor is at least 0.
            let factor = (1.0 + load / all).max(0.0);
            for (contact, other, lift) in carry {
                self.tables.contacts.at_mut(contact).scale_impulses(factor);
                let share = lift * (factor - 1.0);
                if share.abs() > MIN_SHARE * whole.abs() {
                    loads.push((other, share));
                }
            }
        }
    }

    /// Updates the reach of a body from its center of mass, its thickness, and whether it is
    /// hollow.
    pub(crate) fn refresh_extent(&mut self, row: u32) {
        let tables = &mut self.tables;
        let body = tables.bodies.at_mut(row);
        (body.extent, body.inner, body.inertia.hollow) = (0.0, f32::INFINITY, true);
        for shape in body.ties.shapes.clone() {
            tables.shapes.at(shape).widen(body);
        }
    }
}
