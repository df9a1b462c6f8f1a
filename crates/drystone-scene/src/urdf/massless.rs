//! Links without a mass, which simulators and tools accept in many places: a root that stands for
//! the world or the floor, links between two joints at one place, frames of tools and cameras.

use std::collections::BTreeSet;

use drystone::geometry::MassProperties;
use drystone::math::Sym3;
use drystone::{Shape, Vec3};

use super::inertia;
use crate::links::{Dof, Hold, Link, Weight};
use crate::mass::mass_of;

/// The part of a link's mass that a link without one takes, if several joints hang on it.
const SHARE: f32 = 0.125;

/// Most joints that are passed on to one link.
const MOST_JOINTS: usize = 6;

/// Anchors this close are one: the pose between them is rounded [m].
const SAME: f32 = 1.0e-6;

/// Links that are one body, because only fixed joints are between them.
#[derive(Clone, Debug, Default)]
struct Group {
    members: Vec<usize>,
    /// Heads of the groups that hang on it by joints.
    below: Vec<usize>,
}

/// The head of each link's group, and the groups by their heads.
fn groups(links: &[Link<'_>]) -> (Vec<usize>, Vec<Group>) {
    let mut head_of: Vec<usize> = Vec::with_capacity(links.len());
    let mut groups = vec![Group::default(); links.len()];
    for (i, link) in links.iter().enumerate() {
        let head = match link.parent {
            Some(p) if link.hold == Hold::Fast => head_of[p],
            Some(p) => {
                groups[head_of[p]].below.push(i);
                i
            }
            None => i,
        };
        head_of.push(head);
        groups[head].members.push(i);
    }
    (head_of, groups)
}

/// Whether a group has a mass, or would have one if all of its files were there. Shapes weigh
/// something where the file says nothing of the mass.
fn has_mass(links: &[Link<'_>], members: &[usize]) -> bool {
    members.iter().any(|&i| match links[i].weight {
        Weight::Given(m) => m.mass > 0.0,
        Weight::Unsaid => links[i].left_out.is_some() || mass_of(&links[i].shapes).mass > 0.0,
    })
}

/// Whether the first link, with what is fixed to it, has no mass.
pub(super) fn is_root(links: &[Link<'_>]) -> bool {
    let (_, groups) = groups(links);
    groups.first().is_some_and(|root| !has_mass(links, &root.members))
}

/// Lets every link that joints move have a mass. Names of joints that do not move any more are
/// added to `held`.
pub(super) fn settle(links: &mut [Link<'_>], held: &mut BTreeSet<String>, notes: &mut Vec<String>) {
    let (head_of, mut groups) = groups(links);
    // From the ends of the tree back, because what hangs on a link decides.
    for head in (1..links.len()).rev() {
        if head_of[head] != head {
            continue;
        }
        let moves = matches!(links[head].hold, Hold::Joints(_));
        if !moves || has_mass(links, &groups[head].members) {
            continue;
        }
        let Some(parent) = links[head].parent else { continue };
        let above = head_of[parent];
        let below: Vec<usize> = groups[head]
            .below
            .iter()
            .copied()
            .filter(|&i| matches!(links[i].hold, Hold::Joints(_)))
            .collect();
        let has_shapes = groups[head].members.iter().any(|&i| !links[i].shapes.is_empty());
        match below[..] {
            [] => hold_fast(links, head, held, notes),
            [next] if !has_shapes && dofs(links, next).len() < MOST_JOINTS => {
                pass_on(links, head, next, &head_of, notes);
                groups[above].below.push(next);
            }
            [next, ..] => borrow(links, head, next, notes),
        }
    }
}

/// The joints of a link.
fn dofs<'l>(links: &'l [Link<'_>], i: usize) -> &'l [Dof] {
    if let Hold::Joints(dofs) = &links[i].hold { dofs } else { &[] }
}

fn hold_fast(
    links: &mut [Link<'_>],
    head: usize,
    held: &mut BTreeSet<String>,
    notes: &mut Vec<String>,
) {
    let names: Vec<String> = dofs(links, head).iter().map(|d| d.name.clone()).collect();
    notes.push(format!(
        "joint {}: '{}' and what hangs on it have no mass, so the joint is left out: held fast",
        names.join(", "),
        links[head].name
    ));
    held.extend(names);
    links[head].hold = Hold::Fast;
}

/// The next link gets the joint in front of its own, as joints one after the other: exact.
fn pass_on(
    links: &mut [Link<'_>],
    head: usize,
    next: usize,
    head_of: &[usize],
    notes: &mut Vec<String>,
) {
    // From the head to the next link, over links that are fixed to the head.
    let mut between = links[next].pose;
    let mut at = links[next].parent;
    while let Some(i) = at.filter(|&i| i != head && head_of[i] == head) {
        between = links[i].pose.compose(&between);
        at = links[i].parent;
    }
    let own = dofs(links, next).to_vec();
    let moved = dofs(links, head).iter().map(|dof| {
        let anchor = between.local_point(dof.anchor);
        // Joints through one point are one joint.
        let near = own.iter().find(|d| (d.anchor - anchor).length() <= SAME);
        Dof {
            axis: between.inverse().direction(dof.axis),
            anchor: near.map_or(anchor, |d| d.anchor),
            ..dof.clone()
        }
    });
    let joined: Vec<Dof> = moved.chain(own.iter().cloned()).collect();
    notes.push(format!(
        "'{}' has no mass: its joint and that of '{}' move one link, its frame stays with the link above",
        links[head].name, links[next].name
    ));
    links[next].pose = links[head].pose.compose(&between);
    links[next].parent = links[head].parent;
    links[next].hold = Hold::Joints(joined);
    links[head].hold = Hold::Fast;
}

/// A link that several joints hang on, or that collides, takes a part of the next one's mass.
fn borrow(links: &mut [Link<'_>], head: usize, next: usize, notes: &mut Vec<String>) {
    let Weight::Given(whole) = links[next].weight else { return };
    let part = |share: f32| MassProperties {
        mass: whole.mass * share,
        center: whole.center,
        inertia: whole.inertia.scaled(share),
    };
    notes.push(format!(
        "'{}' has no mass and joints hang on it: it takes {SHARE} of the mass of '{}'",
        links[head].name, links[next].name
    ));
    links[next].weight = Weight::Given(part(1.0 - SHARE));
    links[head].weight = Weight::Given(MassProperties { center: Vec3::ZERO, ..part(SHARE) });
}

/// A single mass without any moment, and without shapes that it could come from, is a small ball.
fn give_moment(links: &mut [Link<'_>], members: &[usize], notes: &mut Vec<String>) {
    let is_massive = |i: usize| matches!(links[i].weight, Weight::Given(m) if m.mass > 0.0);
    let massive: Vec<usize> = members.iter().copied().filter(|&i| is_massive(i)).collect();
    let [only] = massive[..] else { return };
    let has_shapes = members.iter().any(|&i| mass_of(&links[i].shapes).mass > 0.0);
    let Weight::Given(own) = &mut links[only].weight else { return };
    if has_shapes || own.inertia != Sym3::default() {
        return;
    }
    own.inertia = Sym3::diagonal(Vec3::splat(inertia::of_ball(own.mass)));
    let name = &links[only].name;
    notes.push(format!("{name}: it has no inertia, that of a ball of 1 cm is taken"));
}

/// Lets links that move have an inertia, and takes planes off them, which are for the ground.
pub(super) fn finish(links: &mut [Link<'_>], notes: &mut Vec<String>) {
    let (head_of, groups) = groups(links);
    for (head, group) in groups.iter().enumerate() {
        if links[head].hold != Hold::World {
            give_moment(links, &group.members, notes);
        }
    }
    for i in 0..links.len() {
        if links[head_of[i]].hold == Hold::World {
            continue;
        }
        let link = &mut links[i];
        let count = link.shapes.len();
        link.shapes.retain(|shape| !matches!(shape.shape, Shape::HalfSpace { .. }));
        if link.shapes.len() < count {
            notes.push(format!("{}: a plane that moves is left out", link.name));
        }
    }
}
