//! Queries with ordinary and extreme arguments.

use drystone::geometry::Aabb;
use drystone::impact::{ImpactBody, ImpactSurface};
use drystone::math::Sym3;
use drystone::{Filter, Pose, Vec3, vec3};

use super::draw::Draw;
use crate::op::{Form, Op, QueryCall};

impl Draw {
    /// Adds a query, or a collision of two shapes without a world.
    pub(super) fn query(&mut self) {
        let filter = self.filter();
        let at = Pose { position: self.place(), rotation: self.rng.rotation() };
        let call = match self.rng.below(9) {
            0 | 1 => QueryCall::Ray(at.position, self.way(), filter),
            2 => {
                let half = self.way() * 0.5;
                let half = vec3(half.x.abs(), half.y.abs(), half.z.abs());
                QueryCall::OverlapBounds(Aabb::new(at.position - half, at.position + half), filter)
            }
            3 => QueryCall::OverlapPoint(at.position, filter),
            4 => QueryCall::OverlapShape(self.probe(), at, filter),
            5 => {
                let turn = if self.rng.chance(0.5) { Vec3::ZERO } else { self.turn() };
                QueryCall::CastShape(self.probe(), at, [self.way(), turn], filter)
            }
            6 => {
                let reach = self.rng.pick(&[0.0, 0.1, 1.0, 10.0, 1.0e4]);
                QueryCall::Nearest(self.probe(), at, reach, Filter::default())
            }
            7 => {
                let other = Pose { position: at.position + self.way(), rotation: at.rotation };
                let other_form = if self.rng.chance(0.2) {
                    Form::Plain(drystone::Shape::half_space(self.rng.direction(), 0.0))
                } else {
                    self.probe()
                };
                let reach = self.rng.pick(&[0.0, 0.1, 10.0, 1.0e4]);
                QueryCall::Pair(Box::new([(self.probe(), at), (other_form, other)]), reach)
            }
            _ => {
                let bodies = Box::new([self.impact_body(), self.impact_body()]);
                let surface = ImpactSurface {
                    normal: self.rng.direction(),
                    restitution: self.rng.pick(&[0.0, 0.5, 1.0]),
                    static_friction: 0.6,
                    kinetic_friction: self.rng.pick(&[0.0, 0.5, 0.6]),
                };
                self.ops.push(Op::Impact(bodies, surface));
                return;
            }
        };
        self.ops.push(Op::Query(call));
    }

    fn impact_body(&mut self) -> ImpactBody {
        if self.rng.chance(0.2) {
            return ImpactBody::FIXED;
        }
        let d = Vec3::splat(self.rng.scale(0.1, 10.0));
        ImpactBody {
            mass: self.rng.scale(0.1, 100.0),
            inertia: Sym3::rotated_diagonal(self.rng.rotation(), d),
            linear_velocity: self.speed(),
            angular_velocity: self.spin(),
            arm: self.offset(1.0),
        }
    }

    fn place(&mut self) -> Vec3 {
        if self.rng.chance(0.05) {
            return self.rng.vector(1.0e6);
        }
        vec3(0.0, self.size, 0.0) + self.offset(5.0)
    }

    fn way(&mut self) -> Vec3 {
        let factor = self.rng.pick(&[0.0, 1.0e-3, 1.0, 10.0, 1.0e4]);
        self.offset(factor)
    }

    fn turn(&mut self) -> Vec3 {
        let angle = self.rng.pick(&[1.0e-3, 0.5, 3.0, 30.0]);
        self.rng.direction() * angle
    }

    fn probe(&mut self) -> Form {
        if self.rng.chance(0.1) {
            let radius = self.rng.pick(&[1.0e-5, 1.0e-3, 1.0e3]);
            return Form::Plain(drystone::Shape::sphere(radius));
        }
        self.convex().0
    }
}
