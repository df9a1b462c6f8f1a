//! Random articulations with contacts: no fault, no energy from nothing.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "random numbers of a few digits"
)]

use drystone::articulation::{ArticulationDef, LinkDef, TreeDef, TreeJoint};
use drystone::{BodyDef, ShapeDef, World};

/// A generator of numbers (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    fn axis(&mut self) -> [f64; 3] {
        loop {
            let v = [0; 3].map(|_| self.within(-1.0, 1.0));
            let square = v.iter().map(|x| x * x).sum::<f64>();
            if (0.01..1.0).contains(&square) {
                return v.map(|x| x / square.sqrt());
            }
        }
    }
}

/// A floating tree of 2 to 12 links: boxes, balls and capsules of 10 g to 10 kg.
fn random_tree(random: &mut Random, at: [f64; 3]) -> ArticulationDef {
    let count = 2 + random.below(11);
    let mut def = ArticulationDef::new(TreeDef::default());
    let mut sizes: Vec<[f64; 3]> = Vec::new();
    for i in 0..count {
        let half = [0; 3].map(|_| random.within(0.04, 0.2));
        let mass = 10.0_f64.powf(random.within(-2.0, 1.0));
        let third = mass / 3.0;
        let [x, y, z] = half.map(|h| h * h);
        let inertia = [third * (y + z), third * (x + z), third * (x + y), 0.0, 0.0, 0.0];
        let mut link = if i == 0 {
            LinkDef::floating().with_position(at)
        } else {
            let parent = random.below(i);
            let side = random.below(3);
            let sign = if random.next() < 0.5 { -1.0 } else { 1.0 };
            let mut place = [0.0; 3];
            place[side] = sign * (sizes[parent][side] + 0.02);
            let mut anchor = [0.0; 3];
            anchor[side] = -sign * (half[side] + 0.02);
            let origin: [f64; 3] = core::array::from_fn(|k| place[k] - anchor[k]);
            let mut link = LinkDef::on(parent).with_position(origin);
            let joints = 1 + random.below(2);
            for number in 0..joints {
                let mut joint = match random.below(4) {
                    0 if number == 0 => TreeJoint::ball(),
                    1 => TreeJoint::slide(random.axis()).with_range(-0.05, 0.05),
                    _ => {
                        let joint = TreeJoint::hinge(random.axis());
                        if random.next() < 0.5 { joint.with_range(-0.5, 0.7) } else { joint }
                    }
                };
                joint = joint.with_anchor(anchor);
                if random.next() < 0.3 {
                    joint = joint.with_damping(random.within(0.0, 1.0) * mass * 0.1);
                }
                if random.next() < 0.3 {
                    joint = joint.with_spring(random.within(0.0, 50.0) * mass, 0.0);
                }
                if random.next() < 0.3 {
                    joint = joint.with_armature(random.within(0.0, 0.01));
                }
                if random.next() < 0.2 {
                    joint = joint.with_friction(random.within(0.0, 0.5));
                }
                let is_ball = joint.kind == TreeJoint::ball().kind;
                link = link.with_joint(joint);
                if is_ball {
                    break;
                }
            }
            link
        };
        link = link.with_mass(mass, [0.0; 3], inertia);
        sizes.push(half);
        def.tree.links.push(link);
        let [hx, hy, hz] = half.map(|h| h as f32);
        let shape = match random.below(3) {
            0 => ShapeDef::sphere(hx.min(hy).min(hz)),
            1 => ShapeDef::capsule(hy, hx.min(hz)),
            _ => ShapeDef::box_half([hx, hy, hz]),
        };
        def = def.with_shape(i, shape);
    }
    def
}

fn energy(world: &World) -> f64 {
    let g = f64::from(world.config().gravity.length());
    let trees = world.articulations().map(|of| {
        let model = of.model();
        // Closing overlaps and limits that start violated lifts links and stretches springs.
        model.kinetic_energy() + model.potential_energy() - model.recovery_work()
    });
    let is_link = |id| world.articulations().any(|of| of.bodies().any(|body| body == id));
    let bodies = world.bodies().filter(|body| !is_link(body.id())).map(|body| {
        let height = f64::from(body.position().y);
        f64::from(body.kinetic_energy()) + g * f64::from(body.mass()) * height
    });
    trees.chain(bodies).sum()
}

#[test]
fn random_articulations_that_fall_gain_no_energy() {
    let mut worst = 0.0_f64;
    let mut gains = Vec::new();
    let count = std::env::var("TREES").map_or(12, |n| n.parse().unwrap());
    let first = std::env::var("FIRST").map_or(1, |n| n.parse().unwrap());
    for seed in first..first + count {
        let seed: u64 = seed;
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut world = World::default();
        let ground = ShapeDef::box_half([20.0, 0.5, 20.0]).with_position([0.0, -0.5, 0.0]);
        world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
        let hz = [30.0, 60.0, 120.0, 240.0][random.below(4)];
        for k in 0..1 + random.below(3) {
            let at = [random.within(-0.3, 0.3), 1.5 + 1.2 * k as f64, random.within(-0.3, 0.3)];
            let def = random_tree(&mut random, at);
            if let Err(e) = world.add_articulation(def) {
                eprintln!("seed {seed}: {e}");
            }
        }
        for k in 0..random.below(6) {
            let half = random.within(0.05, 0.2) as f32;
            let at = [
                random.within(-0.5, 0.5) as f32,
                0.3 + 0.5 * k as f32,
                random.within(-0.5, 0.5) as f32,
            ];
            let shape = ShapeDef::box_half([half; 3]);
            world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap();
        }
        let mut last = energy(&world);
        let start = last;
        let mut gain = 0.0;
        let mut at = 0;
        for step in 0..(4.0 * hz) as usize {
            world.step(1.0 / hz as f32);
            let faults = &world.events().faults;
            assert!(faults.is_empty(), "seed {seed} step {step}: {faults:?}");
            let now = energy(&world);
            if now - last > gain {
                (gain, at) = (now - last, step);
            }
            last = now;
        }
        let deepest = world
            .articulations()
            .flat_map(|of| of.bodies().collect::<Vec<_>>())
            .map(|id| world.body(id).unwrap().position().y)
            .fold(f32::INFINITY, f32::min);
        let part = gain / start.abs().max(1.0);
        gains.push((part, seed, at, hz, start, last, deepest));
        worst = worst.max(part);
    }
    gains.sort_by(|a, b| b.0.total_cmp(&a.0));
    for g in gains.iter().take(12) {
        eprintln!(
            "gain {:.4} seed {} step {} hz {} start {:.2} end {:.2} deepest {:.3}",
            g.0, g.1, g.2, g.3, g.4, g.5, g.6
        );
    }
    let low = gains.iter().filter(|g| g.6 < -0.01).count();
    eprintln!("below the floor: {low} of {}", gains.len());
    assert!(worst < 0.01, "{worst}");
}
