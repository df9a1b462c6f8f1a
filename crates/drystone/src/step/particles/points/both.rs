//! Both sides of a block of particle contacts, in lanes.

use crate::base::simd::wide::{LANES, Vec3w, Wide, gather, gather4, load, splat};
use crate::step::particles::links::write_ends;
use crate::step::particles::pace::Form;
use crate::step::particles::points::PointBlock;
use crate::step::particles::rows::Ground;
use crate::step::solver_body::{Velocity, load_velocity, read_lanes, store_velocity};
use fearless_simd::Simd;

/// The particles and bodies of a block.
pub(super) struct Both<S: Simd> {
    /// Velocities of the particles, and their displacements as far as known.
    pub(crate) v: Vec3w<S>,
    pub(crate) x: Vec3w<S>,
    pub(crate) w: Wide<S>,
    moves: Wide<S>,
    /// v̂ and ŵ of the bodies.
    pub(crate) body: Velocity<S>,
    pub(crate) alpha: Wide<S>,
}

#[inline(always)]
pub(super) fn read<S: Simd>(
    simd: S,
    block: &PointBlock,
    ground: &Ground<'_>,
    pushes: bool,
) -> Both<S> {
    let states = read_lanes(&ground.particles, &block.solver_row);
    let (mut v, mut x) = ([&states[0].v; LANES], [&states[0].x; LANES]);
    for lane in 1..LANES {
        (v[lane], x[lane]) = (&states[lane].v, &states[lane].x);
    }
    let [vx, vy, vz, w] = gather4(simd, v);
    let [xx, xy, xz, moves] = gather4(simd, x);
    let (mut v, x) = (Vec3w { x: vx, y: vy, z: vz }, Vec3w { x: xx, y: xy, z: xz });
    if ground.pace.form == Form::Verlet {
        let before = gather(simd, read_lanes(&ground.before, &block.solver_row));
        v = (x - before) * splat(simd, ground.pace.inv_h);
    }
    let (mut body, mut alpha) = (Velocity::zero(simd), splat(simd, 0.0));
    if pushes {
        body = load_velocity(simd, &ground.bodies, &block.body);
        alpha = load(simd, &block.alpha);
    }
    Both { v, x, w, moves, body, alpha }
}

impl<S: Simd> Both<S> {
    /// Velocity of the particles relative to the surfaces, along a direction.
    #[inline(always)]
    pub(crate) fn along(
        &self,
        simd: S,
        block: &PointBlock,
        (axis, d): (usize, Vec3w<S>),
    ) -> Wide<S> {
        let turn = Vec3w::load(simd, &block.turns[axis]);
        d.dot(self.v - self.body.v * self.alpha)
            - turn.dot(self.body.w)
            - load(simd, &block.drift[axis])
    }

    /// Applies to the bodies their part of impulses `p` on the particles along a direction.
    #[inline(always)]
    pub(crate) fn push_body(
        &mut self,
        simd: S,
        block: &PointBlock,
        (axis, d): (usize, Vec3w<S>),
        p: Wide<S>,
    ) {
        self.body.v = self.body.v - d * (p * self.alpha);
        self.body.w = self.body.w - Vec3w::load(simd, &block.turns[axis]) * p;
    }

    /// Applies impulses `p` along a direction.
    #[inline(always)]
    pub(crate) fn push(
        &mut self,
        simd: S,
        block: &PointBlock,
        ground: &Ground<'_>,
        (axis, d): (usize, Vec3w<S>),
        p: Wide<S>,
        pushes: bool,
    ) {
        let dv = d * (p * self.w);
        self.v = self.v + dv;
        if ground.pace.form == Form::Verlet {
            self.x = self.x + dv * splat(simd, ground.pace.h);
        }
        if pushes {
            self.push_body(simd, block, (axis, d), p);
        }
    }

    #[inline(always)]
    pub(crate) fn write(self, simd: S, block: &PointBlock, ground: &Ground<'_>, pushes: bool) {
        let is_verlet = ground.pace.form == Form::Verlet;
        let (row, last) = if is_verlet { (self.x, self.moves) } else { (self.v, self.w) };
        write_ends(&ground.particles, &block.solver_row, row, last, is_verlet);
        if pushes {
            store_velocity(simd, &ground.bodies, &block.body, self.body);
        }
    }
}
