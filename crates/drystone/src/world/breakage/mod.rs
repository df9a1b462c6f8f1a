//! Breakage at the end of a step: joints, bonds of glued bodies, and bodies that fracture. It runs
//! after all stages on one thread, in the order of slots, because bodies are added and removed. See
//! manual/breakage.md.

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

/// The impulse of one contact point on a breakable body, in one step.
#[derive(Clone, Copy, Debug)]
struct Impact {
    body: u32,
    /// Contact and point, the order of summation.
    contact: u32,
    place: u8,
    shape: u32,
    other: u32,
    /// Point of action from the body's center of mass [m, world].
    arm: Vec3,
    /// Impulse on the body [N s, world].
    impulse: Vec3,
}

/// Memory that is reused in every step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    impacts: Vec<Impact>,
    bodies: Vec<u32>,
    bonds: bonds::Scratch,
}

impl Scratch {
    /// The impulses on one body.
    fn impacts_of(&self, body: u32) -> &[Impact] {
        let first = self.impacts.partition_point(|b| b.body < body);
        let end = self.impacts.partition_point(|b| b.body <= body);
        &self.impacts[first..end]
    }
}

impl World {
    /// Breaks overloaded joints, bonds and bodies. `dt`: length of the step [s].
    pub(super) fn break_bodies(&mut self, dt: f32) {
        if !self.tables.breakage.any() {
            return;
        }
        let mut scratch = core::mem::take(&mut self.breaking);
        self.gather_impacts(&mut scratch.impacts);
        self.break_glue(&mut scratch, dt);
        self.fracture_bodies(&mut scratch);
        self.breaking = scratch;
    }

    fn gather_impacts(&self, impacts: &mut Vec<Impact>) {
        impacts.clear();
        let (bodies, contacts) = (&self.tables.bodies, &self.tables.contacts);
        for g in self.scratch.given().filter(|g| g.asked) {
            // Contacts of bodies put aside in this step no longer exist.
            if let Some(contact) = contacts.get(g.contact) {
                let pressed: f32 = g.points.iter().sum();
                let rub = g.push - contact.normal * pressed;
                add_impacts(bodies, g.contact, contact, &g.points, rub, impacts);
            }
        }
        // The order of blocks depends on the number of workers.
        impacts.sort_unstable_by_key(|b| (b.body, b.contact, b.place));
    }
}

/// Adds the impulses of a contact on each of its breakable bodies. Friction acts at the center of
/// pressure.
fn add_impacts(
    bodies: &Bodies,
    row: u32,
    c: &Contact,
    points: &[f32; 4],
    rub: Vec3,
    impacts: &mut Vec<Impact>,
) {
    let count = usize::from(c.count.min(4));
    let total = points[..count].iter().fold(0.0, |sum, p| sum + p);
    #[expect(clippy::cast_precision_loss, reason = "at most 4")]
    let even = 1.0 / count.max(1) as f32;
    for (side, body) in [c.body_a, c.body_b].into_iter().enumerate() {
        if !bodies.at(body).record.breaks || bodies.at(body).out {
            continue;
        }
        let (shape, other) = if side == 0 { (c.shape_a, c.body_b) } else { (c.shape_b, c.body_a) };
        for (place, (p, pressed)) in (0_u8..).zip(c.points().iter().zip(points)) {
            let share = if total > 0.0 { pressed / total } else { even };
            let on_b = c.normal * *pressed + rub * share;
            let (arm, impulse) = if side == 0 { (p.r_a, -on_b) } else { (c.r_b(p), on_b) };
            if impulse != Vec3::ZERO {
                impacts.push(Impact { body, contact: row, place, shape, other, arm, impulse });
            }
        }
    }
}
