//! Links that overlap as the file has them: their shapes are approximations, and would push each
//! other away for as long as they are. They do not collide.

use std::collections::{BTreeMap, BTreeSet};

use drystone::{BodyId, World};

use crate::links::{Assembled, Link};
use crate::scene::Scene;

/// Less overlap than this is contact [m].
const DEPTH: f32 = 1.0e-3;

/// Robots of more links may overlap everywhere, which takes time and memory with the square of
/// their number.
const MOST_LINKS: usize = 1000;

/// Keeps bodies from number `first` on from colliding where they overlap, with a note for each
/// pair.
pub(super) fn exclude(
    links: &[Link<'_>],
    assembled: &mut Assembled,
    first: usize,
    scene: &mut Scene,
) {
    if links.len() > MOST_LINKS {
        let why = "which of them overlap in the file's pose is not looked for";
        scene.notes.push(format!("it has more than {MOST_LINKS} links: {why}"));
        return;
    }
    let mut alone = scene.clone();
    alone.joints.clear();
    alone.couplings.clear();
    alone.config.gravity = drystone::Vec3::ZERO;
    let Ok(mut running) = alone.build() else { return };
    running.world.step(1.0e-6);
    let pairs = deep(&running.world, &running.bodies);
    let mut link_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (link, (body, _)) in assembled.place.iter().enumerate() {
        link_of.entry(*body).or_insert(link);
    }
    for [a, b] in pairs {
        // The ground is not of the robot.
        if a < first {
            continue;
        }
        let (Some(&i), Some(&j)) = (link_of.get(&a), link_of.get(&b)) else { continue };
        if assembled.are_apart(i, j) {
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
fn deep(world: &World, bodies: &[BodyId]) -> BTreeSet<[usize; 2]> {
    let number: BTreeMap<BodyId, usize> = bodies.iter().copied().zip(0..).collect();
    let is_deep = |c: &drystone::contact::ContactRef<'_>| c.points().any(|p| p.separation < -DEPTH);
    world
        .contacts()
        .filter(is_deep)
        .filter_map(|c| Some([*number.get(&c.body_a())?, *number.get(&c.body_b())?]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect()
}
