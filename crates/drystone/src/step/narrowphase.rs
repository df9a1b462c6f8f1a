//! The stage `narrowphase`: computes the manifolds of awake contacts, and lists contacts that
//! gained or lost points.
//!
//! Reads: bodies, shapes. Writes: contacts (manifolds). Runs: in parallel over awake contacts, each
//! writing its own row (the first manifold of a mesh pair those of all its manifolds); then over
//! contacts that may be ghosts of a seam. Invariants: the list of changes is in the order of the
//! awake list, for any number of workers; the points that ghosts lose are listed after it.
//! References: [Gregorius13].
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

mod meeting;
pub(crate) mod keep;
mod mesh;
mod motion;
mod placed;
mod gate;
mod seams;
mod settling;
pub(crate) mod turning;
mod waits;
pub(crate) mod change;
pub(crate) mod lent;
pub(crate) mod rebuild;
pub(crate) mod scratch;

use fearless_simd::dispatch;

use self::change::Change;
use self::keep::{keep_load, recycle};
use self::lent::{Asked, Pairs};
use self::motion::Motions;
use self::rebuild::{Look, RENEWED_ROTATION, may_recycle, rebuild};
use self::scratch::{Scratch, Worker};
use self::turning::{list_for_solver, turn_ahead};
use super::context::StepContext;
use super::hooks::Hooks;
use super::reach::speculative_margin;
use crate::base::simd::wide::LANES;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, collect_ranges_with, fine_grain, for_ranges, grain};
use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use crate::geometry::manifold::{Manifold, PairCache};
use crate::geometry::room::room_to_turn;
use crate::geometry::solid::Core;
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, NONE, Track};
use crate::state::contacts::{Contact, Contacts, Lent};
use crate::state::shapes::{ShapeRow, Shapes};

/// Updates all awake contacts.
pub(crate) fn update_manifolds(
    ctx: &StepContext,
    bodies: &mut Bodies,
    shapes: &Shapes,
    contacts: &mut Contacts,
    scratch: &mut Scratch,
    hooks: Option<&Hooks<'_>>,
    jobs: &Jobs<'_>,
) {
    if contacts.awake_pairs().next().is_some() {
        look_ahead(ctx, bodies, jobs);
    }
    let known = &*bodies;
    // SAFETY: each watch is in one range, and only its range takes its contact and the contact's
    // further manifolds.
    let apart = unsafe { Apart::promise() };
    contacts.begin_hooks(hooks.is_some());
    let Lent { slots, watches, probes, softened } = contacts.watched_mut(apart);
    let Scratch { changes, ghosts, workers, seams, placed } = scratch;
    let count = watches.len();
    let minimum = fine_grain(jobs, count, 16);
    let (watches, probes) = (Rows::new(watches, apart), Rows::new(probes, apart));
    let softened = Rows::new(softened, apart);
    // If some shapes have hit speeds of their own, any speed may count.
    let hit_speed = if shapes.give_hit_speed > 0 { 0.0 } else { ctx.hit_speed };
    let landing = Track::at_most(hit_speed * ctx.dt * ctx.per_track);
    let asked = Asked { hooks, softened };
    let pairs = Pairs { ctx, bodies: known, shapes, slots, watches, probes, asked, landing };
    let margin = Track::at_least(ctx.margin * ctx.per_track);
    collect_ranges_with(jobs, count, minimum, workers, changes, |worker, range, out| {
        let mut line = Pipeline::default();
        for k in range {
            let watch = watches.read(k);
            if watch.waits(margin, &known.tracks) {
                continue;
            }
            probes.prefetch(k, 1);
            known.rows.prefetch(watch.body_a, 1);
            known.rows.prefetch(watch.body_b, 1);
            line.coming.add(k);
            if line.coming.is_full() {
                pairs.move_on(&mut line, out, worker);
            }
        }
        for _ in 0..Pipeline::STATIONS {
            pairs.move_on(&mut line, out, worker);
        }
    });
    seams::hide(ctx, known, shapes, contacts, (changes, ghosts), seams, jobs);
    placed::tell_loads(ctx, bodies, contacts, changes, placed);
}

/// Stores an upper bound on the speculative distance that each awake body contributes: see
/// [`speculative_margin`].
fn look_ahead(ctx: &StepContext, bodies: &mut Bodies, jobs: &Jobs<'_>) {
    let Bodies { rows, awake, tracks, .. } = bodies;
    // SAFETY: awake bodies are all different.
    let tracks = Rows::new(tracks, unsafe { Apart::promise() });
    for_ranges(jobs, awake.len(), grain(jobs, awake.len(), 256), |range| {
        for i in range {
            let row = awake[i];
            // Each body is a cache line for some ten instructions.
            if let Some(soon) = awake.get(i + 8) {
                rows.prefetch(*soon, 1);
            }
            if let Some(body) = rows.at(row) {
                let speed = body.v.length() + body.w.length() * body.extent;
                tracks.row(row as usize).ahead =
                    Track::at_least(1.1 * speed * ctx.dt * ctx.per_track);
            }
        }
    });
}

/// Up to a full group of pairs of a chunk, which are examined together.
#[derive(Clone, Copy, Default)]
struct Group<T> {
    pairs: [T; LANES],
    len: usize,
}

/// Indices of pairs that may be near.
type Near = Group<usize>;

/// Pairs that are due for a test, with their speculative distance [m] if it was computed.
type Due = Group<(usize, Option<f32>)>;

impl<T> Group<T> {
    fn add(&mut self, pair: T) {
        self.pairs[self.len] = pair;
        self.len += 1;
    }

    const fn is_full(&self) -> bool {
        self.len == LANES
    }

    fn pairs(&self) -> &[T] {
        &self.pairs[..self.len]
    }
}

/// A four-stage software pipeline: each stage prefetches the data that the next one reads.
#[derive(Clone, Copy, Default)]
struct Pipeline {
    /// Bodies are being prefetched.
    coming: Near,
    ready: Near,
    /// The due pairs are known, and their contacts are being prefetched.
    due: Due,
    /// Shapes of the due pairs are being prefetched.
    at_hand: Due,
}

impl Pipeline {
    const STATIONS: usize = 4;
}

impl Pairs<'_> {
    /// Advances each group by one stage; the last group is tested.
    fn move_on(&self, line: &mut Pipeline, out: &mut Vec<Change>, worker: &mut Worker) {
        self.test(&line.at_hand, out, worker);
        for &(k, _) in line.due.pairs() {
            if let Some(contact) = self.slots.read(self.watches.read(k).row() as usize) {
                self.shapes.rows.prefetch(contact.shape_a, 2);
                self.shapes.rows.prefetch(contact.shape_b, 2);
            }
        }
        let due = self.look_at(&line.ready);
        *line = Pipeline { coming: Near::default(), ready: line.coming, due, at_hand: line.due };
    }

    /// Examines the pairs of a group and returns those that are due. Mesh pairs are always due: for
    /// them the shape's motion, computed later, decides better than the body's.
    fn look_at(&self, group: &Near) -> Due {
        let tracks = &self.bodies.tracks;
        let mut found = waits::Found::default();
        if group.pairs().iter().any(|k| !self.watches.read(*k).has_parts()) {
            found = dispatch!(self.ctx.level, simd => {
                let pairs = group.pairs().iter().map(|k| (self.watches.read(*k), self.probes.read(*k)));
                waits::look(simd, self.ctx, self.bodies, pairs)
            });
        }
        let mut due = Due::default();
        for (lane, k) in group.pairs().iter().enumerate() {
            let watch = self.watches.row(*k);
            if !watch.has_parts() && found.due >> lane & 1 == 0 {
                watch.open(found.gap[lane] * self.ctx.per_track, tracks);
                continue;
            }
            watch.close(tracks);
            self.slots.prefetch(watch.row() as usize, Contact::CACHE_LINES);
            due.add((*k, found.reach.map(|reach| reach[lane])));
        }
        due
    }

    /// Tests pairs and updates their contacts.
    fn test(&self, due: &Due, out: &mut Vec<Change>, worker: &mut Worker) {
        let tracks = &self.bodies.tracks;
        let Worker { mesh, moving, motions } = worker;
        self.look_at_motions(due, moving, motions);
        for (lane, &(k, reach)) in due.pairs().iter().enumerate() {
            let watch = self.watches.row(k);
            let row = watch.row();
            if let Some(contact) = self.slots.row(row as usize) {
                let ends = [watch.body_a, watch.body_b].map(|body| self.bodies.at(body));
                let ahead = |body: u32| tracks[body as usize].ahead;
                let lands = ahead(watch.body_a) + ahead(watch.body_b) > self.landing;
                let (probe, per_track) = (self.probes.row(k), self.ctx.per_track);
                let look = Look { row, reach, watch, probe, tracks, per_track, lands };
                self.update(&mut *contact, look, (motions, lane), out, mesh);
                if ends.iter().any(|body| body.sleeps()) && out.last() != Some(&Change::Apart(row))
                {
                    self.meet(row, contact, ends, out);
                }
            }
        }
    }

    /// Lists a contact that touches a sleeping body in this step. Until then the contact is not
    /// solved: a body that only passes nearby wakes nothing.
    fn meet(&self, first: u32, contact: &Contact, [a, b]: [&Body; 2], out: &mut Vec<Change>) {
        // Where bodies freeze individually, their contacts are solved while they are frozen.
        if contact.sensor || self.ctx.wakes_alone {
            return;
        }
        // Displacement by gravity in the step, if an awake body is there to be moved by it.
        let falls = [a, b].iter().any(|body| body.is_dynamic() && body.active());
        let near = self.ctx.rest_offset + if falls { self.ctx.fall } else { 0.0 };
        let (mut row, mut part) = (first, Some(contact));
        while let Some(contact) = part {
            let touches = contact.points().iter().any(|p| {
                let velocity = b.velocity_at(contact.r_b(p)) - a.velocity_at(p.r_a);
                let closes = (-contact.normal.dot(velocity)).max(0.0);
                p.separation <= near + 1.1 * self.ctx.dt * closes
            });
            if touches && !contact.place.is_somewhere() {
                out.push(Change::Meets(row));
                return;
            }
            row = contact.next_part;
            part = if row == NONE { None } else { self.slots.read(row as usize).as_ref() };
        }
    }

    /// Computes the motion of shapes against meshes for the mesh pairs of a group; a lane for each
    /// pair.
    fn look_at_motions(&self, due: &Due, moving: &mut motion::Pairs, motions: &mut Motions) {
        let mut any = false;
        for (lane, &(k, _)) in due.pairs().iter().enumerate() {
            let watch = self.watches.read(k);
            if watch.has_parts()
                && let Some(contact) = self.slots.read(watch.row() as usize)
            {
                let [a, b] = [self.bodies.at(watch.body_a), self.bodies.at(watch.body_b)];
                moving.fill(lane, self.probes.read(k), a, b, self.shapes.at(contact.shape_b));
                any = true;
            }
        }
        if any {
            dispatch!(self.ctx.level, simd => moving.find(simd, motions));
        }
    }

    fn update(
        &self,
        contact: &mut Contact,
        mut look: Look<'_>,
        (motions, lane): (&Motions, usize),
        out: &mut Vec<Change>,
        scratch: &mut MeshScratch,
    ) {
        let Self { ctx, shapes, slots, .. } = self;
        let row = look.row;
        let [a, b] = [self.bodies.at(look.watch.body_a), self.bodies.at(look.watch.body_b)];
        let (shape_a, shape_b) = (shapes.at(contact.shape_a), shapes.at(contact.shape_b));
        let is_asked = ShapeRow::are_asked(shape_a, shape_b) && !contact.sensor;
        let gate = is_asked.then(|| self.gate(contact));
        if let Core::Mesh(mesh) = &shape_a.solid.core {
            let (a, b) = ((a, shape_a), (b, shape_b));
            let (motion, pair) = (motions.at(lane), (contact, &mut look, gate.as_ref()));
            let tables = (slots, &self.asked.softened);
            mesh::update(ctx, mesh, a, b, &motion, pair, tables, out, scratch);
            return;
        }
        if !shape_a.fat.overlaps(&shape_b.fat) {
            out.push(Change::Apart(row));
            return;
        }
        let turn = turn_ahead(ctx, (a, shape_a), (b, shape_b));
        let turns = |contact: &Contact, turn: f32, room: f32| {
            contact.count > 0 && !contact.sensor && (turn > RENEWED_ROTATION || turn > room)
        };
        if contact.recyclable
            && may_recycle(ctx, contact, look.probe, (a, b), turn)
            && recycle(ctx, contact, look.probe, (a, b), slots, look.lands)
        {
            if turns(contact, turn, f32::MAX) {
                out.push(Change::Turns(row));
            }
            list_for_solver(ctx, (row, contact), [a, b], out);
            keep_load(ctx, contact, a, b);
            // A ghost that was made before the contact that carries the body would block the body
            // for ever.
            out.extend(seams::of_convex(ctx, (row, contact), a, b));
            return;
        }
        // In the frame of A, so that no precision is lost far from the world's origin.
        let pose_a = shape_a.placed(a);
        let b_in_a = pose_a.relative(&shape_b.placed(b));
        let far = || speculative_margin(ctx, a, b, look.watch.bounces());
        let margin = if contact.sensor { 0.0 } else { look.reach.unwrap_or_else(far) };
        let before = if contact.is_renewed() { a.rotation } else { look.probe.rotation_a };
        let (solid_a, solid_b) = (&shape_a.solid, &shape_b.solid);
        let mut m = collide(ctx.level, solid_a, solid_b, &b_in_a, margin, &mut contact.cache);
        // For two moving bodies the arms would be those of a place that neither has reached.
        if !(contact.sensor || a.is_dynamic() && b.is_dynamic())
            && let Some(met) =
                meeting::look_ahead(ctx, [a, b], [solid_a, solid_b], (&pose_a, &b_in_a), &m)
        {
            m = met;
        }
        if let Some(gate) = &gate
            && m.count > 0
        {
            match gate.admit(ctx, &m, &pose_a) {
                Some(admitted) => admitted.tell(row, contact, &self.asked.softened),
                None => m.count = 0,
            }
        }
        look.restart(m.gap, a, b);
        contact.clear = room_to_turn(&m, [solid_a, solid_b], &b_in_a);
        rebuild(ctx, (row, contact), &m, (&pose_a, before), [a, b], out);
        if turns(contact, turn, contact.clear) {
            out.push(Change::Turns(row));
        }
        list_for_solver(ctx, (row, contact), [a, b], out);
        keep_load(ctx, contact, a, b);
        out.extend(seams::of_convex(ctx, (row, contact), a, b));
    }
}

/// True if two shapes overlap, with the result that their contact would have; A is the contact's
/// first shape.
pub(crate) fn overlap(
    ctx: &StepContext,
    (a, shape_a): (&Body, &ShapeRow),
    (b, shape_b): (&Body, &ShapeRow),
) -> bool {
    let b_in_a = shape_a.placed(a).relative(&shape_b.placed(b));
    if let Core::Mesh(mesh) = &shape_a.solid.core {
        let reach = Reach::still(0.0).in_lengths(ctx.length);
        let mut made = [Manifold::default(); MAX_PARTS];
        let scratch = &mut MeshScratch::default();
        return collide_mesh(ctx.level, mesh, &shape_b.solid, &b_in_a, &reach, scratch, &mut made)
            > 0;
    }
    let cache = &mut PairCache::default();
    collide(ctx.level, &shape_a.solid, &shape_b.solid, &b_in_a, 0.0, cache).count > 0
}
