//! Contact search of particles: finds shapes near a particle or on its path.

use fearless_simd::dispatch;

use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, vec3};
use crate::geometry::boxes::Ray;
use crate::geometry::cast;
use crate::geometry::nearest::nearest;
use crate::state::bodies::Bodies;
use crate::state::bounds::Bounds;
use crate::state::particles::Particle;
use crate::state::shapes::{ShapeRow, Shapes};
use crate::step::context::StepContext;

/// True if the particle moves in this step.
pub(crate) const fn moves(particle: &Particle) -> bool {
    !particle.frozen && !particle.faulted
}

/// Maximum number of shapes that a particle meets in a step; the nearest ones count.
pub(super) const MAX: usize = 6;

/// Distance around a slow particle within which static shapes are searched [m], so that later steps
/// need no search.
const SEARCH_DISTANCE: f32 = 0.25;

/// A shape near a particle, or on its path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Line of the particle.
    pub(crate) solver_row: u32,
    pub(crate) shape: u32,
    pub(crate) body: u32,
    /// Unit, from the shape to the particle [world].
    pub(crate) n: Vec3,
    /// Contact position relative to the body's center of mass [m, world].
    pub(crate) r: Vec3,
    /// Separation of the surfaces along the normal [m].
    pub(crate) separation: f32,
    /// Velocity of the surface there, for bodies that cannot be pushed and for belts [m/s].
    pub(crate) drift: Vec3,
    pub(crate) friction: f32,
    pub(crate) restitution: f32,
    /// The body is dynamic and awake.
    pub(crate) pushes: bool,
    /// The body is dynamic and asleep.
    pub(crate) asleep: bool,
    /// The particle is too slow to wake a body.
    pub(crate) rests: bool,
}

const NOWHERE: Meeting = Meeting {
    solver_row: 0,
    shape: 0,
    body: 0,
    n: Vec3::Y,
    r: Vec3::ZERO,
    separation: 0.0,
    drift: Vec3::ZERO,
    friction: 0.0,
    restitution: 0.0,
    pushes: false,
    asleep: false,
    rests: false,
};

/// Shapes that a particle meets, in the order of their rows.
#[derive(Clone, Debug)]
pub(crate) struct Near {
    list: [Meeting; MAX],
    count: usize,
    /// Minimum distance of a static shape from the particle's center, up to the search distance
    /// [m].
    clear: f32,
}

impl Default for Near {
    fn default() -> Self {
        Self { list: [NOWHERE; MAX], count: 0, clear: 0.0 }
    }
}

impl Near {
    pub(crate) fn meetings(&self) -> &[Meeting] {
        &self.list[..self.count]
    }

    fn add(&mut self, meeting: Meeting) {
        if self.count < MAX {
            self.list[self.count] = meeting;
            self.count += 1;
            return;
        }
        // The farthest shape is dropped, among equals the one with the higher row, for any order of
        // arrival.
        let later = |a: &Meeting, b: &Meeting| {
            a.separation > b.separation || (a.separation >= b.separation && a.shape > b.shape)
        };
        let mut last = 0;
        for i in 1..MAX {
            if later(&self.list[i], &self.list[last]) {
                last = i;
            }
        }
        if later(&self.list[last], &meeting) {
            self.list[last] = meeting;
        }
    }
}

/// Tables that the search needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around<'a> {
    pub(crate) ctx: &'a StepContext,
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    pub(crate) bounds: &'a Bounds,
    /// Positions of particles, by solver row.
    pub(crate) x: &'a [[f32; 4]],
}

fn point(place: &[f32; 4]) -> Vec3 {
    vec3(place[0], place[1], place[2])
}

impl Around<'_> {
    /// Finds shapes that the particle meets on its path. `held`: the body that it is attached to,
    /// which it does not meet.
    pub(crate) fn look(
        &self,
        solver_row: u32,
        place: &[f32; 4],
        particle: &mut Particle,
        displacement: Vec3,
        held: Option<u32>,
        near: &mut Near,
    ) {
        near.count = 0;
        let (x, radius) = (point(place), place[3]);
        let length = displacement.length();
        if !length.is_finite() || length > 1.0e9 {
            return;
        }
        let reach = length + radius + self.ctx.margin;
        let seeker = Seeker { solver_row, x, radius, displacement, held };
        if particle.room <= reach {
            let ahead =
                if particle.still_time > 0.0 { 0.0 } else { SEARCH_DISTANCE * self.ctx.length };
            near.clear = reach + ahead;
            let bounds = Aabb::new(x, x).grown(near.clear);
            dispatch!(self.ctx.level, simd => {
                let _ = simd;
                self.bounds.fixed.query_inline(&bounds, |row| {
                    self.meet(&seeker, particle, row, near);
                    true
                });
            });
            particle.room = near.clear;
        }
        if self.bounds.moving.len() > 0 {
            let end = x + displacement;
            let bounds = Aabb::new(x.min(end), x.max(end)).grown(radius + self.ctx.margin);
            dispatch!(self.ctx.level, simd => {
                let _ = simd;
                self.bounds.moving.query_inline(&bounds, |row| {
                    self.meet(&seeker, particle, row, near);
                    true
                });
            });
        }
        near.list[..near.count].sort_unstable_by_key(|m| m.shape);
    }

    fn meet(&self, seeker: &Seeker, particle: &Particle, row: u32, near: &mut Near) {
        let shape = self.shapes.at(row);
        let skipped = shape.sensor || seeker.held == Some(shape.body);
        if skipped || !particle.filter.collides_with(shape.filter) {
            return;
        }
        let body = self.bodies.at(shape.body);
        let (pose, margin) = (shape.placed(body), self.ctx.margin);
        let p = pose.local_point(seeker.x);
        // The shape moves too, so the relative displacement counts.
        let dt = self.ctx.dt;
        let displacement = seeker.displacement - body.velocity_at(seeker.x - body.center) * dt;
        let length = displacement.length();
        let reach = seeker.radius + margin + length;
        let Some(found) = nearest(&shape.solid, p, reach.max(near.clear)) else { return };
        if shape.fixed {
            near.clear = near.clear.min(found.distance.max(0.0));
        }
        let (n, separation) = if found.distance <= seeker.radius + margin {
            (pose.direction(found.normal), found.distance - seeker.radius)
        } else if found.distance <= reach {
            // A distant shape is met where the path leads, not at its nearest point: otherwise a
            // particle that flies past would meet a wall that is not there.
            let ahead = 1.0 + (seeker.radius + margin) / length;
            let ray = pose.local_direction(displacement * ahead);
            let Some(hit) = cast::ray(&shape.solid, p, ray, 1.0) else { return };
            let n = pose.direction(hit.normal);
            (n, -n.dot(displacement * (ahead * hit.fraction)) - seeker.radius)
        } else {
            return;
        };
        let r = seeker.x - n * (separation + seeker.radius) - body.center;
        near.add(self.meeting(seeker, particle, row, shape, n, r, separation));
    }

    fn meeting(
        &self,
        seeker: &Seeker,
        particle: &Particle,
        row: u32,
        shape: &ShapeRow,
        n: Vec3,
        r: Vec3,
        separation: f32,
    ) -> Meeting {
        let body = self.bodies.at(shape.body);
        let dynamic = body.is_dynamic();
        let mut drift = if dynamic { Vec3::ZERO } else { body.velocity_at(r) };
        if shape.is_belt() {
            let pose = shape.placed(body);
            let at = pose.local_point(body.center + r);
            drift += pose.direction(shape.surface_velocity + shape.surface_spin.cross(at));
        }
        let (a, b) = (&particle.material, &shape.material);
        let rub = a.friction_combine.apply(b.friction_combine, a.friction, b.friction);
        let bounce =
            a.restitution_combine.apply(b.restitution_combine, a.restitution, b.restitution);
        Meeting {
            solver_row: seeker.solver_row,
            shape: row,
            body: shape.body,
            n,
            r,
            separation,
            drift,
            friction: rub,
            restitution: bounce,
            pushes: dynamic && body.active(),
            asleep: dynamic && !body.active() && !body.out,
            rests: particle.still_time > 0.0,
        }
    }

    /// True if an awake body is near a frozen particle.
    pub(crate) fn is_disturbed(&self, solver_row: u32, particle: &Particle) -> bool {
        let place = &self.x[solver_row as usize];
        let (x, radius) = (point(place), place[3]);
        let mut disturbed = false;
        let bounds = Aabb::new(x, x).grown(radius + self.ctx.margin);
        self.bounds.moving.query(&bounds, |row| {
            let shape = self.shapes.at(row);
            let body = self.bodies.at(shape.body);
            if body.active() && !shape.sensor && particle.filter.collides_with(shape.filter) {
                let p = shape.placed(body).local_point(x);
                disturbed |= nearest(&shape.solid, p, radius + self.ctx.margin).is_some();
            }
            !disturbed
        });
        disturbed
    }

    /// First crossing of the path from `x` with the surface of a static shape: part of the path,
    /// and the normal there.
    pub(crate) fn crossing(
        &self,
        x: Vec3,
        displacement: Vec3,
        particle: &Particle,
        held: Option<u32>,
    ) -> Option<(f32, Vec3)> {
        let mut best: Option<(f32, u32, Vec3)> = None;
        self.bounds.fixed.ray(&Ray::new(x, displacement), 1.0, |row| {
            let shape = self.shapes.at(row);
            let limit = best.map_or(1.0, |b| b.0);
            let skipped = shape.sensor || held == Some(shape.body);
            if skipped || !particle.filter.collides_with(shape.filter) {
                return limit;
            }
            let pose = shape.placed(self.bodies.at(shape.body));
            let (o, d) = (pose.local_point(x), pose.local_direction(displacement));
            if let Some(hit) = cast::ray(&shape.solid, o, d, limit)
                && best.is_none_or(|(f, r, _)| (hit.fraction, row) < (f, r))
            {
                best = Some((hit.fraction, row, pose.direction(hit.normal)));
            }
            best.map_or(1.0, |b| b.0)
        });
        best.map(|(fraction, _, normal)| (fraction, normal))
    }
}

/// A particle that searches for shapes.
struct Seeker {
    solver_row: u32,
    x: Vec3,
    radius: f32,
    displacement: Vec3,
    held: Option<u32>,
}
