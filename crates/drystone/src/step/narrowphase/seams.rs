//! Contacts that only the cut of a surface into shapes makes are taken away.
//!
//! What slides over shapes that lie flush meets the side of the next one, or its edge, before it is over
//! it: to that shape alone it is a wall. But the shape that carries the body keeps all of it on one side of
//! a plane, and where the next shape lies wholly on the other side the two cannot meet. Such a contact
//! would brake and throw up. Of a mesh the triangles know their neighbors. Where a mesh ends, nothing in it says
//! whether another mesh goes on there: a contact with such an edge is looked at like one with a shape, but the
//! edge alone has to lie under the plane.
//!
//! Symbols: n1 normal of the contact that carries, towards the carried body, and P its plane, through the
//! surface of what carries; n2 that of the contact in doubt.
//! Reads: bodies, shapes, contacts. Writes: contacts (manifolds). Runs: serially over what may be a ghost or
//! make one, body by body; parallel over contacts in doubt, which are only read; then serially over what is
//! taken away.

use super::change::Change;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::sparse::Sparse;
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::geometry::collide::convex::Convex;
use crate::geometry::manifold::BORDER;
use crate::geometry::solid::Core;
use crate::state::bodies::{Bodies, Body, NONE};
use crate::state::contacts::{Contact, Contacts};
use crate::state::shapes::{ShapeRow, Shapes};
use crate::step::context::StepContext;

/// Shapes are flush up to this part of the carried body's extent, or this angle [rad].
const FLUSH: f32 = 1.0e-3;

/// 1 - cos of the angle (1 mrad) from which two normals differ.
const SAME_NORMAL: f32 = 5.0e-7;

/// Cosine of 5.1°: a flat contact, of three points or more, whose normal leans less carries too. What rests on two tiles and is askew
/// by some roundings would tip over the end of one otherwise.
const UPRIGHT: f32 = 0.996;

/// How far the carried shape may be under the plane at the end of the step, as a part of its body's extent:
/// what tips over the end of a shape does come down on the next one.
const DIP: f32 = 4.0e-3;

/// What moves less than this part of the smaller one's extent in a step neither slides over another body nor runs
/// into it: in ten steps it stays within [`FLUSH`]. So piles at rest do not look for seams.
const SLIDES: f32 = 1.0e-4;

/// Places are known to this part of their coordinates: two roundings of f32 of each of two bodies.
const ROUNDING: f32 = 2.4e-7;

/// At most this many contacts of a shape are asked whether they hide another one of it. The question is put for every pair of them: a
/// shape that lies in a hundred others took minutes a step. A ghost may stay where a shape has more contacts than that.
const MOST_ASKED: u32 = 64;

/// So many changes ahead of the one that is looked at its contact is asked for from memory.
const PREFETCH: usize = 8;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    doubted: Vec<u32>,
    hidden: Vec<Vec<Ghost>>,
    held: Held,
}

/// A contact that is a ghost, and the normal of what carries [world].
#[derive(Clone, Copy, Debug)]
struct Ghost {
    row: u32,
    normal: Vec3,
}

/// What holds each shape past which another one may carry it. (Its body's list of contacts has all that come near it
/// too: in a heap of limp people a walk through those was half of the narrowphase.)
#[derive(Clone, Debug, Default)]
struct Held {
    /// First of each shape row, or [`NONE`].
    first: Sparse,
    holds: Vec<Hold>,
}

/// A contact with points, seen from a body that it carries.
#[derive(Clone, Copy, Debug)]
struct Hold {
    row: u32,
    /// 0: A is carried; 1: B is.
    side: u32,
    shape: u32,
    /// What carries stands.
    stands: bool,
    /// Unit, towards the body, when the manifold was made [world].
    normal: Vec3,
    /// The next one of the shape, or [`NONE`].
    next: u32,
}

/// What a contact with points of two convex shapes is to the search for ghosts, if anything.
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

/// The same of a manifold with points of a mesh.
#[inline]
pub(super) fn of_mesh(row: u32, contact: &Contact) -> Change {
    if is_at_border(contact) { Change::Made(row) } else { Change::Carries(row) }
}

/// True if all of it is where a mesh ends.
fn is_at_border(contact: &Contact) -> bool {
    contact.points().iter().all(|p| p.feature & BORDER != 0)
}

/// True if `under` may have a neighbor for its shape that carries `body` too, at rest or not.
#[inline]
fn is_ground(under: &Body, body: &Body) -> bool {
    body.is_dynamic() && (!under.is_dynamic() || under.shapes.len() > 1)
}

/// True of two dynamic bodies that move against each other.
#[inline]
fn slides(ctx: &StepContext, a: &Body, b: &Body) -> bool {
    let least = SLIDES * lesser(a.extent, b.extent);
    a.is_dynamic()
        && b.is_dynamic()
        && (b.v - a.v).length_squared() * (ctx.dt * ctx.dt) > least * least
}

/// True if the contact is about to stop something: nothing else can be a ghost. A row acts a substep ahead of the
/// touch, so on the last sweep it looks that far beyond the step.
fn closes(ctx: &StepContext, contact: &Contact, a: &Body, b: &Body) -> bool {
    let least = SLIDES * lesser(a.extent, b.extent);
    contact.points().iter().any(|p| {
        let v = b.velocity_at(p.r_a - contact.offset) - a.velocity_at(p.r_a);
        let gap = greater(p.separation - ctx.rest_offset, 0.0);
        -contact.normal.dot(v) * (ctx.dt + ctx.h) > gap + least
    })
}

/// True if it keeps its place.
fn stands(body: &Body) -> bool {
    !body.is_dynamic() && !body.active()
}

impl Scratch {
    /// The contacts that were ghosts in this step.
    pub(super) fn hidden(&self) -> impl Iterator<Item = u32> {
        self.hidden.iter().flatten().map(|ghost| ghost.row)
    }
}

/// Takes away what [`Change::Made`] lists of contacts that are ghosts, and lists those that lose their points.
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
    // In the first step, which makes all else too, not in that of the first touch.
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
        // What is hidden itself hides nothing: so the order does not matter, and of two that hide each
        // other both stay.
        out.extend(doubted[range].iter().filter_map(|row| {
            let normal = seen.hidden_by(*row, |by| seen.hidden_by(by, |_| true).is_none())?;
            Some(Ghost { row: *row, normal })
        }));
    });
    for Ghost { row, normal } in hidden.iter().flatten() {
        let contact = contacts.at_mut(*row);
        if contact.count > 2 && contact.normal.dot(*normal) > UPRIGHT {
            // It carries too, beside the other: it gets the normal that the surface has.
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
    /// Lists what the changes name.
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

    /// What holds a shape.
    fn of(&self, shape: u32) -> impl Iterator<Item = &Hold> {
        let mut at = self.first.get(shape);
        core::iter::from_fn(move || {
            let hold = self.holds.get(at as usize)?;
            at = hold.next;
            Some(hold)
        })
    }
}

/// The tables, as they are after all manifolds are made.
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
    /// The body and shape that are carried, and those that carry.
    body: &'a Body,
    shape: u32,
    under: &'a Body,
    under_shape: u32,
    /// Unit, towards the carried body [world].
    normal: Vec3,
    /// The point from the carrying body's center is `r_a` less this [m, world].
    origin: Vec3,
}

/// The plane that a contact keeps the carried body above.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// Unit, towards the carried body [world].
    normal: Vec3,
    /// Along the normal from the center of what carries [m].
    at: f32,
    /// The deepest overlap of the points, 0 or more [m].
    deepest: f32,
    /// How far the points would go under the plane in this step [m].
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

    /// The normal of a contact that `may` hide others and hides this one, from A to B of this one.
    fn hidden_by(&self, row: u32, may: impl Fn(u32) -> bool) -> Option<Vec3> {
        let contact = self.contacts.at(row);
        for (side, shape) in [(0, contact.shape_a), (1, contact.shape_b)] {
            let Some(past) = self.held.of(shape).find(|hold| hold.row == row) else {
                continue;
            };
            let doubted = self.side(row, side);
            let mut asked = 0;
            let found = self.held.of(shape).find_map(|on| {
                let may_hide = on.row != row
                    // Most are told by this: what rests on several tiles of a floor.
                    && !(on.stands && on.normal.dot(past.normal) > 1.0 - SAME_NORMAL)
                    && !self.contacts.at(on.row).sensor;
                asked += u32::from(may_hide);
                if !may_hide || asked > MOST_ASKED {
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
        // From here on relative to the center of what carries, so that far from the world's origin nothing
        // is lost but what the places of the bodies have lost.
        let shift = past.under.center - on.under.center;
        let far = on.under.center.abs().max(past.under.center.abs()).max_element();
        let rounding = ROUNDING * far;
        // At the plane, not far below it, where the body comes when it has left what carries it.
        let least = plane.at - (plane.deepest + self.ctx.margin);
        let mut at = Vec3::ZERO;
        for p in past.contact.points() {
            at = p.r_a - past.origin + shift;
            if n1.dot(at) < least {
                return None;
            }
            // A mesh may be anywhere, but the edge that is touched lies under the plane.
            let edge = at - past.normal * (0.5 * p.base);
            let over = n1.dot(edge) + self.rise(n1, (on, past), (edge, shift)) - plane.at;
            // What rests stands off by the rest offset, and points of a small body are no more exact than that.
            if at_border && over > FLUSH * extent + rounding + self.ctx.rest_offset {
                return None;
            }
        }
        if let Some(core) = core {
            // The other shape lies under the plane. What lies far off may be askew, but no more than that.
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

    /// How far what is past rises over what carries within the step, along `n1`: at a point from the center of what
    /// carries [m].
    fn rise(&self, n1: Vec3, (on, past): (&Side<'_>, &Side<'_>), (at, shift): (Vec3, Vec3)) -> f32 {
        let v = past.under.velocity_at(at - shift) - on.under.velocity_at(at);
        n1.dot(v) * self.ctx.dt
    }

    /// How far what carries has turned since the manifold was made: a recycled one is as old as its probe.
    fn turn(&self, row: u32, on: &Side<'_>) -> Quat {
        if stands(on.under) {
            return Quat::IDENTITY;
        }
        let [a, b] = self.contacts.rotations_of(row);
        let then = if core::ptr::eq(on.under, self.bodies.at(on.contact.body_a)) { a } else { b };
        on.under.rotation * then.conjugate()
    }

    /// As it stands now, turned so far, with this normal.
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

    /// True if the carried shape comes below the plane in this step, and farther than the contact's points are.
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

/// Where a shape of `body` is, from the body's center plus `shift`.
fn placed(shape: &ShapeRow, body: &Body, shift: Vec3) -> Pose {
    Pose { position: shift, rotation: body.rotation }.compose(&shape.centered)
}
