//! A crane: a trolley, a rope that is reeled, and a magnet that takes two crates and puts them down elsewhere.

use drystone::joint::{Fixed, Rope};
use drystone::{BodyDef, BodyId, JointDef, JointId, ShapeDef, World};

type Outcome = Result<(), Box<dyn std::error::Error>>;

const DT: f32 = 1.0 / 60.0;

struct Crane {
    world: World,
    trolley: BodyId,
    rope: JointId,
    length: f32,
    /// Of the rope [m/s]; it changes by 1 m/s².
    speed: f32,
}

impl Crane {
    /// Drives the trolley and lets the rope out, each at its speed [m/s], for some time [s].
    fn run(&mut self, drive: f32, out: f32, seconds: f32) -> Outcome {
        for _ in 0..(0..10_000).take_while(|k| *k as f32 * DT < seconds - 0.5 * DT).count() {
            self.speed += (out - self.speed).clamp(-DT, DT);
            self.length += self.speed * DT;
            self.world.joint_mut(self.rope).ok_or("no rope")?.set_lengths(0.0, self.length)?;
            let mut trolley = self.world.body_mut(self.trolley).ok_or("no trolley")?;
            trolley.set_linear_velocity([drive, 0.0, 0.0])?;
            self.world.step(DT);
        }
        Ok(())
    }

    fn damp(&mut self, body: BodyId, rate: f32) -> Outcome {
        Ok(self.world.body_mut(body).ok_or("no body")?.set_damping(rate, rate)?)
    }
}

fn main() -> Outcome {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let load = |y| BodyDef::dynamic().with_position([0.0, y, 0.0]).with_mass(400.0);
    let cube = ShapeDef::box_half([0.5; 3]);
    let low = world.add_body(load(0.5).with_shape(cube.clone()))?;
    let high = world.add_body(load(1.5).with_shape(cube))?;
    let trolley = world.add_body(BodyDef::kinematic().with_position([0.0, 8.0, 0.0]))?;
    let magnet = load(4.0).with_mass(50.0).with_shape(ShapeDef::cylinder(0.1, 0.3));
    let magnet = world.add_body(magnet)?;
    let rope =
        JointDef::new(trolley, magnet, Rope::new(3.9)).with_anchors([0.0; 3], [0.0, 0.1, 0.0]);
    let rope = world.add_joint(rope)?;
    let mut crane = Crane { world, trolley, rope, length: 3.9, speed: 0.0 };
    for (load, x) in [(high, 3.0), (low, 6.0)] {
        while crane.world.contacts_between(magnet, load).next().is_none() && crane.length < 8.0 {
            crane.run(0.0, 0.3, DT)?;
        }
        let at = crane.world.body(magnet).ok_or("no magnet")?.position();
        let weld = JointDef::new(magnet, load, Fixed::new()).at(at);
        let weld = crane.world.add_joint(weld)?;
        crane.run(0.0, -0.5, 5.0)?;
        crane.run(0.0, 0.0, 2.0)?;
        let pull = crane.world.joint(rope).ok_or("no rope")?.force().length();
        println!("the rope bears {pull:.0} N of {:.0} N", 450.0 * 9.81);
        assert!((pull - 450.0 * 9.81).abs() < 50.0);
        crane.run(1.0, 0.0, x)?;
        crane.damp(load, 1.0)?;
        crane.run(0.0, 0.0, 20.0)?;
        crane.run(0.0, 0.3, 20.0)?;
        crane.damp(load, 0.0)?;
        crane.world.remove_joint(weld);
        crane.length = crane.world.joint(rope).ok_or("no rope")?.length();
        crane.run(0.0, -0.5, 4.0)?;
        crane.run(-1.0, 0.0, x)?;
        crane.damp(magnet, 1.0)?;
        crane.run(0.0, 0.0, 10.0)?;
        let at = crane.world.body(load).ok_or("no load")?.position();
        println!("put down at {:.3} m", at.x);
        assert!((at.y - 0.5).abs() < 0.01 && (at.x - x).abs() < 0.3);
    }
    Ok(())
}
