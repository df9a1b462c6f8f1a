//! Twins: the same world under conditions that must not change the result. Only motions that are
//! not chaotic are compared: stacks, blocks that fall upright, sliding bodies.

use drystone::{BodyKind, Mesh, Pose, Quat, Vec3, vec3};

use super::facts::Facts;
use super::floors::{FIRST_BODY, Floor, with_floor};
use super::watch::{Watched, follow};
use crate::finding::{Findings, Kind};
use crate::op::{Form, Op, Program};

/// A condition that must not change the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Twin {
    /// On another floor of the same surface.
    Floor(Floor),
    /// Rotated about the vertical.
    Turned,
    /// Mirrored in z.
    Mirrored,
    /// Translated.
    Moved,
    /// Scaled by this factor, with time scaled like the duration of falls.
    Scaled(f32),
    /// In steps of half the length.
    Halved,
    /// With bodies added in the opposite order.
    Reordered,
    /// Without sleep.
    Sleepless,
    /// Restored from its own snapshot in the middle.
    Restored,
}

impl Twin {
    const ALL: [Self; 17] = [
        Self::Floor(Floor::HalfSpace),
        Self::Floor(Floor::Box),
        Self::Floor(Floor::Mesh),
        Self::Floor(Floor::Pieces),
        Self::Floor(Floor::Cracked),
        Self::Floor(Floor::Tiles),
        Self::Floor(Floor::Hulls),
        Self::Floor(Floor::Kinematic),
        Self::Turned,
        Self::Mirrored,
        Self::Moved,
        Self::Scaled(0.1),
        Self::Scaled(10.0),
        Self::Halved,
        Self::Reordered,
        Self::Sleepless,
        Self::Restored,
    ];

    pub(super) fn name(self) -> String {
        match self {
            Self::Floor(floor) => format!("on another floor, {floor:?}"),
            Self::Scaled(s) => format!("{s} times as large"),
            _ => format!("{self:?}").to_lowercase(),
        }
    }
}

/// Angle of [`Twin::Turned`] [rad], and displacement of [`Twin::Moved`] in lengths of the largest
/// body.
const ANGLE: f32 = 0.7;
const AWAY: f32 = 100.0;

/// Allowed relative difference in time and position.
const PART: f32 = 0.05;

/// Runs the comparable twins, and returns the number of steps.
pub(super) fn compare(program: &Program, base: &Watched, findings: &mut Findings) -> u64 {
    let facts = Facts::of(program);
    // Restored worlds must continue with the same bits, even if chaotic.
    let can_compare = facts.stands || facts.lands_flat || facts.glider.or(facts.slider).is_some();
    if base.is_cut {
        return 0;
    }
    let mut steps = 0;
    for twin in Twin::ALL {
        if twin != Twin::Restored && !can_compare {
            continue;
        }
        let Some(other) = of(program, &facts, twin) else { continue };
        let watched = follow(&other, twin == Twin::Restored);
        steps += watched.steps;
        if watched.is_cut || watched.refused > base.refused {
            continue;
        }
        if let Some(detail) = difference(program, &facts, [base, &watched], twin) {
            findings.add(Kind::Twin, twin.name(), detail, 0);
        }
    }
    steps
}

/// The program of a twin.
fn of(program: &Program, facts: &Facts, twin: Twin) -> Option<Program> {
    let mut other = program.clone();
    match twin {
        Twin::Floor(floor) => return with_floor(program, floor),
        Twin::Restored => {}
        Twin::Sleepless => other.config.sleep.enabled = false,
        Twin::Halved => {
            for op in &mut other.ops {
                if let Op::Step(dt, count) = op {
                    (*dt, *count) = (*dt * 0.5, *count * 2);
                }
            }
        }
        Twin::Reordered => {
            let is_body = |op: &Op| matches!(op, Op::AddBody(plan) if plan.label >= FIRST_BODY);
            let mut bodies: Vec<Op> = other.ops.iter().filter(|op| is_body(op)).cloned().collect();
            if bodies.len() < 2 || facts.has_calls {
                return None;
            }
            for op in other.ops.iter_mut().filter(|op| is_body(op)) {
                if let Some(last) = bodies.pop() {
                    *op = last;
                }
            }
        }
        Twin::Turned | Twin::Mirrored | Twin::Moved | Twin::Scaled(_) => {
            let large = facts.movers().map(|(_, m)| m.large).fold(0.0, f32::max);
            let scale = if let Twin::Scaled(s) = twin { s } else { 1.0 };
            let is_sane = (1.0e-3..200.0).contains(&(2.0 * large * scale));
            if !facts.jointed.is_empty() || facts.has_calls || !is_sane {
                return None;
            }
            for op in &mut other.ops {
                change(op, twin, large)?;
            }
        }
    }
    Some(other)
}

/// Changes one operation for a rotated, mirrored, translated or scaled world.
fn change(op: &mut Op, twin: Twin, large: f32) -> Option<()> {
    match op {
        Op::Step(dt, _) => {
            if let Twin::Scaled(s) = twin {
                *dt *= s.sqrt();
            }
            Some(())
        }
        Op::AddBody(plan) => {
            let def = &mut plan.def;
            let place = place(def.position, def.rotation, twin, large);
            (def.position, def.rotation) = (place.position, place.rotation);
            let (v, w) = (def.linear_velocity, def.angular_velocity);
            (def.linear_velocity, def.angular_velocity) = match twin {
                Twin::Turned => (turn().rotate(v), turn().rotate(w)),
                Twin::Mirrored => (vec3(v.x, v.y, -v.z), vec3(-w.x, -w.y, w.z)),
                Twin::Scaled(s) => (v * s.sqrt(), w * (1.0 / s.sqrt())),
                _ => (v, w),
            };
            for shape in &mut plan.shapes {
                if let Twin::Scaled(s) = twin {
                    shape.def.pose.position *= s;
                    scale(&mut shape.form, s);
                }
                if twin == Twin::Mirrored {
                    let pose = &mut shape.def.pose;
                    *pose = self::place(pose.position, pose.rotation, twin, large);
                    mirror(&mut shape.form)?;
                }
            }
            Some(())
        }
        _ => None,
    }
}

fn turn() -> Quat {
    Quat::from_axis_angle(Vec3::Y, ANGLE)
}

/// The pose in a twin.
fn place(p: Vec3, q: Quat, twin: Twin, large: f32) -> Pose {
    match twin {
        Twin::Turned => Pose::new(turn().rotate(p), (turn() * q).normalized()),
        Twin::Mirrored => Pose::new(vec3(p.x, p.y, -p.z), Quat::new(-q.x, -q.y, q.z, q.w)),
        Twin::Moved => Pose::new(p + vec3(AWAY, 0.0, -AWAY) * large, q),
        Twin::Scaled(s) => Pose::new(p * s, q),
        _ => Pose::new(p, q),
    }
}

fn scale(form: &mut Form, s: f32) {
    if let Form::Plain(shape) = form {
        scale_plain(shape, s);
    }
    if let Form::Hull(points) | Form::Mesh(points, _) = form {
        points.iter_mut().for_each(|p| *p *= s);
    }
}

fn scale_plain(shape: &mut drystone::Shape, s: f32) {
    use drystone::Shape;
    match shape {
        Shape::Sphere { radius } => *radius *= s,
        Shape::Box { half_extents } => *half_extents *= s,
        Shape::Capsule { half_height, radius } | Shape::Cylinder { half_height, radius } => {
            (*half_height, *radius) = (*half_height * s, *radius * s);
        }
        Shape::Cone { half_height, radius_bottom, radius_top } => {
            *half_height *= s;
            (*radius_bottom, *radius_top) = (*radius_bottom * s, *radius_top * s);
        }
        Shape::HalfSpace { offset, .. } => *offset *= s,
        _ => {}
    }
}

/// Mirrors shapes given by corners; all others are their own mirror images.
fn mirror(form: &mut Form) -> Option<()> {
    match form {
        Form::Plain(_) => {}
        Form::Hull(points) => points.iter_mut().for_each(|p| p.z = -p.z),
        Form::Mesh(points, triangles) => {
            points.iter_mut().for_each(|p| p.z = -p.z);
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
            Mesh::new(points.clone(), triangles.clone()).ok()?;
        }
    }
    Some(())
}

/// The first difference between a world and its twin that exceeds its tolerance.
fn difference(
    program: &Program,
    facts: &Facts,
    [base, twin]: [&Watched; 2],
    how: Twin,
) -> Option<String> {
    if how == Twin::Restored {
        return (base.hash != twin.hash).then(|| "goes on with other bits".to_owned());
    }
    let time = if let Twin::Scaled(s) = how { s.sqrt() } else { 1.0 };
    let length = if let Twin::Scaled(s) = how { s } else { 1.0 };
    let longest =
        program.ops.iter().filter_map(|op| if let Op::Step(dt, _) = op { Some(*dt) } else { None });
    let dt = longest.fold(0.0, f32::max);
    let large = facts.movers().map(|(_, m)| m.large).fold(0.0, f32::max);
    #[expect(clippy::cast_precision_loss, reason = "at most some tens")]
    let bodies = facts.bodies.len() as f32;
    for (label, made) in facts.movers().filter(|(_, m)| m.kind == BodyKind::Dynamic) {
        let (Some(a), Some(b)) = (base.ends.get(&label), twin.ends.get(&label)) else { continue };
        // A contact is detected at the end of its step, so two steps are allowed. Contacts from the
        // start say nothing.
        let falls = facts.lands_flat && !facts.stands && a.touched.is_some_and(|t| t > 5.0 * dt);
        if let (Some(a), Some(b), true) = (a.touched, b.touched, falls)
            && (a * time - b).abs() > 2.5 * dt * time + PART * a * time
        {
            return Some(format!("body {label} touches at {} s, not at {a} s", b / time));
        }
        if facts.has_slid_off(a.pose.position, made.large) {
            continue;
        }
        let there = place(a.pose.position, a.pose.rotation, how, large);
        // A sliding body stops within a step, at most; friction agrees to some percent.
        let way = (a.pose.position - made.position).length();
        let v = made.linear_velocity.length();
        let offset = 2.0 * program.config.contact.rest_offset * bodies;
        let allowed = (0.1 * made.large + PART * way + 2.0 * v * dt) * length + offset;
        let off = (there.position - b.pose.position).length();
        if off > allowed && facts.glider != Some(label) {
            return Some(format!("body {label} ends {off} m away, allowed {allowed} m"));
        }
        if facts.glider == Some(label) && off > allowed.max(0.1 * way * length) {
            return Some(format!("body {label} glides {off} m away, allowed {allowed} m"));
        }
    }
    let is_off = |w: &Watched| {
        let all =
            facts.movers().filter_map(|(label, made)| Some((w.ends.get(&label)?, made.large)));
        all.into_iter()
            .any(|(end, large)| facts.has_slid_off(end.pose.position * (1.0 / length), large))
    };
    // Behavior at a floor's edge is not that of its surface, and a translated twin is translated
    // relative to its floor too.
    if how != Twin::Moved && (is_off(base) || is_off(twin)) {
        return None;
    }
    let rest = |w: &Watched| w.rest_since.is_some();
    if rest(base) != rest(twin) && facts.must_rest() {
        let one = if rest(base) { "it does not come to rest" } else { "it comes to rest" };
        return Some(one.to_owned());
    }
    if facts.stands || how == Twin::Sleepless {
        // The settling of a stack in place is not visible; sleep counts as rest.
        return None;
    }
    let (Some(a), Some(b)) = (base.rest_since, twin.rest_since) else { return None };
    // Slow rocking after a landing is damped per step: a tenth of the time, and the duration of a
    // fall by its own length.
    let fall = (2.0 * large / facts.gravity.max(1.0e-6)).sqrt();
    let allowed = (0.1 * a + fall + 10.0 * dt) * time;
    let off = (a * time - b).abs();
    (off > allowed).then(|| format!("rests after {} s, not {a} s", b / time))
}

impl Facts {
    /// Whether a body is over the edge of the floor.
    fn has_slid_off(&self, p: Vec3, large: f32) -> bool {
        self.half_floor.is_none_or(|half| p.x.abs().max(p.z.abs()) + large > half)
    }
}
