//! Energy and momentum of a world, in double precision, since users compare differences of sums
//! over thousands of bodies.

use super::springs;
use crate::base::double::DVec3;
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::query::particles::particle_sums;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::joints::{Joint, JointModel};
use crate::state::tables::Tables;

/// Mechanical energy of all dynamic bodies and particles [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Energy {
    /// Kinetic energy of the centers' motion: ½ m v².
    pub linear: f64,
    /// Kinetic energy of rotation: ½ ω · I ω, and that of the rotors of articulations.
    pub angular: f64,
    /// Potential energy in the world's gravity, zero at the origin.
    pub potential: f64,
    /// Elastic energy in the springs of joints, of articulations and of links between particles:
    /// ½ k x². Energy in the compliance of contacts is not included.
    pub elastic: f64,
}

impl Energy {
    /// Linear and angular kinetic energy together [J].
    #[must_use]
    pub fn kinetic(&self) -> f64 {
        self.linear + self.angular
    }

    /// Potential and elastic energy together [J].
    #[must_use]
    pub fn stored(&self) -> f64 {
        self.potential + self.elastic
    }

    /// All energy [J].
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic() + self.stored()
    }

    pub(crate) fn of(tables: &Tables) -> Self {
        let mut sum = Self::default();
        let gravity = DVec3::from(tables.config.gravity);
        for body in dynamic(tables) {
            let (mass, v) = (f64::from(body.inertia.mass), DVec3::from(body.v));
            let scale = f64::from(body.forces.gravity_scale);
            sum.potential -= mass * scale * gravity.dot(DVec3::from(body.center));
            // Most bodies of a large world are at rest.
            if body.v != Vec3::ZERO || body.w != Vec3::ZERO {
                sum.linear += 0.5 * mass * v.dot(v);
                let turn = (body.rotation * body.inertia.principal).unrotate(body.w);
                let (turn, moments) = (DVec3::from(turn), DVec3::from(body.inertia.moments));
                let DVec3 { x, y, z } = turn;
                sum.angular += 0.5 * DVec3 { x: x * x, y: y * y, z: z * z }.dot(moments);
            }
        }
        for (_, joint) in tables.joints.rows.iter() {
            // Joints far out of place, on bodies with almost no inertia, give no finite energy.
            let energy = elastic(joint, &tables.bodies);
            sum.elastic += if energy.is_finite() { energy } else { 0.0 };
        }
        for (_, articulation) in tables.articulations.rows.iter() {
            sum.angular += articulation.model.rotor_energy();
            sum.elastic += articulation.model.spring_energy();
        }
        if !tables.particles.is_empty() {
            let particles = particle_sums(tables);
            sum.linear += particles.linear;
            sum.potential += particles.potential;
            sum.elastic += particles.elastic;
        }
        sum
    }
}

/// Mass and momentum of all dynamic bodies and of particles that are not pinned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Momentum {
    /// Sum of masses [kg].
    pub mass: f64,
    /// Center of mass of all of them [m, world]; the origin if there are none.
    pub center_of_mass: Vec3,
    /// Linear momentum [kg m/s, world].
    pub linear: Vec3,
    /// Angular momentum about the world's origin [kg m²/s, world].
    pub about_origin: Vec3,
    /// Angular momentum about [`Self::center_of_mass`] [kg m²/s, world].
    pub about_center: Vec3,
}

impl Momentum {
    pub(crate) fn of(tables: &Tables) -> Self {
        let (mut mass, mut first) = (0.0, DVec3::ZERO);
        let (mut linear, mut origin) = (DVec3::ZERO, DVec3::ZERO);
        for body in dynamic(tables) {
            let (m, c) = (f64::from(body.inertia.mass), DVec3::from(body.center));
            let p = DVec3::from(body.v) * m;
            mass += m;
            first = first + c * m;
            linear = linear + p;
            origin = origin + c.cross(p) + spin(body);
        }
        for (m, c, v) in particles(tables) {
            let p = v * m;
            mass += m;
            first = first + c * m;
            linear = linear + p;
            origin = origin + c.cross(p);
        }
        let center = if mass > 0.0 { first * (1.0 / mass) } else { DVec3::ZERO };
        // A sum of its own: far from the origin a difference of the other two would lose its
        // digits.
        let mut own = DVec3::ZERO;
        for body in dynamic(tables) {
            let arm = DVec3::from(body.center) - center;
            own = own + arm.cross(DVec3::from(body.v) * f64::from(body.inertia.mass)) + spin(body);
        }
        for (m, c, v) in particles(tables) {
            own = own + (c - center).cross(v * m);
        }
        Self {
            mass,
            center_of_mass: center.single().bounded(),
            linear: linear.single().bounded(),
            about_origin: origin.single().bounded(),
            about_center: own.single().bounded(),
        }
    }
}

/// All dynamic bodies, island by island. Every dynamic body is in an island; a large world has too
/// many static bodies to walk over.
fn dynamic(tables: &Tables) -> impl Iterator<Item = &Body> {
    let all = tables.islands.rows.iter().flat_map(|island| island.bodies(&tables.bodies));
    all.filter(|body| !body.record.disabled)
}

/// Mass [kg], position [m] and velocity [m/s] of the particles that are not pinned.
fn particles(tables: &Tables) -> impl Iterator<Item = (f64, DVec3, DVec3)> {
    let table = &tables.particles;
    let free = table.rows.iter().filter(|(_, particle)| !particle.pinned);
    free.map(|(id, particle)| {
        let row = id.index() + 1;
        let v = table.states[row as usize].velocity();
        (f64::from(particle.mass), DVec3::from(table.position(row)), DVec3::from(v))
    })
}

/// Angular momentum I ω [kg m²/s, world].
fn spin(body: &Body) -> DVec3 {
    let axes = body.rotation * body.inertia.principal;
    DVec3::from(axes.rotate(axes.unrotate(body.w).mul_each(body.inertia.moments)))
}

/// ½ k x² of a joint's spring [J]. A frequency gives its stiffness: k = (2πf)² over the current
/// inverse effective mass of the two bodies along it.
fn elastic(joint: &Joint, bodies: &Bodies) -> f64 {
    if let JointModel::SixDof(six_dof) = &joint.model {
        return springs::elastic(joint, six_dof, bodies);
    }
    let JointModel::Distance { spring: Some(spring), .. } = &joint.model else { return 0.0 };
    let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
    let (ra, rb) = (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
    let gap = (b.center - a.center) + (rb - ra);
    let n = gap.normalize_or(Vec3::Y);
    let give = f64::from(response(a, ra, n)) + f64::from(response(b, rb, n));
    if give <= 0.0 {
        return 0.0;
    }
    let stretch = f64::from(gap.length() - spring.rest_length);
    let omega = 2.0 * core::f64::consts::PI * f64::from(spring.hertz);
    0.5 * omega * omega / give * stretch * stretch
}

/// Speed along `n` of the point at `r` per unit of impulse there [1/kg].
fn response(body: &Body, r: Vec3, n: Vec3) -> f32 {
    if !body.is_dynamic() {
        return 0.0;
    }
    let lever = r.cross(n);
    1.0 / body.inertia.mass + lever.dot(inverse_inertia(body).mul(lever))
}

/// I⁻¹ over the unlocked rotation axes [1/(kg m²), world].
pub(super) fn inverse_inertia(body: &Body) -> Sym3 {
    let axes = body.rotation * body.inertia.principal;
    let [x, y, z] = body.inertia.locks.angular;
    let m = body.inertia.moments;
    if !(x || y || z) || m.min_element() <= 0.0 {
        let each = |i: f32| if i > 0.0 { 1.0 / i } else { 0.0 };
        return Sym3::rotated_diagonal(axes, Vec3 { x: each(m.x), y: each(m.y), z: each(m.z) });
    }
    // Removes locked axes from the matrix and inverts the rest.
    let mut inertia = Sym3::rotated_diagonal(axes, m);
    if x {
        (inertia.xx, inertia.xy, inertia.xz) = (1.0, 0.0, 0.0);
    }
    if y {
        (inertia.yy, inertia.xy, inertia.yz) = (1.0, 0.0, 0.0);
    }
    if z {
        (inertia.zz, inertia.xz, inertia.yz) = (1.0, 0.0, 0.0);
    }
    let mut inverse = inertia.inverse().unwrap_or_default();
    for (locked, place) in [(x, &mut inverse.xx), (y, &mut inverse.yy), (z, &mut inverse.zz)] {
        if locked {
            *place = 0.0;
        }
    }
    inverse
}
