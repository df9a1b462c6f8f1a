//! Candidate pairs: finds shapes of fast bodies that may have met others within the step. For a
//! body that stayed in its boxes, the candidates are its existing pairs. For other bodies, the
//! trees are queried along the path. A third search finds fast bodies whose paths crossed where
//! neither ended.

use core::cmp::Ordering;

use super::paths::Paths;
use crate::base::aabb::Aabb;
use crate::base::math::Vec3;
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::state::bodies::body::Body;
use crate::state::bounds::Bounds;
use crate::state::contacts::Contacts;
use crate::state::def::BodyKind;
use crate::state::joints::Joints;
use crate::state::shapes::{ShapeRow, Shapes};
use crate::step::broadphase::may_meet;
use crate::step::narrowphase::rebuild::chord;
use crate::step::notes::Flight;

/// Two shapes, the lower row first.
pub(super) type Meeting = (u32, u32);

/// Tables that the search needs.
pub(super) struct Around<'a> {
    pub(super) paths: Paths<'a>,
    pub(super) shapes: &'a Shapes,
    pub(super) bounds: &'a Bounds,
    pub(super) contacts: &'a Contacts,
    pub(super) joints: &'a Joints,
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    lists: Vec<Vec<Meeting>>,
    spans: Vec<Span>,
    found: Vec<Meeting>,
}

impl Scratch {
    /// Candidate pairs, each once, ascending.
    pub(super) fn found(&self) -> &[Meeting] {
        &self.found
    }
}

/// Bounds of a fast body's path in the step.
#[derive(Clone, Copy, Debug)]
struct Span {
    around: Aabb,
    row: u32,
    /// Pairs exist with everything that it may have met.
    paired: bool,
}

/// A body thinner than this part of its reach does not count as a ball: its ends may meet what its
/// center passes by.
const LONG: f32 = 0.5;

/// Finds the candidate pairs. `rows`: contacts of fast bodies whose shapes may have met, if pairs
/// were `asked`.
pub(super) fn find(
    around: &Around<'_>,
    (fast, asked): (&[Flight], bool),
    rows: impl Iterator<Item = u32>,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let Scratch { lists, spans, found } = scratch;
    spans.clear();
    spans.extend(fast.iter().map(|flight| around.span(flight, asked)));
    collect_ranges(jobs, spans.len(), grain(jobs, spans.len(), 8), lists, |range, out| {
        spans[range].iter().filter(|span| !span.paired).for_each(|span| around.test(span, out));
    });
    found.clear();
    for row in rows {
        let c = around.contacts.at(row);
        if around.paths.may_pass(c.body_a, c.body_b) {
            around.add(c.shape_a, c.shape_b, found);
        }
    }
    found.extend(lists.iter().flatten());
    if spans.iter().any(|span| !span.paired) {
        around.cross(spans, found);
    }
    found.sort_unstable();
    found.dedup();
}

impl Around<'_> {
    fn span(&self, flight: &Flight, asked: bool) -> Span {
        let body = self.paths.bodies.at(flight.row);
        let around = Aabb::of_points([flight.from, body.center]).grown(body.extent);
        Span { around, row: flight.row, paired: asked && flight.in_boxes && !flight.flew }
    }

    /// Adds candidates from the trees.
    fn test(&self, span: &Span, out: &mut Vec<Meeting>) {
        for tree in [&self.bounds.moving, &self.bounds.fixed] {
            tree.query(&span.around, |other| {
                if self.paths.may_pass(span.row, self.shapes.at(other).body) {
                    for shape in &self.paths.bodies.at(span.row).ties.shapes {
                        self.add(*shape, other, out);
                    }
                }
                true
            });
        }
    }

    /// Finds fast bodies whose paths cross, by a sweep along the axis with the greatest spread.
    fn cross(&self, spans: &mut [Span], out: &mut Vec<Meeting>) {
        let ends = Aabb::of_points(spans.iter().map(|span| span.around.min));
        let axis = longest(ends.half_extents());
        spans.sort_unstable_by(|s, t| {
            let by_place = s.around.min[axis].total_cmp(&t.around.min[axis]);
            if by_place == Ordering::Equal { s.row.cmp(&t.row) } else { by_place }
        });
        for (i, span) in spans.iter().enumerate() {
            let near = |other: &&Span| other.around.min[axis] <= span.around.max[axis];
            for other in spans[i + 1..].iter().take_while(near) {
                if (span.paired && other.paired)
                    || !span.around.overlaps(&other.around)
                    || !self.paths.may_pass(span.row, other.row)
                {
                    continue;
                }
                for shape in &self.paths.bodies.at(span.row).ties.shapes {
                    for other in &self.paths.bodies.at(other.row).ties.shapes {
                        self.add(*shape, *other, out);
                    }
                }
            }
        }
    }

    /// Bounds of a shape's path in the step: a ball around its middle, moved along the path. `None`
    /// for a moving surface.
    fn swept(&self, shape: &ShapeRow) -> Option<Aabb> {
        let body = self.paths.bodies.at(shape.body);
        if shape.solid.is_surface() {
            return (body.kind == BodyKind::Static).then_some(shape.fat);
        }
        let (middle, size) = shape.solid.ball();
        let middle = shape.centered.point(middle);
        let end = body.center + body.rotation.rotate(middle);
        let (start, off) = self.paths.flight(shape.body).map_or((end, 0.0), |flight| {
            // An arc of a radian leaves its chord by an eighth of its radius; a longer one may be
            // any part of the circle.
            let is_arc = chord(&flight.stood, &body.rotation) < 0.9
                && body.w.length() * self.paths.ctx.dt < 1.0;
            let off = middle.length() * if is_arc { 0.13 } else { 2.0 };
            (flight.from + flight.stood.rotate(middle), off)
        });
        let rounding = 1.0e-6 * (start.abs().max_element() + end.abs().max_element());
        Some(Aabb::of_points([start, end]).grown(1.01 * size + off + rounding))
    }

    /// Adds two shapes if they may meet on their paths, unless rays decide the pair.
    fn add(&self, a: u32, b: u32, out: &mut Vec<Meeting>) {
        let (shape_a, shape_b) = (self.shapes.at(a), self.shapes.at(b));
        if !may_meet(self.paths.bodies, self.joints, shape_a, shape_b) {
            return;
        }
        let [body_a, body_b] = [shape_a, shape_b].map(|shape| self.paths.bodies.at(shape.body));
        let reports = is_reported(shape_a, body_a, body_b) || is_reported(shape_b, body_b, body_a);
        if reports && !shape_a.sensor && !shape_b.sensor {
            return;
        }
        let boxes = (self.swept(shape_a), self.swept(shape_b));
        let are_apart = matches!(&boxes, (Some(a), Some(b)) if !a.overlaps(b));
        if !are_apart {
            out.push((a.min(b), a.max(b)));
        }
    }
}

/// True if rays decide where a body meets a static shape. The shape then has no edges that the ray
/// could miss, and the body has no ends that reach far beyond the ball that the ray represents.
fn is_reported(shape: &ShapeRow, of: &Body, body: &Body) -> bool {
    let is_fixed = of.kind == BodyKind::Static;
    is_fixed && shape.solid.is_surface() && body.inner > LONG * body.extent
}

fn longest(v: Vec3) -> usize {
    if v.x >= v.y && v.x >= v.z {
        0
    } else if v.y >= v.z {
        1
    } else {
        2
    }
}
