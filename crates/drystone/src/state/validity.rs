//! Consistency check of tables from outside. Every referenced row must exist, every list must match
//! its rows, and constraints of one color must share no body. Stages rely on this without a check.

mod colors;
mod contacts;
mod particles;

use core::num::NonZeroU32;

use self::colors::find_colors;
use self::contacts::check_contacts;
use self::particles::check_particles;
use super::bodies::body::MassSource;
use super::bodies::stillness::Stillness;
use super::bodies::{Bodies, NONE};
use super::breakage::Breakage;
use super::coupling::check_axis;
use super::def::{BodyKind, MassDef, shape_suits};
use super::islands::Islands;
use super::joints::{JointModel, Joints};
use super::shapes::{ShapeRow, Shapes};
use super::tables::Tables;
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::slot_map::SlotMap;
use crate::geometry::mass::MassProperties;

/// Description of an inconsistency.
pub(crate) type Invalid = &'static str;

type Check = Result<(), Invalid>;

fn holds(is_valid: bool, what: Invalid) -> Check {
    if is_valid { Ok(()) } else { Err(what) }
}

fn at_least_zero(numbers: &[f32]) -> bool {
    numbers.iter().all(|x| *x >= 0.0)
}

fn all_finite<'a>(numbers: impl IntoIterator<Item = &'a f32>) -> bool {
    numbers.into_iter().all(|x| x.is_finite())
}

/// Allowed masses [kg] and moments of inertia [kg m²] of bodies and of pieces of bodies.
const KEPT_MASSES: core::ops::RangeInclusive<f32> = 1.0e-30..=1.0e16;
const KEPT_MOMENTS: core::ops::RangeInclusive<f32> = 1.0e-36..=1.0e31;

/// True for a unit vector, up to the rounding of the vector and of a rotation.
fn is_direction(n: Vec3) -> bool {
    (n.length_squared() - 1.0).abs() < 1.0e-3
}

/// True for a position that a step keeps. Shapes and anchors are nearer.
fn is_place(x: Vec3) -> bool {
    x.is_finite() && x.abs().max_element() <= limits::POSITION_KEPT.maximum
}

fn is_pose(pose: &Pose) -> bool {
    is_place(pose.position) && pose.rotation.is_normalized()
}

/// Rows that have been visited.
struct Seen(Vec<bool>);

impl Seen {
    fn none_of(count: usize) -> Self {
        Self(vec![false; count])
    }

    /// Marks a row; false if the row does not exist or was marked before.
    fn is_new(&mut self, row: u32) -> bool {
        let place = self.0.get_mut(row as usize);
        place.is_some_and(|seen| !core::mem::replace(seen, true))
    }
}

impl<Id, T> SlotMap<Id, T> {
    fn check(&self) -> Check {
        let (values, generations, free, len) = self.parts();
        holds(values.len() == generations.len(), "rows have not one generation each")?;
        holds(values.iter().flatten().count() == len, "a count of rows is wrong")?;
        let mut seen = Seen::none_of(values.len());
        for row in free {
            let is_free = seen.is_new(*row) && values[*row as usize].is_none();
            holds(is_free, "a free row is not free")?;
        }
        let used_up = values.len() - len - free.len();
        let last = generations.iter().filter(|g| **g == NonZeroU32::MAX).count();
        holds(used_up <= last, "a row is neither free nor in use")
    }
}

impl Tables {
    /// Checks everything, and rebuilds derived data that was not saved: the lists of colors and the
    /// set of pairs with a contact.
    ///
    /// # Errors
    /// The first inconsistency.
    pub(crate) fn check(&mut self) -> Check {
        self.config.validate().map_err(|_| "the configuration is out of range")?;
        // These counters keep counting.
        let far =
            self.steps.max(self.bounds.fixed_changes).max(u64::from(self.particles.threads) << 32);
        holds(far < 1 << 62, "a count is at its end")?;
        self.bodies.rows.check()?;
        self.shapes.rows.check()?;
        self.joints.rows.check()?;
        check_bodies(&self.bodies)?;
        check_shapes(&self.shapes, &self.bodies)?;
        check_joints(&self.joints, &self.bodies)?;
        self.articulations.rows.check()?;
        self.articulations.find_links();
        holds(self.articulations.are_valid(&self.bodies), "an articulation has other bodies")?;
        check_contacts(&self.contacts, &self.bodies, &self.shapes)?;
        holds(self.contacts.find_pairs(), "two contacts are of one pair")?;
        check_islands(&self.islands, &self.bodies)?;
        find_colors(self)?;
        self.check_bounds()?;
        check_particles(&self.particles, &self.bodies)?;
        check_breakage(&self.breakage, &self.bodies, &self.shapes)
    }

    /// Checks that the trees contain every shape at its stored place, and nothing else.
    fn check_bounds(&self) -> Check {
        let Self { shapes, bounds, bodies, .. } = self;
        for (tree, fixed) in [(&bounds.fixed, true), (&bounds.moving, false)] {
            holds(tree.is_valid(), "a tree of boxes is broken")?;
            let is_right = |row: u32| {
                let shape = shapes.rows.at(row);
                shape.is_some_and(|s| s.fixed == fixed && s.is_in(bodies.at(s.body)))
            };
            holds(tree.items().all(is_right), "a tree has a box of no shape")?;
            // Shapes that are out of the world are in no tree.
            let is_in = |s: &ShapeRow| s.is_in(bodies.at(s.body));
            let count = shapes.rows.iter().filter(|(_, s)| s.fixed == fixed && is_in(s)).count();
            holds(tree.len() == count, "a shape is in no tree")?;
        }
        Ok(())
    }
}

fn check_bodies(bodies: &Bodies) -> Check {
    let slots = bodies.rows.slot_count();
    holds(bodies.tracks.len() == slots, "bodies have not one track each")?;
    let known = &bodies.stillness;
    let known = known.len() == slots && known.iter().all(Stillness::is_valid);
    holds(known, "what is known of the rest of bodies is wrong")?;
    let mut seen = Seen::none_of(slots);
    for (place, row) in (0..).zip(&bodies.awake) {
        let body = bodies.rows.at(*row);
        let is_right =
            body.is_some_and(|b| b.awake_row == place && b.kind != BodyKind::Static && !b.out);
        holds(seen.is_new(*row) && is_right, "a body that is awake is not")?;
    }
    let active = bodies.rows.iter().filter(|(_, b)| b.active()).count();
    holds(active == bodies.awake.len(), "a body that is awake is not listed")?;
    for (_, b) in bodies.rows.iter() {
        let placed =
            is_place(b.center) && b.rotation.is_normalized() && is_place(b.inertia.local_center);
        holds(placed, "a body is nowhere")?;
        let pushed = [b.forces.step_force, b.forces.step_torque, b.forces.force, b.forces.torque];
        let (v, w) = (b.v.abs().max_element(), b.w.abs().max_element());
        // A body whose center of mass changes while it rotates may be faster than the limit that a
        // step keeps.
        let kept = limits::SPEED_KEPT.maximum;
        let slow = v <= kept * limits::POSITION.maximum && w <= kept;
        let moved = [b.v, b.w, b.history.w_low];
        let finite = slow && moved.iter().chain(&pushed).all(|v| v.is_finite());
        holds(
            finite && all_finite(&[b.history.load, b.history.inertia_factor]),
            "a body moves by no number",
        )?;
        let moments = [b.inertia.moments.x, b.inertia.moments.y, b.inertia.moments.z];
        let is_moment = |m: &f32| *m == 0.0 || KEPT_MOMENTS.contains(m);
        let is_mass = b.inertia.mass == 0.0 || KEPT_MASSES.contains(&b.inertia.mass);
        let has_mass =
            is_mass && moments.iter().all(is_moment) && b.inertia.principal.is_normalized();
        let is_given = match b.inertia.source {
            MassSource::Mass(mass) => KEPT_MASSES.contains(&mass),
            MassSource::Shapes | MassSource::Exact => true,
        };
        let has_mass = has_mass && is_given;
        holds(
            has_mass && (b.inertia.mass > 0.0) == b.is_dynamic(),
            "a body has no mass that can be",
        )?;
        let damping = [b.forces.linear_damping, b.forces.angular_damping];
        let damped = damping.iter().all(|rate| limits::DAMPING.admits(*rate));
        let is_valid = damped
            && at_least_zero(&[b.extent, b.inner, b.sleep.still_time, b.history.last_h])
            && all_finite(&[b.sleep.still_time, b.sleep.speed])
            && (b.extent.is_finite() || !b.is_dynamic())
            && limits::GRAVITY_SCALE.admits(b.forces.gravity_scale);
        holds(is_valid, "a number of a body is out of range")?;
        holds(
            b.out == (b.record.faulted || b.record.disabled),
            "a body is neither in the world nor out of it",
        )?;
    }
    let lives = |row: u32| bodies.rows.at(row).is_some();
    let known = bodies.strangers.iter().all(|(a, b)| a < b && lives(*a) && lives(*b));
    holds(known, "a pair of bodies that never collide is none")?;
    check_given(bodies)
}

/// Checks that exactly the bodies with an exact mass have an entry for it.
fn check_given(bodies: &Bodies) -> Check {
    let exact = bodies.rows.iter().filter(|(_, b)| b.inertia.source == MassSource::Exact).count();
    holds(exact == bodies.given.len(), "masses that were given are not those of bodies")?;
    for (row, given) in &bodies.given {
        let is_exact = bodies.rows.at(*row).is_some_and(|b| b.inertia.source == MassSource::Exact);
        let MassProperties { mass, center, inertia } = *given;
        let is_valid = MassDef::Exact { mass, center, inertia }.validate().is_ok();
        holds(is_exact && is_valid, "a mass that was given is of no body")?;
    }
    Ok(())
}

fn check_shapes(shapes: &Shapes, bodies: &Bodies) -> Check {
    let mut seen = Seen::none_of(shapes.rows.slot_count());
    for (id, body) in bodies.rows.iter() {
        for row in &body.ties.shapes {
            let shape = shapes.rows.at(*row).filter(|s| s.body == id.index());
            let Some(shape) = shape.filter(|_| seen.is_new(*row)) else {
                return Err("a body names a shape that is not its own");
            };
            shape_suits(body.kind, &shape.shape)
                .map_err(|_| "a body has a shape that it cannot have")?;
            let fixed = body.kind == BodyKind::Static;
            holds(shape.fixed == fixed, "a shape is in the wrong tree")?;
        }
    }
    let fronts = shapes.fronts_hold() && shapes.one_way.values().all(|front| is_direction(*front));
    holds(fronts, "a surface has no front that can be")?;
    let ruled = shapes.rules.iter().all(|rule| rule.validate().is_ok());
    holds(ruled, "a rule of surfaces is out of range")?;
    let lives = |row: u32| bodies.rows.at(row).is_some();
    let ruled = shapes
        .between
        .iter()
        .all(|((a, b), rule)| a < b && lives(*a) && lives(*b) && rule.validate().is_ok());
    holds(ruled, "a rule of two bodies is of none")?;
    holds(shapes.counts_hold(), "a count of shapes that report is wrong")?;
    for (id, s) in shapes.rows.iter() {
        holds(seen.0[id.index() as usize], "a shape is of no body")?;
        s.shape.validate().map_err(|_| "a shape is out of range")?;
        s.material.validate().map_err(|_| "a material is out of range")?;
        s.reports.unpacked().validate().map_err(|_| "a hit speed is out of range")?;
        holds(is_pose(&s.centered) && is_pose(&s.local), "a shape is nowhere")?;
        let runs = s.surface_velocity.is_finite() && s.surface_spin.is_finite();
        holds(
            runs && limits::DENSITY.admits(s.density) && at_least_zero(&[s.rolling_radius]),
            "a number of a shape is out of range",
        )?;
        holds(!s.flat || s.shape.is_flat(), "a shape is not as flat as it says")?;
    }
    Ok(())
}

fn check_joints(joints: &Joints, bodies: &Bodies) -> Check {
    let mut named = vec![0_u32; joints.rows.slot_count()];
    for (id, body) in bodies.rows.iter() {
        for row in &body.ties.joints {
            let of =
                |body| joints.rows.at(*row).is_some_and(|j| j.body_a == body || j.body_b == body);
            holds(of(id.index()), "a body names a joint that is not its own")?;
            named[*row as usize] += 1;
        }
    }
    for (id, joint) in joints.rows.iter() {
        let [a, b] = [joint.body_a, joint.body_b].map(|row| bodies.rows.at(row));
        let twice = named[id.index() as usize] == 2 && joint.body_a != joint.body_b;
        holds(a.is_some() && b.is_some() && twice, "a joint is not between two bodies")?;
        holds(is_place(joint.anchor_a) && is_place(joint.anchor_b), "a joint is nowhere")?;
        holds(joint.is_finite(), "a joint has an impulse that is no number")?;
        let is_link = matches!(joint.model, JointModel::Link);
        let is_right = is_link || joint.model.kind().validate().is_ok();
        holds(is_right, "a joint is out of range")?;
        if let Some(strength) = &joint.strength {
            strength.validate().map_err(|_| "the strength of a joint is out of range")?;
        }
        if let JointModel::Coupling(coupling) = &joint.model {
            let def = &coupling.def;
            for (id, axis) in [(def.joint_a, def.axis_a), (def.joint_b, def.axis_b)] {
                let other = joints.rows.row(id).map(|row| &joints.at(row).model);
                let Some(JointModel::SixDof(six_dof)) = other else {
                    return Err("a coupling is of no joint");
                };
                check_axis("", &six_dof.def, axis)
                    .map_err(|_| "a coupling is of an axis that is held")?;
            }
        }
    }
    let breakable = joints.rows.iter().filter(|(_, j)| j.strength.is_some()).count();
    holds(breakable == joints.breakable, "a count of joints is wrong")
}

fn check_islands(islands: &Islands, bodies: &Bodies) -> Check {
    let mut seen = Seen::none_of(bodies.rows.slot_count());
    let mut members = 0;
    for (number, island) in (0..).zip(&islands.rows) {
        let (mut at, mut previous, mut len) = (island.first, NONE, 0);
        while at != NONE {
            let body = bodies.rows.at(at).filter(|b| b.is_dynamic() && b.sleep.island == number);
            let Some(body) = body.filter(|b| b.sleep.previous == previous && seen.is_new(at))
            else {
                return Err("a body is not of its island");
            };
            (previous, at, len) = (at, body.sleep.next, len + 1);
        }
        holds(previous == island.last() && len == island.len, "an island miscounts its bodies")?;
        members += len as usize;
    }
    let dynamic =
        bodies.rows.iter().filter(|(_, b)| b.is_dynamic() || b.sleep.island != NONE).count();
    holds(dynamic == members, "a body is of no island")?;
    let mut seen = Seen::none_of(islands.rows.len());
    let is_free = |row: &u32| seen.is_new(*row) && islands.rows[*row as usize].len == 0;
    holds(islands.free().iter().all(is_free), "a free island is not free")?;
    let empty = islands.rows.iter().filter(|i| i.len == 0).count();
    holds(empty == islands.free().len(), "an island is empty")?;
    holds(islands.knows_loose(), "an island that was cut is not there")
}

fn check_breakage(breakage: &Breakage, bodies: &Bodies, shapes: &Shapes) -> Check {
    let Breakage { glued, fractures, pieces } = breakage;
    let breaks = |row: u32| bodies.rows.at(row).is_some_and(|b| b.record.breaks == b.is_dynamic());
    for (row, glue) in glued {
        let is_piece = |s: &ShapeRow| s.body == *row && !s.sensor && s.density > 0.0;
        let own = |shape: &u32| shapes.rows.at(*shape).is_some_and(is_piece);
        holds(breaks(*row) && glue.pieces.iter().all(own), "glue holds what is not there")?;
        let count = glue.pieces.len();
        let bond = |b: &super::breakage::GlueBond| {
            let placed = is_place(b.point) && is_direction(b.normal) && b.area > 0.0;
            b.pieces.iter().all(|p| *p < count)
                && b.area.is_finite()
                && placed
                && b.load.is_finite()
                && b.strength.validate().is_ok()
        };
        holds(glue.bonds.iter().all(bond), "a bond holds what is not there")?;
        let known = |list: &Vec<[f64; 6]>| {
            let finite = list.iter().flatten().all(|x| x.is_finite());
            finite && (list.is_empty() || list.len() == count)
        };
        holds(known(&glue.give) && known(&glue.lack), "glue is solved in part")?;
    }
    for (row, fracture) in fractures {
        fracture.validate().map_err(|_| "a fracture is out of range")?;
        holds(breaks(*row), "a fracture is of no body")?;
    }
    let count = bodies.rows.iter().filter(|(_, b)| b.record.is_piece).count();
    holds(count == *pieces, "a count of pieces is wrong")
}
