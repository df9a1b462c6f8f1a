//! Positions: nothing passes through anything, and bodies at rest overlap only slightly.

use std::collections::{BTreeMap, BTreeSet};

use drystone::{BodyId, Filter, JointId, Pose, Shape, Vec3};

use super::floors::FIRST_BODY;
use super::measures::{Measures, measures, meets_box};
use super::moment::{Body, Look, Touch};
use crate::finding::{Findings, Kind};

/// Fraction of a shape's core that the middle of no other shape may enter. For a large shape it is
/// the core less half the thickness of the other shape. Two convex bodies overlap by more than that
/// if the middle of one is inside.
const INNER: f32 = 0.6;

/// Maximum rotation per step for which a path is straight in another body's frame [rad].
const MOST_TURN: f32 = 0.3;

/// Visible overlap of bodies at rest, as a fraction of the thickness of the thinner one.
const VISIBLE: f32 = 0.1;

/// Ratio of load to own weight up to which that limit holds; beyond, it grows in proportion.
const LOAD: f32 = 20.0;

/// Allowed gap of a joint, as a fraction of the length of its smaller body, and the time for which
/// more is tolerated [s].
const GAP: f32 = 0.05;
const GAP_TIME: f32 = 0.25;

/// Time for which a body must be slow before its overlaps are judged [s].
const SLOW_TIME: f32 = 0.5;

/// The middle of a shape and its surroundings, in a body's frame.
#[derive(Clone, Copy, Debug)]
struct Inner {
    pose: Pose,
    measures: Measures,
}

/// Positions over a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    inner: BTreeMap<BodyId, Vec<Inner>>,
    /// Pairs that were created overlapping, and whether some were at the start.
    excused: BTreeSet<[BodyId; 2]>,
    overlapped: bool,
    slow: BTreeMap<BodyId, f32>,
    gaps: BTreeMap<JointId, f32>,
    /// Maximum overlap at rest, and joint gap, relative to the allowed value.
    pub(super) worst: f32,
}

impl Places {
    /// Whether bodies were created overlapping.
    pub(super) fn is_overlapped(&self) -> bool {
        !self.excused.is_empty()
    }

    pub(super) fn see(&mut self, look: &Look<'_>, findings: &mut Findings) {
        if look.step == 1 || look.quiet < 1.5 * look.dt {
            self.inner = look.now.bodies.keys().map(|id| (*id, inner_of(look, *id))).collect();
        }
        if look.step == 1 || look.quiet < 1.5 * look.dt {
            for touch in look.now.touches.iter().filter(|t| t.depth() > 0.1 * thin_of(look, t)) {
                self.excused.insert(sorted(touch.bodies));
                self.overlapped |= look.step == 1;
            }
        }
        if !self.overlapped {
            self.pass(look, findings);
            self.deep(look, findings);
        }
        self.rest(look, findings);
        self.joints(look, findings);
    }

    /// Checks that the middle of no shape enters the core of another, or passes through it within a
    /// step.
    fn pass(&self, look: &Look<'_>, findings: &mut Findings) {
        for (a, body) in look.now.dynamic() {
            let Some(then) = look.before.bodies.get(&a) else { continue };
            if body.is_asleep && then.is_asleep && look.quiet > 0.1 && !look.step.is_multiple_of(32)
            {
                continue;
            }
            for (b, other) in &look.now.bodies {
                let Some(was) = look.before.bodies.get(b) else { continue };
                let is_excused = self.excused.contains(&sorted([a, *b]));
                if a == *b
                    || is_excused
                    || is_pair(look, body, other)
                    || (other.w.length() * look.dt > MOST_TURN)
                {
                    continue;
                }
                for mine in self.inner.get(&a).into_iter().flatten() {
                    let middle = mine.pose.point(mine.measures.middle);
                    let way = [then.pose.point(middle), body.pose.point(middle)];
                    if self.is_passed(*b, mine.measures.thin, [was, other], way)
                        || is_below(look, *b, way)
                    {
                        let both = format!("{} through {}", body.label, other.label);
                        let what = if other.is_dynamic() {
                            "a body passes another"
                        } else {
                            "a body passes what is fixed"
                        };
                        findings.add(Kind::Through, what, both, look.step);
                    }
                }
            }
        }
    }

    /// Whether a middle gets deeper into a body than half of its own thickness, or into the inner
    /// part.
    fn is_passed(
        &self,
        b: BodyId,
        thin: f32,
        [was, is]: [&Body; 2],
        [from, to]: [Vec3; 2],
    ) -> bool {
        let parts = self.inner.get(&b).into_iter().flatten();
        parts.into_iter().any(|part| {
            let local = |pose: &Pose, p: Vec3| {
                part.pose.local_point(pose.local_point(p)) - part.measures.middle
            };
            let (a, b) = (local(&was.pose, from), local(&is.pose, to));
            let core = part.measures.core;
            meets_box(a, b, (core - Vec3::splat(0.5 * thin)).max(core * INNER))
        })
    }

    /// Checks that no contact is deeper than half the thinner body.
    fn deep(&self, look: &Look<'_>, findings: &mut Findings) {
        for touch in &look.now.touches {
            let thin = thin_of(look, touch);
            if touch.depth() > thin && !self.excused.contains(&sorted(touch.bodies)) {
                let detail = format!("{} m, half a thickness is {thin} m", touch.depth());
                findings.add(Kind::Through, "deeper than half a thickness", detail, look.step);
            }
        }
    }

    /// Checks that bodies that have been slow for a while overlap only slightly.
    fn rest(&mut self, look: &Look<'_>, findings: &mut Findings) {
        for (id, body) in look.now.dynamic() {
            let slow = self.slow.entry(id).or_default();
            let is_slow = body.is_asleep || body.speed() < 0.1 * look.fall_speed(body);
            *slow = if is_slow { *slow + look.dt } else { 0.0 };
        }
        let is_load = |b: &&Body| b.is_dynamic() && b.label >= FIRST_BODY;
        let weight: f32 = look.now.bodies.values().filter(is_load).map(|b| b.mass).sum();
        for touch in &look.now.touches {
            let is_slow = |id: &BodyId| {
                let fixed = look.now.bodies.get(id).is_some_and(|b| !b.is_dynamic());
                fixed || self.slow.get(id).is_some_and(|slow| *slow > SLOW_TIME)
            };
            if !touch.bodies.iter().all(is_slow) || look.facts.gravity <= 0.0 {
                continue;
            }
            let own = touch.bodies.iter().filter_map(|id| look.now.bodies.get(id));
            let own = own.filter(|b| b.is_dynamic()).map(|b| b.mass).fold(f32::INFINITY, f32::min);
            let load = (weight / own / LOAD).max(1.0);
            let thick = 2.0 * thin_of(look, touch);
            let allowed = VISIBLE * thick * load;
            self.worst = self.worst.max(touch.depth() / allowed);
            if touch.depth() > allowed {
                let detail = format!("{} of a thickness of {thick} m", touch.depth());
                findings.add(Kind::Overlap, "what rests overlaps", detail, look.step);
            }
        }
    }

    fn joints(&mut self, look: &Look<'_>, findings: &mut Findings) {
        for joint in look.world.joints() {
            let large = |id: BodyId| look.now.bodies.get(&id).map_or(0.0, |b| b.large);
            let (a, b) = (large(joint.body_a()), large(joint.body_b()));
            let smaller = if a > 0.0 && b > 0.0 { a.min(b) } else { a.max(b) };
            let time = self.gaps.entry(joint.id()).or_default();
            let is_open = joint.error() > GAP * 2.0 * smaller;
            *time = if is_open { *time + look.dt } else { 0.0 };
            if *time > GAP_TIME {
                let detail = format!("{} m of a length of {} m", joint.error(), 2.0 * smaller);
                findings.add(Kind::Gap, "a joint stays open", detail, look.step);
            }
        }
    }

    /// Checks at the end that a half-size copy of each shape's core overlaps nothing.
    pub(super) fn end(&self, look: &Look<'_>, findings: &mut Findings) {
        if self.overlapped {
            return;
        }
        for (id, body) in look.now.dynamic() {
            for inner in self.inner.get(&id).into_iter().flatten() {
                let half = inner.measures.core * (0.5 * INNER);
                let pose = body.pose.compose(&inner.pose);
                let pose = Pose { position: pose.point(inner.measures.middle), ..pose };
                let found = look.world.query().overlap_shape(
                    &Shape::box_half(half),
                    pose,
                    Filter::default(),
                );
                for other in found.unwrap_or_default() {
                    let Some(shape) = look.world.shape(other) else { continue };
                    let Some(holder) = look.now.bodies.get(&shape.body()) else { continue };
                    if shape.body() == id || is_pair(look, body, holder) || shape.is_sensor() {
                        continue;
                    }
                    let both = format!("{} in {}", body.label, holder.label);
                    findings.add(Kind::Through, "a body ends within another", both, look.step);
                }
            }
        }
    }
}

fn inner_of(look: &Look<'_>, id: BodyId) -> Vec<Inner> {
    let shapes = look.world.body(id).into_iter().flat_map(|b| b.shapes().collect::<Vec<_>>());
    let shapes = shapes.filter_map(|id| look.world.shape(id)).filter(|s| !s.is_sensor());
    shapes
        .filter_map(|s| Some(Inner { pose: s.local_pose(), measures: measures(s.shape())? }))
        .collect()
}

/// Whether a joint keeps two bodies from colliding.
fn is_pair(look: &Look<'_>, a: &Body, b: &Body) -> bool {
    look.facts.pairs.contains(&(a.label.min(b.label), a.label.max(b.label)))
}

/// Whether a segment leads from above a plane, or a flat mesh, to below it.
fn is_below(look: &Look<'_>, other: BodyId, [from, to]: [Vec3; 2]) -> bool {
    let Some(body) = look.world.body(other) else { return false };
    body.shapes().filter_map(|id| look.world.shape(id)).any(|shape| {
        let pose = shape.pose();
        let (a, b) = (pose.local_point(from), pose.local_point(to));
        match shape.shape() {
            Shape::HalfSpace { normal, offset } => normal.dot(b) < *offset,
            Shape::Mesh(mesh) => {
                let bounds = mesh.bounds();
                let at = b;
                let is_over = bounds.min.x < at.x
                    && at.x < bounds.max.x
                    && bounds.min.z < at.z
                    && at.z < bounds.max.z;
                is_over && a.y >= 0.0 && b.y < 0.0
            }
            _ => false,
        }
    })
}

/// Half the thickness of the thinner body of a contact [m].
fn thin_of(look: &Look<'_>, touch: &Touch) -> f32 {
    let thin = |id: &BodyId| look.now.bodies.get(id).map_or(f32::INFINITY, |b| b.thin);
    touch.bodies.iter().map(thin).fold(f32::INFINITY, f32::min)
}

fn sorted([a, b]: [BodyId; 2]) -> [BodyId; 2] {
    [a.min(b), a.max(b)]
}
