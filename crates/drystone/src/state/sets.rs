//! Sets of bodies (awake, not awake) and of constraints (colored, not). Only this module moves rows
//! between them.

pub(crate) mod changes;

use self::changes::Move;
use super::bodies::body::Subdivision;
use super::bodies::{Bodies, NONE};
use super::colors::{Coloring, Colors, Place};
use super::contacts::Contacts;
use super::def::BodyKind;
use super::events::Events;
use super::islands::Islands;
use super::joints::{JointModel, Joints};
use super::shapes::PairSurface;
use crate::base::math::Vec3;

/// The tables whose rows move together.
pub(crate) struct Sets<'a> {
    pub(crate) bodies: &'a mut Bodies,
    pub(crate) joints: &'a mut Joints,
    pub(crate) contacts: &'a mut Contacts,
    pub(crate) islands: &'a mut Islands,
    pub(crate) colors: &'a mut Colors,
    pub(crate) events: &'a mut Events,
}

/// The dynamic ones of two bodies, and their number.
pub(super) fn dynamic_of(bodies: &Bodies, a: u32, b: u32) -> ([u32; 2], usize) {
    match (bodies.at(a).is_dynamic(), bodies.at(b).is_dynamic()) {
        (true, true) => ([a, b], 2),
        (true, false) => ([a, NONE], 1),
        (false, true) => ([b, NONE], 1),
        (false, false) => ([NONE, NONE], 0),
    }
}

impl Sets<'_> {
    /// Adds a contact with points to the colors, and links the islands of its bodies.
    pub(crate) fn color_contact(&mut self, row: u32) {
        self.carry_out_one(row, Move::Enters);
    }

    /// Removes a contact from the colors; its islands stay linked until they are split.
    pub(crate) fn uncolor_contact(&mut self, row: u32) {
        self.carry_out_one(row, Move::Leaves);
    }

    fn is_special(&self, row: u32) -> bool {
        self.contacts.at(row).is_special(self.bodies)
    }

    /// Sets the surface properties of a contact, colored or not.
    pub(crate) fn set_surface(&mut self, row: u32, surface: &PairSurface) {
        let colored = self.contacts.at(row).place.is_somewhere();
        let before = colored && self.is_special(row);
        let c = self.contacts.at_mut(row);
        (c.friction, c.kinetic) = (surface.friction, surface.kinetic);
        c.restitution = surface.restitution;
        (c.rolling, c.spinning) = (surface.rolling, surface.spinning);
        (c.traits, c.round_patch) = (surface.traits, surface.round_patch);
        if c.rolling <= 0.0 {
            c.set_rolling_impulse(Vec3::ZERO);
        }
        self.contacts.follow_restitution(row);
        let after = colored && self.is_special(row);
        self.colors.special = self.colors.special + usize::from(after) - usize::from(before);
    }

    fn joint_coloring(colors: &mut Colors, n: usize) -> &mut Coloring {
        if n == 2 { &mut colors.joints } else { &mut colors.joints_fixed }
    }

    /// Adds a joint to the colors, and links the islands of its bodies.
    pub(crate) fn color_joint(&mut self, row: u32) {
        let joint = self.joints.at(row);
        let (a, b) = (joint.body_a, joint.body_b);
        let (dynamic, n) = dynamic_of(self.bodies, a, b);
        // Joints of bodies that are out of the world do not act, nor do couplings of such joints.
        let is_out = |body: u32| self.bodies.at(body).out;
        if joint.is_idle(self.bodies) || joint.place.is_somewhere() {
            return;
        }
        if let JointModel::Coupling(coupling) = &joint.model {
            let def = &coupling.def;
            let joints = [def.joint_a, def.joint_b].map(|id| self.joints.rows.row(id));
            let of = |row: u32| [self.joints.at(row).body_a, self.joints.at(row).body_b];
            let acts = |row: &u32| self.joints.at(*row).is_on();
            let rows = || joints.into_iter().flatten();
            if !rows().all(|row| acts(&row)) || rows().flat_map(of).any(is_out) {
                return;
            }
        }
        self.joints.at_mut(row).place =
            Self::joint_coloring(self.colors, n).insert(row, &dynamic[..n]);
        for body in &dynamic[..n] {
            self.bodies.at_mut(*body).ties.constraints += 1;
        }
        if n == 2 {
            self.islands.link(a, b, self.bodies);
        }
    }

    /// Removes a joint from the colors.
    pub(crate) fn uncolor_joint(&mut self, row: u32) {
        let joint = self.joints.at(row);
        let place = joint.place;
        if !place.is_somewhere() {
            return;
        }
        let (dynamic, n) = dynamic_of(self.bodies, joint.body_a, joint.body_b);
        if let Some(moved) = Self::joint_coloring(self.colors, n).remove(place, &dynamic[..n]) {
            self.joints.at_mut(moved).place = place;
        }
        self.joints.at_mut(row).place = Place::NOWHERE;
        for body in &dynamic[..n] {
            self.bodies.at_mut(*body).ties.constraints -= 1;
        }
    }

    fn set_active(&mut self, body: u32, active: bool) {
        let row = self.bodies.at(body).awake_row;
        if active == (row != NONE) {
            return;
        }
        let of = self.bodies.at(body);
        self.colors.bodies_changed |= of.ties.constraints > 0 || of.record.is_link;
        if active {
            let place = u32::try_from(self.bodies.awake.len()).expect("fewer than 2^32 bodies");
            self.bodies.awake.push(body);
            self.bodies.at_mut(body).awake_row = place;
        } else {
            self.bodies.awake.swap_remove(row as usize);
            if let Some(&moved) = self.bodies.awake.get(row as usize) {
                self.bodies.at_mut(moved).awake_row = row;
            }
            self.bodies.at_mut(body).awake_row = NONE;
        }
    }

    /// Updates the color state of a body's contacts and joints after a change of its activity.
    fn refresh_constraints(&mut self, body: u32) {
        let mut at = self.bodies.at(body).ties.contacts;
        while at != NONE {
            let row = at / 2;
            let c = self.contacts.at(row);
            at = c.links[(at & 1) as usize].next.get();
            let (a, b) = (self.bodies.at(c.body_a), self.bodies.at(c.body_b));
            let moves = a.active() || b.active();
            let solvable = self.islands.solves(a, b);
            let (colored, has_points) = (c.place.is_somewhere(), c.count > 0 && !c.sensor);
            self.contacts.set_awake(row, moves);
            if solvable && has_points && !colored {
                self.color_contact(row);
            } else if !solvable && colored {
                self.uncolor_contact(row);
            }
        }
        for i in 0..self.bodies.at(body).ties.joints.len() {
            let row = self.bodies.at(body).ties.joints[i];
            let joint = self.joints.at(row);
            let (a, b) = (self.bodies.at(joint.body_a), self.bodies.at(joint.body_b));
            let solvable = (a.active() && a.is_dynamic()) || (b.active() && b.is_dynamic());
            if solvable {
                self.color_joint(row);
            } else {
                self.uncolor_joint(row);
            }
        }
    }

    /// Changes a body's kind. Its contacts and joints stay, each in the coloring of its new bodies;
    /// the caller must end contacts that are no longer solved. Velocities stay.
    pub(crate) fn set_kind(&mut self, body: u32, kind: BodyKind) {
        let contacts: Vec<u32> =
            self.contacts.of_body(self.bodies.at(body)).map(|(row, _)| row).collect();
        for row in contacts {
            let c = self.contacts.at(row);
            let other = if c.body_a == body { c.body_b } else { c.body_a };
            self.islands.cut(other, self.bodies);
            self.uncolor_contact(row);
        }
        for i in 0..self.bodies.at(body).ties.joints.len() {
            let row = self.bodies.at(body).ties.joints[i];
            let joint = self.joints.at(row);
            let other = if joint.body_a == body { joint.body_b } else { joint.body_a };
            self.islands.cut(other, self.bodies);
            self.uncolor_joint(row);
        }
        self.set_active(body, false);
        self.islands.remove(body, self.bodies);
        let b = self.bodies.at_mut(body);
        let moves = b.v != Vec3::ZERO || b.w != Vec3::ZERO;
        let active = !b.out
            && match kind {
                BodyKind::Static => false,
                BodyKind::Kinematic => moves,
                BodyKind::Dynamic => true,
            };
        (b.kind, b.sleep.still_time) = (kind, 0.0);
        b.history.level = if kind == BodyKind::Dynamic { NONE } else { 0 };
        if kind == BodyKind::Dynamic {
            self.islands.create(body, self.bodies);
        }
        self.set_active(body, active);
        self.refresh_constraints(body);
        (self.colors.bodies_changed, self.colors.levels_dirty) = (true, true);
    }

    /// Removes a body from the world: from the awake set and its island; its velocities stay. The
    /// caller must end its contacts.
    pub(crate) fn take_out(&mut self, body: u32) {
        self.bodies.at_mut(body).out = true;
        self.set_active(body, false);
        if self.bodies.at(body).is_dynamic() {
            self.islands.remove(body, self.bodies);
            self.islands.create(body, self.bodies);
        }
        self.refresh_constraints(body);
    }

    /// Wakes a body, with its island. Static bodies and bodies out of the world do not wake.
    pub(crate) fn wake(&mut self, body: u32) {
        let b = self.bodies.at_mut(body);
        if b.out || b.kind == BodyKind::Static {
            return;
        }
        b.sleep.still_time = 0.0;
        if b.kind == BodyKind::Kinematic {
            if !b.active() {
                self.set_active(body, true);
                self.refresh_constraints(body);
            }
            return;
        }
        if b.active() {
            return;
        }
        let island = b.sleep.island;
        if island == NONE || self.islands.wake_alone {
            self.wake_members(&[body]);
        } else {
            let members = self.islands.members(island, self.bodies);
            self.wake_members(&members);
            self.islands.give_back(members);
        }
    }

    fn wake_members(&mut self, members: &[u32]) {
        for m in members {
            if !self.bodies.at(*m).out {
                self.bodies.at_mut(*m).sleep.still_time = 0.0;
                self.set_active(*m, true);
                let id = self.bodies.id(*m);
                self.events.wake.push(id);
            }
        }
        for m in members {
            self.refresh_constraints(*m);
        }
    }

    /// Removes a body whose state became non-finite from the awake sets. It stops, and is not
    /// reported as asleep.
    pub(crate) fn put_aside(&mut self, row: u32) {
        let asleep = self.events.sleep.len();
        self.put_to_sleep(&[row]);
        self.events.sleep.truncate(asleep);
        let body = self.bodies.at_mut(row);
        (body.out, body.record.faulted) = (true, true);
    }

    /// Puts bodies to sleep together: they stop, and leave the awake sets with their constraints.
    pub(crate) fn put_to_sleep(&mut self, members: &[u32]) {
        for m in members {
            let b = self.bodies.at_mut(*m);
            (b.v, b.w) = Default::default();
            if b.history.subdivision == Subdivision::Struck {
                // The impact is over.
                b.history.subdivision = Subdivision::Whole;
            }
            if b.active() && b.is_dynamic() {
                let id = self.bodies.id(*m);
                self.events.sleep.push(id);
            }
            self.set_active(*m, false);
        }
        for m in members {
            self.refresh_constraints(*m);
        }
    }
}
