//! Queries of particles: link kinds, energy, overlaps.

use crate::base::aabb::Aabb;
use crate::base::double::DVec3;
use crate::geometry::nearest::nearest;
use crate::query::audit::Energy;
use crate::state::def::particle_def::{LinkKind, LinkSpring};
use crate::state::particles::{LaneKind, Link, LinkBlock, Particles};
use crate::state::tables::Tables;

/// Returns the kind of the link in a lane.
pub(crate) fn link_kind(block: &LinkBlock, lane: usize) -> LinkKind {
    let (stiffness, damping) = (block.stiffness[lane], block.damping[lane]);
    match block.kinds[lane] {
        LaneKind::AtMost => LinkKind::AtMost,
        LaneKind::Rate => LinkKind::Spring(LinkSpring::Rate { stiffness, damping }),
        LaneKind::Frequency => {
            let (hertz, damping_ratio) = (stiffness, damping);
            LinkKind::Spring(LinkSpring::Frequency { hertz, damping_ratio })
        }
        LaneKind::Idle | LaneKind::Equal => LinkKind::Equal,
    }
}

/// ½ k x² of a link that is a spring [J]; 0 for other links.
pub(crate) fn link_energy(particles: &Particles, link: &Link) -> f64 {
    let (block, lane) = particles.block_of(link);
    let (a, b) = (block.row_a[lane], block.row_b[lane]);
    let stiffness = match link_kind(block, lane) {
        LinkKind::Spring(LinkSpring::Rate { stiffness, .. }) => f64::from(stiffness),
        LinkKind::Spring(LinkSpring::Frequency { hertz, .. }) => {
            let give =
                |solver_row: u32| f64::from(particles.states[solver_row as usize].inverse_mass());
            let give = give(a) + give(b);
            let omega = 2.0 * core::f64::consts::PI * f64::from(hertz);
            if give > 0.0 { omega * omega / give } else { 0.0 }
        }
        _ => return 0.0,
    };
    let gap = DVec3::from(particles.position(b)) - DVec3::from(particles.position(a));
    let stretch = gap.length() - f64::from(block.length[lane]);
    0.5 * stiffness * stretch * stretch
}

/// Kinetic and potential energy of all particles, and elastic energy of their springs [J]. Pinned
/// particles count as 0.
pub(crate) fn particle_sums(tables: &Tables) -> Energy {
    let (particles, mut sum) = (&tables.particles, Energy::default());
    let gravity = DVec3::from(tables.config.gravity);
    for (id, particle) in particles.rows.iter() {
        if particle.pinned {
            continue;
        }
        let solver_row = id.index() + 1;
        let (mass, v) =
            (f64::from(particle.mass), particles.states[solver_row as usize].velocity());
        let (v, x) = (DVec3::from(v), DVec3::from(particles.position(solver_row)));
        sum.linear += 0.5 * mass * v.dot(v);
        sum.potential -= mass * f64::from(particle.gravity_scale) * gravity.dot(x);
    }
    for (_, link) in particles.links.iter() {
        sum.elastic += link_energy(particles, link);
    }
    sum
}

/// Deepest overlap of a particle's ball with a shape [m].
pub(crate) fn penetration(tables: &Tables) -> f32 {
    let (particles, mut deepest) = (&tables.particles, 0.0_f32);
    for (id, particle) in particles.rows.iter() {
        let solver_row = id.index() + 1;
        let (x, radius) = (particles.position(solver_row), particles.x[solver_row as usize][3]);
        let attachment = particle.attachment.checked_sub(1);
        let attachment = attachment.map(|i| particles.attachments[i as usize].body);
        let around = Aabb::new(x, x).grown(radius);
        for tree in [&tables.bounds.fixed, &tables.bounds.moving] {
            tree.query(&around, |row| {
                let shape = tables.shapes.at(row);
                let meets = !shape.sensor && particle.filter.collides_with(shape.filter);
                if meets && attachment != Some(shape.body) {
                    let pose = shape.placed(tables.bodies.at(shape.body));
                    let found = nearest(&shape.solid, pose.local_point(x), radius);
                    deepest = found.map_or(deepest, |f| deepest.max(radius - f.distance));
                }
                true
            });
        }
    }
    deepest
}
