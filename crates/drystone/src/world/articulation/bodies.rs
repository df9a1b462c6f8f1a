//! Bodies of links: their masses, inertias and poses.

use crate::base::math::{Vec3, vec3};
use crate::base::sym3::Sym3;
use crate::geometry::mass::MassProperties;
use crate::reduced::{Articulation, LinkDef, TreeDef};
use crate::state::def::{BodyDef, BodyKind, MassDef};
use crate::world::change::mass::principal_moments;

/// Part of an articulation's mass that a link has in contacts at least.
const MIN_PART: f64 = 1.0e-6;

/// Part of a link's largest moment of inertia that each of its moments is at least.
const MIN_MOMENT: f32 = 1.0e-5;

/// Bodies for the links of a tree, without shapes.
pub(super) fn link_bodies(def: &TreeDef, model: &Articulation) -> Vec<BodyDef> {
    let total: f64 = def.links.iter().map(|link| link.mass).sum();
    let least = (total * MIN_PART).max(1.0e-6);
    let body = |(index, link): (usize, &LinkDef)| {
        let motion = model.tree.link_motion(index, &model.work);
        let state = crate::step::solver::link_state(&motion);
        let moves = model.tree.moves(index);
        let kind = if moves { BodyKind::Dynamic } else { BodyKind::Static };
        let mut body = BodyDef { kind, ..BodyDef::dynamic() };
        if moves {
            let center = vector(link.center);
            let (mass, inertia) = (narrow(link.mass.max(least)), moments_of(link, least));
            body.mass = MassDef::Exact { mass, center, inertia };
            (body.linear_velocity, body.angular_velocity) = (state.v, state.w);
            body.position = state.center - state.rotation.rotate(center);
        } else {
            let (position, _) = model.pose(index).unwrap_or_default();
            body.position = vector(position);
        }
        body.rotation = state.rotation;
        body
    };
    def.links.iter().enumerate().map(body).collect()
}

/// Inertia of a link for contacts: no axis has much less than the others.
fn moments_of(link: &LinkDef, least: f64) -> Sym3 {
    let [xx, yy, zz, xy, xz, yz] = link.inertia.map(narrow);
    let inertia = Sym3 { xx, yy, zz, xy, xz, yz };
    let mass = MassProperties { mass: 1.0, center: Vec3::ZERO, inertia };
    let moments = principal_moments(&mass).0;
    // A link without inertia turns as a ball of 1 cm.
    let floor = (moments.max_element() * MIN_MOMENT).max(narrow(4.0e-5 * least));
    if moments.min_element() >= floor {
        return inertia;
    }
    Sym3 { xx: xx + floor, yy: yy + floor, zz: zz + floor, ..inertia }
}

const fn vector(v: [f64; 3]) -> Vec3 {
    vec3(narrow(v[0]), narrow(v[1]), narrow(v[2]))
}

#[expect(clippy::cast_possible_truncation, reason = "bodies have this precision")]
const fn narrow(x: f64) -> f32 {
    x as f32
}
