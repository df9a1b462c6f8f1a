//! What breaks at the end of a step: joints, bonds of glued bodies, bodies that fracture. After all stages, by
//! one thread, in the order of slots: bodies come and go here. See manual/breakage.md.

mod bonds;
mod glue;
mod joints;
mod shatter;
mod split;

use super::World;
use crate::base::math::Vec3;
use crate::state::bodies::Bodies;
use crate::state::contacts::Contact;

pub use self::glue::BondRef;
pub(super) use self::glue::bonds_of;

/// What a contact point gave to a body that can break, in a step.
#[derive(Clone, Copy, Debug)]
struct Blow {
    body: u32,
    /// Contact and point: blows are summed in their order.
    contact: u32,
    place: u8,
    shape: u32,
    other: u32,
    /// From the body's center of mass [m, world].
    arm: Vec3,
    /// On the body [N s, world].
    impulse: Vec3,
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    blows: Vec<Blow>,
    bodies: Vec<u32>,
    bonds: bonds::Scratch,
}

impl Scratch {
    /// What one body got.
    fn blows_of(&self, body: u32) -> &[Blow] {
        let first = self.blows.partition_point(|b| b.body < body);
        let end = self.blows.partition_point(|b| b.body <= body);
        &self.blows[first..end]
    }
}

impl World {
    /// Breaks what the step was too much for. `dt`: of the step [s].
    pub(super) fn break_bodies(&mut self, dt: f32) {
        if !self.tables.breakage.any() {
            return;
        }
        let mut scratch = core::mem::take(&mut self.breaking);
        self.gather_blows(&mut scratch.blows);
        self.break_glue(&mut scratch, dt);
        self.fracture_bodies(&mut scratch);
        self.breaking = scratch;
    }

    fn gather_blows(&self, blows: &mut Vec<Blow>) {
        blows.clear();
        let (bodies, contacts) = (&self.tables.bodies, &self.tables.contacts);
        for g in self.scratch.given().filter(|g| g.asked) {
            // Contacts of what was put aside in this step are gone.
            if let Some(contact) = contacts.get(g.contact) {
                let pressed: f32 = g.points.iter().sum();
                let rub = g.push - contact.normal * pressed;
                add_blows(bodies, g.contact, contact, &g.points, rub, blows);
            }
        }
        // Blocks are in an order that goes by the number of workers.
        blows.sort_unstable_by_key(|b| (b.body, b.contact, b.place));
    }
}

/// What a contact gave to each of its bodies that can break; friction is where the pressure is.
fn add_blows(
    bodies: &Bodies,
    row: u32,
    c: &Contact,
    points: &[f32; 4],
    rub: Vec3,
    blows: &mut Vec<Blow>,
) {
    let count = usize::from(c.count.min(4));
    let total = points[..count].iter().fold(0.0, |sum, p| sum + p);
    #[expect(clippy::cast_precision_loss, reason = "at most 4")]
    let even = 1.0 / count.max(1) as f32;
    for (side, body) in [c.body_a, c.body_b].into_iter().enumerate() {
        if !bodies.at(body).breaks || bodies.at(body).out {
            continue;
        }
        let (shape, other) = if side == 0 { (c.shape_a, c.body_b) } else { (c.shape_b, c.body_a) };
        for (place, (p, pressed)) in (0_u8..).zip(c.points().iter().zip(points)) {
            let share = if total > 0.0 { pressed / total } else { even };
            let on_b = c.normal * *pressed + rub * share;
            let (arm, impulse) = if side == 0 { (p.r_a, -on_b) } else { (c.r_b(p), on_b) };
            if impulse != Vec3::ZERO {
                blows.push(Blow { body, contact: row, place, shape, other, arm, impulse });
            }
        }
    }
}
