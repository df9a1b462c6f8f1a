//! Links that overlap as the file has them: their shapes are approximations, and would push each other away
//! for as long as they are. They do not collide.

use std::collections::BTreeSet;

use drystone::World;

use crate::links::{Assembled, Link};
use crate::scene::Scene;

/// Less overlap than this is contact [m].
const DEPTH: f32 = 1.0e-3;

/// Keeps bodies from number `first` on from colliding where they overlap, with a note for each pair.
pub(super) fn exclude(links: &[Link<'_>], assembled: &Assembled, first: usize, scene: &mut Scene) {
    let mut alone = scene.clone();
    alone.joints.clear();
    alone.couplings.clear();
    alone.config.gravity = drystone::Vec3::ZERO;
    let Ok(mut running) = alone.build() else { return };
    running.world.step(1.0e-6);
    let pairs = deep(&running.world, &running.bodies);
    for [a, b] in pairs {
        // The ground is not of the robot.
        if a < first {
            continue;
        }
        let link = |body: usize| assembled.place.iter().position(|(on, _)| *on == body);
        let (Some(i), Some(j)) = (link(a), link(b)) else { continue };
        if assembled.are_apart(scene, i, j) {
            continue;
        }
        assembled.exclude(scene, i, j);
        scene.notes.push(format!(
            "{} and {} overlap in the file's pose: they do not collide",
            links[i].name, links[j].name
        ));
    }
}

/// Pairs of bodies, by their numbers, that are deep in each other.
fn deep(world: &World, bodies: &[drystone::BodyId]) -> BTreeSet<[usize; 2]> {
    let number = |id| bodies.iter().position(|b| *b == id);
    let is_deep = |c: &drystone::ContactRef<'_>| c.points().any(|p| p.separation < -DEPTH);
    world
        .contacts()
        .filter(is_deep)
        .filter_map(|c| Some([number(c.body_a())?, number(c.body_b())?]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect()
}
