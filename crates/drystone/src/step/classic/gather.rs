//! Gathers bodies, contacts and joints into rows of the classic methods, in the method's order.

use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::state::bodies::body::Body;
use crate::state::colors::Colors;
use crate::state::contacts::{Contact, Contacts, Traits};
use crate::state::def::method::Settings;
use crate::state::def::options::Damping;
use crate::state::joints::{JointModel as JointLink, Joints};
use crate::state::shapes::Shapes;
use crate::step::classic::Scratch;
use crate::step::classic::couplings::Coupled;
use crate::step::classic::joints::JointRow;
use crate::step::classic::rows::{Mover, Pair, PairPoint};
use crate::step::classic::six_dof::Axes;
use crate::step::context::StepContext;
use crate::step::context::softness::{decay, exact_decay};
use crate::step::solver::body::integrate;
use crate::step::solver::body::state::BodyState;
use crate::step::solver::input::Input;

impl Scratch {
    /// Makes the movers of awake bodies; writes their rows to `row_of`.
    pub(crate) fn gather_bodies(
        &mut self,
        ctx: &StepContext,
        settings: &Settings,
        input: Input<'_>,
        row_of: &mut [u32],
    ) {
        self.movers.clear();
        self.bodies.clear();
        self.movers.push(Mover { decay_v: 1.0, decay_w: 1.0, ..Mover::default() });
        self.bodies.push(u32::MAX);
        for row in &input.bodies.awake {
            row_of[*row as usize] =
                u32::try_from(self.movers.len()).expect("fewer than 2^32 bodies");
            self.movers.push(mover_of(ctx, settings, input.bodies.at(*row)));
            self.bodies.push(*row);
        }
    }

    /// Gathers the pairs of all colors, and the order in which they are swept.
    pub(crate) fn gather_pairs(
        &mut self,
        ctx: &StepContext,
        input: Input<'_>,
        contacts: &Contacts,
        colors: &Colors,
        row_of: &[u32],
    ) {
        self.pairs.clear();
        self.sequence.pairs.clear();
        for coloring in [&colors.contacts, &colors.contacts_fixed] {
            for color in &coloring.colors {
                for row in &color.members {
                    let number = u32::try_from(self.pairs.len()).expect("fewer than 2^32 contacts");
                    let contact = contacts.at(*row);
                    self.pairs.push(pair_of(ctx, input, *row, contact, row_of));
                    self.sequence.pairs.push(number);
                }
            }
        }
        let all = self.sequence.pairs.len();
        self.sequence.ends.clear();
        self.sequence.ends.push(all);
    }

    pub(crate) fn gather_links(
        &mut self,
        ctx: &StepContext,
        input: Input<'_>,
        joints: &Joints,
        colors: &Colors,
        row_of: &[u32],
    ) {
        self.links.clear();
        for coloring in [&colors.joints, &colors.joints_fixed] {
            for row in coloring.colors.iter().flat_map(|color| &color.members) {
                let joint = joints.at(*row);
                let (a, b) = (input.bodies.at(joint.body_a), input.bodies.at(joint.body_b));
                let (r_a, r_b) =
                    (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
                self.links.push(JointRow {
                    row: *row,
                    a: row_of[joint.body_a as usize],
                    b: row_of[joint.body_b as usize],
                    r_a,
                    r_b,
                    gap: (b.center - a.center) + (r_b - r_a),
                    kind: joint.model.kind(),
                    axes: match &joint.model {
                        JointLink::SixDof(six_dof) => Some(Axes::new(six_dof, a, b)),
                        _ => None,
                    },
                    coupled: Coupled::new(joint, joints, input.bodies, row_of),
                    impulse: joint.impulse * ctx.impulse_scale,
                });
            }
        }
    }
}

fn mover_of(ctx: &StepContext, settings: &Settings, body: &Body) -> Mover {
    let still = Mover { v: body.v, w: body.w, decay_v: 1.0, decay_w: 1.0, ..Mover::default() };
    if !body.is_dynamic() {
        return still;
    }
    let (root, _) = integrate::roots_of_inertia(body, body.rotation);
    // The square of the root of the inverse inertia.
    let column = |axis: Vec3| root.mul(root.mul(axis));
    let (x, y, z) = (column(Vec3::X), column(Vec3::Y), column(Vec3::Z));
    let inv_inertia = Sym3 { xx: x.x, yy: y.y, zz: z.z, xy: y.x, xz: z.x, yz: z.y };
    let mut inv_mass = Vec3::splat(1.0 / body.inertia.mass);
    let mut add_v = integrate::acceleration(ctx, body) * ctx.h;
    for i in 0..3 {
        if body.inertia.locks.linear[i] {
            (inv_mass[i], add_v[i]) = (0.0, 0.0);
        }
    }
    let left = |rate: f32| match settings.damping {
        Damping::Exponential => exact_decay(rate, ctx.h),
        Damping::Nothing => 1.0,
        Damping::Own | Damping::Pade => decay(rate, ctx.h),
    };
    #[expect(clippy::cast_precision_loss, reason = "at most 256 substeps")]
    let spin = integrate::gyration(ctx, body, &BodyState::of(body)) * (1.0 / ctx.substeps as f32);
    Mover {
        inv_mass,
        inv_inertia,
        add_v,
        add_w: inv_inertia.mul(body.forces.torque + body.forces.step_torque) * ctx.h + spin,
        decay_v: left(body.forces.linear_damping),
        decay_w: left(body.forces.angular_damping),
        ..still
    }
}

pub(super) fn pair_of(
    ctx: &StepContext,
    input: Input<'_>,
    row: u32,
    c: &Contact,
    row_of: &[u32],
) -> Pair {
    let mut pair = Pair {
        contact: row,
        a: row_of[c.body_a as usize],
        b: row_of[c.body_b as usize],
        normal: c.normal,
        friction: [c.friction, c.friction * c.kinetic],
        restitution: c.restitution,
        rolling: c.rolling,
        spinning: c.spinning,
        count: c.count,
        ..Pair::default()
    };
    let total: f32 = c.points().iter().map(|p| p.impulse).sum();
    let scale = ctx.impulse_scale;
    for (to, p) in pair.points.iter_mut().zip(c.points()) {
        // Friction is stored as one impulse of the pair: each point gets a share in proportion to
        // its load.
        let share = if total > 0.0 { p.impulse / total } else { 0.0 };
        let rub = c.tangent_impulse - c.normal * c.normal.dot(c.tangent_impulse);
        *to = PairPoint {
            r_a: p.r_a,
            r_b: c.r_b(p),
            s0: p.separation,
            press: p.impulse * scale,
            rub: rub * (share * scale),
            arrival: 0.0,
        };
    }
    if c.traits.any(Traits::BELT) {
        let (a, b) = (input.bodies.at(c.body_a), input.bodies.at(c.body_b));
        let middle = c.points().iter().fold(Vec3::ZERO, |sum, p| sum + p.r_a)
            * (1.0 / f32::from(c.count.max(1)));
        let belt = |body: &Body, shape: u32, r: Vec3, shapes: &Shapes| {
            let shape = shapes.at(shape);
            let pose = shape.placed(body);
            let arm = r - (pose.position - body.center);
            let v = pose.direction(shape.surface_velocity)
                + pose.direction(shape.surface_spin).cross(arm);
            v - c.normal * c.normal.dot(v)
        };
        let shapes = input.shapes;
        pair.belt =
            belt(b, c.shape_b, middle - c.offset, shapes) - belt(a, c.shape_a, middle, shapes);
    }
    pair
}
