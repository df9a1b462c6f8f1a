//! Ghost contacts: removes contacts that exist only because a flush surface is cut into shapes.
//!
//! A body that slides over flush shapes meets the side or the edge of the next one before it is
//! over it; to that shape alone, this is a wall. But the shape that carries the body keeps all of
//! it on one side of a plane. If the next shape lies wholly on the other side, the two cannot meet.
//! Such a contact would brake the body and throw it up. The triangles of a mesh store their
//! neighbors. Where a mesh ends, its data do not tell whether another mesh continues there. A
//! contact with such an edge is treated like a contact with a shape, but only the edge has to lie
//! under the plane.
//!
//! Symbols: n1 normal of the contact that carries, towards the carried body, and P its plane,
//! through the surface of the carrying shape; n2 normal of the contact in doubt.
//! Reads: bodies, shapes, contacts. Writes: contacts (manifolds). Runs: serially over contacts that
//! may be ghosts or make others ghosts, body by body; in parallel over contacts in doubt, which are
//! only read; then serially over the ghosts.

use super::change::Change;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::sparse::Sparse;
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::geometry::collide::convex::Convex;
use crate::geometry::manifold::BORDER;
use crate::geometry::solid::Core;
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, NONE};
use crate::state::contacts::{Contact, Contacts};
use crate::state::shapes::{ShapeRow, Shapes};
use crate::step::context::StepContext;

/// Tolerance within which shapes are flush, as a part of the carried body's extent, or as an angle
/// [rad].
const FLUSH: f32 = 1.0e-3;

/// 1 - cos of the angle (1 mrad) from which two normals differ.
const SAME_NORMAL: f32 = 5.0e-7;

/// Cosine of 5.1°. A flat contact, with three points or more, whose normal tilts less than this
/// carries the body too. Without it a body that rests on two tiles and is tilted by some roundings
/// would tip over the end of one.
const UPRIGHT: f32 = 0.996;

/// Maximum depth of the carried shape under the plane at the end of the step, as a part of its
/// body's extent. A body that tips over the end of a shape does come down on the next one.
const DIP: f32 = 4.0e-3;

/// Minimum displacement in a step at which a body slides over another or runs into it, as a part of
/// the smaller one's extent. Below it the body stays within [`FLUSH`] for ten steps, so piles at
/// rest do not search for seams.
const SLIDES: f32 = 1.0e-4;

/// Relative accuracy of coordinates: two roundings of f32 for each of two bodies.
const ROUNDING: f32 = 2.4e-7;

/// Maximum number of a shape's contacts that are tested for hiding another one. The test runs for
/// every pair of them: a shape that lies in a hundred others took minutes a step. A ghost may stay
/// where a shape has more contacts than that.
const MAX_TESTED: u32 = 64;

/// Prefetch distance for contacts, in changes.
const PREFETCH: usize = 8;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    doubted: Vec<u32>,
    hidden: Vec<Vec<Ghost>>,
    held: Held,
}

/// A ghost contact, and the normal of the contact that carries the body [world].
#[derive(Clone, Copy, Debug)]
struct Ghost {
    row: u32,
    normal: Vec3,
}

/// Contacts of each shape that may carry it past another one. (The body's list of contacts also has
/// everything nearby: in a heap of limp people a walk through those was half of the narrowphase.)
#[derive(Clone, Debug, Default)]
struct Held {
    /// First entry for each shape row, or [`NONE`].
    first: Sparse,
    holds: Vec<Hold>,
}

/// A contact with points, seen from a body that it carries.
#[derive(Clone, Copy, Debug)]
struct Hold {
    row: u32,
    /// 0: A is carried; 1: B is carried.
    side: u32,
    shape: u32,
    /// The carrying body is fixed.
    stands: bool,
    /// Unit normal towards the carried body, when the manifold was made [world].
    normal: Vec3,
    /// Next entry of the shape, or [`NONE`].
    next: u32,
}

/// Role in the search for ghosts of a contact with points between two convex shapes, if any.
#[inline]
pub(super) fn of_convex(
    ctx: &StepContext,
    (row, contact): (u32, &Contact),
    a: &Body,
    b: &Body,
) -> Option<Change> {
    if contact.count == 0 || contact.sensor {
        return None;
    }
    if is_ground(a, b) || is_ground(b, a) {
        return Some(Change::Made(row));
    }
    if !slides(ctx, a, b) {
        return None;
    }
    Some(if closes(ctx, contact, a, b) { Change::Made(row) } else { Change::Carries(row) })
}

/// Role in the search for ghosts of a mesh manifold with points.
#[inline]
pub(super) fn of_mesh(row: u32, contact: &Contact) -> Change {
    if is_at_border(contact) { Change::Made(row) } else { Change::Carries(row) }
}

/// True if all points are where a mesh ends.
fn is_at_border(contact: &Contact) -> bool {
    contact.points().iter().all(|p| p.feature & BORDER != 0)
}

/// True if the shape of `under` may have a neighbor that carries `body` too, at rest or not.
#[inline]
fn is_ground(under: &Body, body: &Body) -> bool {
    body.is_dynamic() && (!under.is_dynamic() || under.ties.shapes.len() > 1)
}

/// True if two dynamic bodies move against each other.
#[inline]
fn slides(ctx: &StepContext, a: &Body, b: &Body) -> bool {
    let minimum = SLIDES * lesser(a.extent, b.extent);
    a.is_dynamic()
        && b.is_dynamic()
        && (b.v - a.v).length_squared() * (ctx.dt * ctx.dt) > minimum * minimum
}

/// True if the contact is about to stop something; only such contacts can be ghosts. A row acts a
/// substep before the touch, so in the last sweep it looks that far beyond the step.
fn closes(ctx: &StepContext, contact: &Contact, a: &Body, b: &Body) -> bool {
    let minimum = SLIDES * lesser(a.extent, b.extent);
    contact.points().iter().any(|p| {
        let v = b.velocity_at(p.r_a - contact.offset) - a.velocity_at(p.r_a);
        let gap = greater(p.separation - ctx.rest_offset, 0.0);
        -contact.normal.dot(v) * (ctx.dt + ctx.h) > gap + minimum
    })
}

/// True if the body keeps its place.
fn stands(body: &Body) -> bool {
    !body.is_dynamic() && !body.active()
}

impl Scratch {
    /// Contacts that were ghosts in this step.
    pub(super) fn hidden(&self) -> impl Iterator<Item = u32> {
        self.hidden.iter().flatten().map(|ghost| ghost.row)
    }
}

/// Removes the points of [`Change::Made`] contacts that are ghosts, and lists those that lose their
/// points.
pub(super) fn hide(
    ctx: &StepContext,
    bodies: &Bodies,
    shapes: &Shapes,
    contacts: &mut Contacts,
    (changes, ghosts): (&[Vec<Change>], &mut Vec<Change>),
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let Scratch { doubted, hidden, held } = scratch;
    // Grows in the first step, with everything else, rather than in the step of the first touch.
    held.first.cover(shapes.rows.slot_count());
    doubted.clear();
    ghosts.clear();
    for change in changes.iter().flatten() {
        if let Change::Made(row) = change {
            doubted.push(*row);
        }
    }
    hidden.iter_mut().for_each(Vec::clear);
    let n = doubted.len();
    if n == 0 {
        return;
    }
    held.list(ctx, changes, bodies, contacts);
    let seen = Seen { ctx, bodies, shapes, contacts, held };
    collect_ranges(jobs, n, grain(jobs, n, 32), hidden, |range, out| {
        // A hidden contact hides no other, so the order does not matter. If two hide each other,
        // both stay.
        out.extend(doubted[range].iter().filter_map(|row| {
            let normal = seen.hidden_by(*row, |by| seen.hidden_by(by, |_| true).is_none())?;
            Some(Ghost { row: *row, normal })
        }));
    });
    for Ghost { row, normal } in hidden.iter().flatten() {
        let contact = contacts.at_mut(*row);
        if contact.count > 2 && contact.normal.dot(*normal) > UPRIGHT {
            // It carries the body too, beside the other contact, and takes the surface's normal.
            contact.normal = *normal;
            continue;
        }
        if contact.is_part {
            let first = contact.first(*row);
            contacts.at_mut(first).others -= 1;
        }
        let contact = contacts.at_mut(*row);
        contact.count = 0;
        contact.tangent_impulse = Vec3::ZERO;
        contact.set_rolling_impulse(Vec3::ZERO);
        contact.twist_impulse = 0.0;
        if contact.place.is_somewhere() {
            ghosts.push(Change::Count(*row));
        }
    }
}

impl Held {
    /// Lists the contacts that the changes name.
    fn list(
        &mut self,
        ctx: &StepContext,
        changes: &[Vec<Change>],
        bodies: &Bodies,
        contacts: &Contacts,
    ) {
        for hold in self.holds.drain(..) {
            self.first.set(hold.shape, NONE);
        }
        for changes in changes {
            for (i, change) in changes.iter().enumerate() {
                if let Some(Change::Made(row) | Change::Carries(row)) = changes.get(i + PREFETCH) {
                    contacts.prefetch(*row, 4);
                }
                if let Change::Made(row) | Change::Carries(row) = change {
                    self.add(ctx, *row, bodies, contacts);
                }
            }
        }
    }

    fn add(&mut self, ctx: &StepContext, row: u32, bodies: &Bodies, contacts: &Contacts) {
        let c = contacts.at(row);
        let slides = slides(ctx, bodies.at(c.body_a), bodies.at(c.body_b));
        for (side, body, under, shape) in
            [(0, c.body_a, c.body_b, c.shape_a), (1, c.body_b, c.body_a, c.shape_b)]
        {
            let below = bodies.at(under);
            if !slides && !is_ground(below, bodies.at(body)) {
                continue;
            }
            let number = u32::try_from(self.holds.len()).expect("fewer than 2^31 contacts");
            let next = self.first.set(shape, number);
            let stands = stands(below);
            let normal = if side == 0 { -c.normal } else { c.normal };
            self.holds.push(Hold { row, side, shape, stands, normal, next });
        }
    }

    /// Contacts that hold a shape.
    fn of(&self, shape: u32) -> impl Iterator<Item = &Hold> {
        let mut at = self.first.get(shape);
        core::iter::from_fn(move || {
            let hold = self.holds.get(at as usize)?;
            at = hold.next;
            Some(hold)
        })
    }
}

/// The tables after all manifolds are made.
#[derive(Clone, Copy)]
struct Seen<'a> {
    ctx: &'a StepContext,
    bodies: &'a Bodies,
    shapes: &'a Shapes,
    contacts: &'a Contacts,
    held: &'a Held,
}

/// A contact seen from the body that it carries.
#[derive(Clone, Copy)]
struct Side<'a> {
    contact: &'a Contact,
    /// The carried body and shape, and the carrying ones.
    body: &'a Body,
    shape: u32,
    under: &'a Body,
    under_shape: u32,
    /// Unit, towards the carried body [world].
    normal: Vec3,
    /// A point relative to the carrying body's center is `r_a` minus this [m, world].
    origin: Vec3,
}

/// The plane that a contact keeps the carried body above.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// Unit, towards the carried body [world].
    normal: Vec3,
    /// Distance along the normal from the center of the carrying body [m].
    at: f32,
    /// The deepest overlap of the points, 0 or more [m].
    deepest: f32,
    /// Maximum depth that the points would reach under the plane in this step [m].
    held: f32,
}

impl<'a> Seen<'a> {
    /// `side` 0: A is carried; 1: B is.
    fn side(&self, row: u32, side: u32) -> Side<'a> {
        let contact = self.contacts.at(row);
        let (a, b) = (self.bodies.at(contact.body_a), self.bodies.at(contact.body_b));
        let (shape_a, shape_b) = (contact.shape_a, contact.shape_b);
        if side == 0 {
            let (normal, origin) = (-contact.normal, contact.offset);
            let (shape, under_shape) = (shape_a, shape_b);
            Side { contact, body: a, shape, under: b, under_shape, normal, origin }
        } else {
            let (normal, origin) = (contact.normal, Vec3::ZERO);
            let (shape, under_shape) = (shape_b, shape_a);
            Side { contact, body: b, shape, under: a, under_shape, normal, origin }
        }
    }

    /// The normal of a contact that satisfies `may` and hides this one; it points from A to B of
    /// this one.
    fn hidden_by(&self, row: u32, may: impl Fn(u32) -> bool) -> Option<Vec3> {
        let contact = self.contacts.at(row);
        for (side, shape) in [(0, contact.shape_a), (1, contact.shape_b)] {
            let Some(past) = self.held.of(shape).find(|hold| hold.row == row) else {
                continue;
            };
            let doubted = self.side(row, side);
            let mut tested = 0;
            let found = self.held.of(shape).find_map(|on| {
                let may_hide = on.row != row
                    // This excludes most candidates: contacts of a body at rest on several tiles of
                    // a floor.
                    && !(on.stands && on.normal.dot(past.normal) > 1.0 - SAME_NORMAL)
                    && !self.contacts.at(on.row).sensor;
                tested += u32::from(may_hide);
                if !may_hide || tested > MAX_TESTED {
                    return None;
                }
                let normal = self.hides(on.row, &self.side(on.row, on.side), &doubted)?;
                may(on.row).then_some(if side == 0 { -normal } else { normal })
            });
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// The normal of `on`, which carries the shape, if it makes `past` a ghost.
    fn hides(&self, row: u32, on: &Side<'_>, past: &Side<'_>) -> Option<Vec3> {
        let under = self.shapes.at(past.under_shape);
        let core = Convex::of(&under.solid.core);
        let at_border = matches!(under.solid.core, Core::Mesh(_)) && is_at_border(past.contact);
        if if core.is_some() { on.under_shape == past.under_shape } else { !at_border } {
            return None;
        }
        let turn = self.turn(row, on);
        let n1 = turn.rotate(on.normal);
        if n1.dot(past.normal) > 1.0 - SAME_NORMAL {
            return None;
        }
        let plane = self.plane(turn, n1, on);
        let extent = on.body.extent;
        // From here on relative to the center of the carrying body. Far from the world's origin
        // this loses only the precision that the bodies' positions have lost.
        let shift = past.under.center - on.under.center;
        let far = on.under.center.abs().max(past.under.center.abs()).max_element();
        let rounding = ROUNDING * far;
        // The point must be at the plane; a body that has left the carrying shape meets points far
        // below it.
        let minimum = plane.at - (plane.deepest + self.ctx.margin);
        let mut at = Vec3::ZERO;
        for p in past.contact.points() {
            at = p.r_a - past.origin + shift;
            if n1.dot(at) < minimum {
                return None;
            }
            // A mesh may extend anywhere, but the touched edge must lie under the plane.
            let edge = at - past.normal * (0.5 * p.base);
            let over = n1.dot(edge) + self.rise(n1, (on, past), (edge, shift)) - plane.at;
            // A body at rest stands off by the rest offset, and points of a small body are no more
            // exact than that.
            if at_border && over > FLUSH * extent + rounding + self.ctx.rest_offset {
                return None;
            }
        }
        if let Some(core) = core {
            // The other shape must lie under the plane. A distant part may be tilted, but only by
            // the same angle.
            let pose = placed(under, past.under, shift);
            let top = pose.point(core.support(pose.local_direction(n1))) + n1 * under.solid.radius;
            let flush = FLUSH * (extent + lesser((top - at).length(), extent)) + rounding;
            let here = self.rise(n1, (on, past), (at, shift));
            let rise = greater(here, self.rise(n1, (on, past), (top, shift)));
            if n1.dot(top) + greater(rise, 0.0) - plane.at > flush {
                return None;
            }
        }
        (!self.dips(on, &plane)).then_some(n1)
    }

    /// Rise of the shape in doubt over the carrying one within the step, along `n1`, at a point
    /// relative to the carrying body's center [m].
    fn rise(&self, n1: Vec3, (on, past): (&Side<'_>, &Side<'_>), (at, shift): (Vec3, Vec3)) -> f32 {
        let v = past.under.velocity_at(at - shift) - on.under.velocity_at(at);
        n1.dot(v) * self.ctx.dt
    }

    /// Rotation of the carrying body since the manifold was made: a recycled manifold is as old as
    /// its probe.
    fn turn(&self, row: u32, on: &Side<'_>) -> Quat {
        if stands(on.under) {
            return Quat::IDENTITY;
        }
        let [a, b] = self.contacts.rotations_of(row);
        let then = if core::ptr::eq(on.under, self.bodies.at(on.contact.body_a)) { a } else { b };
        on.under.rotation * then.conjugate()
    }

    /// The plane as it is now, after this turn and with this normal.
    fn plane(&self, turn: Quat, normal: Vec3, on: &Side<'_>) -> Plane {
        let (mut at, mut deepest, mut held) = (f32::NEG_INFINITY, 0.0, 0.0);
        for p in on.contact.points() {
            let r = turn.rotate(p.r_a - on.origin);
            at = greater(at, normal.dot(r) - 0.5 * p.base);
            deepest = greater(deepest, -p.separation);
            let arm = r + on.under.center - on.body.center;
            let approach = -normal.dot(on.body.velocity_at(arm) - on.under.velocity_at(r));
            held = greater(held, approach * self.ctx.dt - greater(p.separation, 0.0));
        }
        Plane { normal, at, deepest, held }
    }

    /// True if the carried shape comes below the plane in this step, by more than the contact's
    /// points.
    fn dips(&self, on: &Side<'_>, plane: &Plane) -> bool {
        let (n1, body) = (plane.normal, on.body);
        let shape = self.shapes.at(on.shape);
        let Some(core) = Convex::of(&shape.solid.core) else { return true };
        let w = body.w - on.under.w;
        let rotation = Quat::from_rotation_vector(w * self.ctx.dt) * body.rotation;
        let pose = Pose { position: Vec3::ZERO, rotation }.compose(&shape.centered);
        let lowest =
            n1.dot(pose.point(core.support(pose.local_direction(-n1)))) - shape.solid.radius;
        let between = body.center - on.under.center;
        let moves = n1.dot(body.v - on.under.velocity_at(between)) * self.ctx.dt + plane.held;
        let end = n1.dot(between) + lowest + moves;
        end < plane.at - (plane.deepest + DIP * body.extent)
    }
}

/// Pose of a shape of `body`, with the center of the body at `shift`.
fn placed(shape: &ShapeRow, body: &Body, shift: Vec3) -> Pose {
    Pose { position: shift, rotation: body.rotation }.compose(&shape.centered)
}
