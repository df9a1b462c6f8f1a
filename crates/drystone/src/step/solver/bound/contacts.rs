//! Bounds the work of contacts: closing overlaps, springs that return energy, moving surfaces.

use super::{speed_of, speeds};
use crate::base::simd::wide::{LANES, Lanes, at};
use crate::step::solver::contact::block::ContactBlock;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver::work::Bound;
use crate::step::solver_body::three;

impl Solver<'_> {
    /// Speed of a contact's point along the normal before this substep's impulses, and the mean.
    fn point_speeds(
        &self,
        block: &ContactBlock,
        [line_a, line_b]: [u32; 2],
        (lane, j): (usize, usize),
    ) -> [f64; 2] {
        let (n, point) = (at(&block.n, lane), &block.points[j]);
        let along = |v: [f32; 4], w: [f32; 4], scale: f32, turn: &[Lanes; 3]| {
            f64::from(n.dot(three(v)) * scale + at(turn, lane).dot(three(w)))
        };
        speeds(|after| {
            let of = |solver_row: u32, scale: f32, turn: &[Lanes; 3]| {
                if solver_row == 0 {
                    return 0.0;
                }
                let now = self.body.solver_bodies.read(solver_row as usize);
                let [v, w] =
                    [self.body.aux.read(solver_row as usize).before(), [now.v, now.w]][after];
                along(v, w, scale, turn)
            };
            of(line_b, block.beta[lane], &point.b) - of(line_a, block.alpha[lane], &point.a)
        })
    }

    pub(super) fn ask_contacts(&self, group: &Group, elapsed: f32, bounds: &mut [Bound]) {
        for batch in &self.plan.contacts.batches[group.contacts.clone()] {
            let softness = if batch.fixed { &self.ctx.soft_fixed } else { &self.ctx.soft };
            for i in batch.blocks.clone() {
                let block = self.contact.blocks.read(i);
                let extra =
                    if self.contact.has_extras { Some(self.contact.extras.read(i)) } else { None };
                for lane in 0..LANES {
                    let a = if batch.fixed { 0 } else { block.row_a[lane] };
                    let ends = [a, block.row_b[lane]];
                    let Some(bound) = self.over_lane(ends, group, bounds) else { continue };
                    let [a, b] =
                        ends.map(|solver_row| *self.body.solver_bodies.read(solver_row as usize));
                    let n = at(&block.n, lane);
                    let moved = n.dot(three(b.x)) * block.beta[lane]
                        - n.dot(three(a.x)) * block.alpha[lane];
                    for (j, p) in block.points.iter().take(usize::from(block.count)).enumerate() {
                        let drift = extra.map_or(0.0, |extra| extra.drift[j][lane]);
                        let turned = at(&p.b, lane).dot(three(b.t))
                            - if batch.fixed { 0.0 } else { at(&p.a, lane).dot(three(a.t)) };
                        let depth = -(p.s0[lane] + moved + turned + drift * elapsed);
                        let (impulse, depth) =
                            (f64::from(p.impulse[lane]), f64::from(depth.max(0.0)));
                        if let Some(square) =
                            extra.and_then(|extra| extra.spring(lane, self.ctx.inv_h))
                        {
                            let speeds = self.point_speeds(block, ends, (lane, j));
                            let spring = (0.0, square, f64::from(p.mass[lane]));
                            bound.release(impulse, speeds, spring, (depth, self.ctx.inv_h.into()));
                        } else {
                            let speed = speed_of(
                                depth,
                                softness.rate,
                                (&self.ctx.caps, self.ctx.push_speed, 0),
                            );
                            bound.close(impulse, speed, 0);
                        }
                        bound.drive(p.impulse[lane], f64::from(drift));
                    }
                    for (k, rub) in block.friction.iter().enumerate() {
                        let drift = extra.map_or(0.0, |extra| extra.drift_t[k][lane]);
                        bound.drive(rub[lane], f64::from(drift));
                    }
                }
            }
        }
    }
}
