//! Bodies.

use drystone::events::ContactReports;
use drystone::{BodyDef, BodyKind, MassDef, ShapeDef, Vec3};

use super::names::{Names, address};
use super::said::{other, parts, unless, unless_turn, unless_vec};
use super::shape::{filter, geometry};
use crate::error::SceneError;
use crate::own::document::{
    AxisName, Body, Bond, Fracture, Geometry, Glue, Kind, Reports, Senses, Shape as ShapeOf,
    Strength,
};
use crate::own::value::{Bound, FullMass, Mass};
use crate::scene::SceneBody;

impl Names {
    pub(super) fn write_body(&self, body: &SceneBody) -> Result<Body, SceneError> {
        let (def, default) = (&body.def, BodyDef::default());
        let mut shapes = Vec::with_capacity(def.shapes.len());
        for shape in &def.shapes {
            shapes.push(self.shape(shape)?);
        }
        Ok(Body {
            name: Some(body.name.clone()),
            kind: match def.kind {
                BodyKind::Static => Some(Kind::Static),
                BodyKind::Kinematic => Some(Kind::Kinematic),
                BodyKind::Dynamic => None,
            },
            position: unless_vec(def.position, Vec3::ZERO),
            rotation: unless_turn(def.rotation),
            linear_velocity: unless_vec(def.linear_velocity, Vec3::ZERO),
            angular_velocity: unless_vec(def.angular_velocity, Vec3::ZERO),
            mass: mass(&def.mass),
            gravity_scale: unless(def.gravity_scale, default.gravity_scale),
            linear_damping: unless(def.linear_damping, default.linear_damping),
            angular_damping: unless(def.angular_damping, default.angular_damping),
            locks: locks(def.locks),
            can_sleep: other(def.can_sleep, &default.can_sleep),
            sleep_speed: def.sleep_speed,
            asleep: other(def.asleep, &default.asleep),
            enabled: other(def.enabled, &default.enabled),
            shapes,
            glue: def.glue.as_ref().map(glue),
            fracture: def.fracture.as_ref().map(fracture),
            user_data: other(def.user_data, &default.user_data),
        })
    }

    fn shape(&self, def: &ShapeDef) -> Result<ShapeOf, SceneError> {
        let default = ShapeDef::sphere(1.0);
        let (position, rotation) = parts(&def.pose);
        let reports = |r: ContactReports| {
            let default = ContactReports::default();
            Reports {
                touches: other(r.touches, &default.touches),
                hits: other(r.hits, &default.hits),
                hit_speed: r.hit_speed,
                forces: other(r.forces, &default.forces),
            }
        };
        let senses = |s: drystone::events::Senses| Senses {
            statics: other(s.statics, &false),
            sensors: other(s.sensors, &false),
        };
        let mut made = ShapeOf {
            position,
            rotation,
            density: unless(def.density, default.density),
            material: self.material(&def.material),
            filter: filter(def.filter),
            sensor: other(def.sensor, &default.sensor),
            senses: other(def.senses, &default.senses).map(senses),
            surface_velocity: unless_vec(def.surface_velocity, Vec3::ZERO),
            surface_spin: unless_vec(def.surface_spin, Vec3::ZERO),
            one_way: def.one_way.map(Vec3::to_array),
            hooks: other(def.hooks, &default.hooks),
            reports: other(def.reports, &default.reports).map(reports),
            enabled: other(def.enabled, &default.enabled),
            user_data: other(def.user_data, &default.user_data),
            ..ShapeOf::default()
        };
        let shared = address(&def.shape).and_then(|address| self.shapes.get(&address));
        if let Some(name) = shared {
            made.shape = Some(name.clone());
            return Ok(made);
        }
        match geometry(&def.shape)? {
            Geometry::Sphere(shape) => made.sphere = Some(shape),
            Geometry::Capsule(shape) => made.capsule = Some(shape),
            Geometry::Box(shape) => made.cuboid = Some(shape),
            Geometry::Cylinder(shape) => made.cylinder = Some(shape),
            Geometry::Cone(shape) => made.cone = Some(shape),
            Geometry::HalfSpace(shape) => made.half_space = Some(shape),
            Geometry::Hull(shape) => made.hull = Some(shape),
            Geometry::Mesh(shape) => made.mesh = Some(shape),
            Geometry::Hulls(shape) => made.hulls = Some(shape),
        }
        Ok(made)
    }
}

fn mass(mass: &MassDef) -> Option<Mass> {
    match *mass {
        MassDef::FromShapes => None,
        MassDef::Mass(mass) => Some(Mass::Total(mass)),
        MassDef::Exact { mass, center, inertia: i } => {
            let center = unless_vec(center, Vec3::ZERO);
            let outer = [i.xy, i.xz, i.yz];
            let mut inertia = vec![i.xx, i.yy, i.zz];
            if outer.map(f32::to_bits) != [0; 3] {
                inertia.extend(outer);
            }
            Some(Mass::Full(FullMass { mass, center, inertia }))
        }
    }
}

fn locks(locks: drystone::AxisLocks) -> Vec<AxisName> {
    let ([x, y, z], [a, b, c]) = (locks.linear, locks.angular);
    let all = [
        (x, AxisName::X),
        (y, AxisName::Y),
        (z, AxisName::Z),
        (a, AxisName::TurnX),
        (b, AxisName::TurnY),
        (c, AxisName::TurnZ),
    ];
    all.into_iter().filter(|(is_locked, _)| *is_locked).map(|(_, axis)| axis).collect()
}

fn glue(glue: &drystone::breakage::Glue) -> Glue {
    let strength = |s: drystone::breakage::BondStrength| Strength {
        tension: Bound(s.tension),
        shear: Bound(s.shear),
    };
    let first = glue.bonds.first().map(|bond| strength(bond.strength));
    let bonds = glue.bonds.iter().map(|bond| Bond {
        shapes: bond.shapes,
        point: bond.point.to_array(),
        normal: bond.normal.to_array(),
        area: bond.area,
        strength: Some(strength(bond.strength)).filter(|own| Some(*own) != first),
    });
    Glue { bonds: Some(bonds.collect()), strength: first, gap: None }
}

fn fracture(fracture: &drystone::breakage::Fracture) -> Fracture {
    let default = drystone::breakage::Fracture::default();
    let bound = |value: f32| value.is_finite().then_some(Bound(value));
    Fracture {
        impulse: bound(fracture.impulse),
        energy: bound(fracture.energy),
        pieces: other(fracture.pieces, &default.pieces),
        min_size: unless(fracture.min_size, default.min_size),
        focus: other(fracture.focus, &default.focus),
        generations: other(fracture.generations, &default.generations),
        seed: other(fracture.seed, &default.seed),
    }
}
