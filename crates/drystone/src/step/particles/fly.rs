//! Free particles: computes their whole step at once.
//!
//! A free particle meets only immovable shapes, so it needs no substeps: it follows its parabola,
//! deflected by planes. For one plane the bounce is exact: the time of the hit follows from a
//! quadratic, and the rest of the step comes after it.

use super::meet::{Around, Meeting, Near};
use crate::base::limits;
use crate::base::math::{Vec3, greater, vec3};
use crate::state::particles::{Particle, ParticleState};
use crate::step::context::StepContext;
use crate::step::context::softness::decay;

/// Maximum number of rounds over the planes; each reduces the overlap with two of them by the
/// square of their cosine.
const MAX_ROUNDS: usize = 40;

/// Remaining overlap at which the rounds end [m].
const LEFT: f32 = 1.0e-6;

/// Motion in a step without obstacles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// Acceleration [m/s²].
    acceleration: Vec3,
    /// Velocity at the end [m/s].
    v: Vec3,
    /// Displacement [m].
    pub(super) displacement: Vec3,
}

/// The free path of a particle.
pub(super) fn path(ctx: &StepContext, particle: &Particle, state: &ParticleState) -> Path {
    let start = state.velocity();
    if state.inverse_mass() <= 0.0 {
        return Path { acceleration: Vec3::ZERO, v: start, displacement: start * ctx.dt };
    }
    let acceleration = ctx.gravity * particle.gravity_scale;
    let v = (start + acceleration * ctx.dt) * decay(particle.damping, ctx.dt);
    Path { acceleration, v, displacement: (start + v) * (0.5 * ctx.dt) }
}

/// Moves a free particle; false if its state became non-finite, in which case the particle stops
/// where it was.
pub(super) fn fly(
    ctx: &StepContext,
    particle: &mut Particle,
    state: &mut ParticleState,
    place: &mut [f32; 4],
    path: &Path,
    near: &Near,
    around: &Around<'_>,
) -> bool {
    let x = vec3(place[0], place[1], place[2]);
    let (mut v, mut displacement) = (path.v, path.displacement);
    // A pinned particle moves with its velocity.
    if state.inverse_mass() > 0.0 && !near.meetings().is_empty() {
        (v, displacement) = deflected(ctx, state.velocity(), path, near.meetings());
        // This path differs from the one along which shapes were searched.
        if displacement.length() > place[3]
            && let Some((part, n)) = around.crossing(x, displacement, particle, None)
        {
            let slower = n * v.dot(n);
            displacement = displacement * part + n * (0.5 * place[3]);
            v = if v.dot(n) < 0.0 { v - slower } else { v };
            particle.room = 0.0;
        }
    }
    let end = x + displacement;
    if !is_computable(end, v) {
        put_aside(particle, state);
        return false;
    }
    *place = [end.x, end.y, end.z, place[3]];
    state.set_velocity(v);
    particle.room -= displacement.length();
    true
}

/// False if a position [m] or a velocity [m/s] is out of range for the computations.
pub(super) fn is_computable(x: Vec3, v: Vec3) -> bool {
    x.is_below(limits::POSITION_KEPT.maximum) && v.is_below(limits::SPEED_KEPT.maximum)
}

/// Stops a particle whose state became non-finite.
pub(super) fn put_aside(particle: &mut Particle, state: &mut ParticleState) {
    particle.faulted = true;
    state.set_velocity(Vec3::ZERO);
    state.x = ParticleState::OUT;
}

/// Velocity at the end, and displacement, with planes in the path.
fn deflected(ctx: &StepContext, start: Vec3, path: &Path, meetings: &[Meeting]) -> (Vec3, Vec3) {
    let dt = ctx.dt;
    let (mut v, mut displacement) = (path.v, path.displacement);
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for m in meetings {
            let (n, s) = (m.n, m.separation);
            let moved = n.dot(displacement - m.drift * dt);
            let from = n.dot(start - m.drift);
            if s + moved >= -LEFT * ctx.length {
                continue;
            }
            let end = n.dot(v - m.drift);
            let (to_s, to_v) = landing(ctx, s, from, n.dot(path.acceleration), m.restitution);
            if to_s - s - moved <= 0.0 && to_v <= end {
                continue;
            }
            changed = true;
            let push = greater(to_v - end, 0.0);
            displacement += n * (to_s - s - moved);
            v += n * push;
            // Coulomb friction: the surface removes velocity along it, up to μ times the normal
            // change.
            let slide = v - m.drift - n * n.dot(v - m.drift);
            let speed = slide.length();
            if speed > 0.0 && push > 0.0 {
                let taken = slide * ((m.friction * push).min(speed) / speed);
                v -= taken;
                // The force is constant over the step, or for as long as the particle slid.
                let was = displacement - m.drift * dt;
                let along = was - n * n.dot(was);
                let far = along.length();
                let back = (0.5 * m.friction * push * dt).min(far);
                if far > 0.0 {
                    displacement -= along * (back / far);
                }
            }
        }
        if !changed {
            break;
        }
    }
    (v, displacement)
}

/// Distance and velocity along the normal at the end of a step in which the plane is met: `s` away
/// [m], with velocity `v` and acceleration `a` along the normal.
fn landing(ctx: &StepContext, s: f32, v: f32, a: f32, restitution: f32) -> (f32, f32) {
    let dt = ctx.dt;
    if s < 0.0 {
        // Overlap: out, no faster than the push speed, and at no velocity.
        return ((s + ctx.push_speed * dt).min(0.0), 0.0);
    }
    // A speed that forces alone produce in a step is that of a particle at rest, not an impact.
    let slow = greater(ctx.restitution_speed, 2.0 * a.abs() * dt);
    if restitution <= 0.0 || !(-v > slow) {
        return (0.0, 0.0);
    }
    // s + v t + a t²/2 = 0; v² - 2 a s is the square of the speed there.
    let hit = greater(v * v - 2.0 * a * s, 0.0).sqrt();
    let rest = greater(dt - 2.0 * s / (hit - v), 0.0);
    let back = restitution * hit;
    let (to_s, to_v) = (back * rest + 0.5 * a * rest * rest, back + a * rest);
    if to_s < 0.0 { (0.0, 0.0) } else { (to_s, to_v) }
}
