//! A crane: a trolley, a hoisting rope, and a magnet that moves two crates.

use drystone::joint::{Fixed, Rope};
use drystone::{BodyDef, BodyId, JointDef, JointId, ShapeDef, World};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Drives the trolley and lets out the rope at these speeds [m/s]; it accelerates at 1 m/s².
fn run(w: &mut World, (cart, rope): (BodyId, JointId), drive: f32, out: f32, half: u16) -> Outcome {
    for k in 0..30 * half {
        let most = f32::from(k.min(30 * half - k)) / 60.0;
        let length = w.joint(rope).ok_or("no rope")?.length() + out.clamp(-most, most) / 60.0;
        if out != 0.0 {
            w.joint_mut(rope).ok_or("no rope")?.set_lengths(0.0, length);
        }
        w.body_mut(cart).ok_or("no trolley")?.set_linear_velocity([drive, 0.0, 0.0]);
        w.step(1.0 / 60.0);
    }
    Ok(())
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Outcome {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let at = |y: f32| BodyDef::dynamic().with_position([0.0, y, 0.0]);
    let load = |y: f32| at(y).with_mass(400.0).with_shape(ShapeDef::box_half([0.5; 3]));
    let loads = [(world.add_body(load(1.5))?, 3.0), (world.add_body(load(0.5))?, 6.0)];
    let trolley = world.add_body(BodyDef::kinematic().with_position([0.0, 8.0, 0.0]))?;
    let magnet = ShapeDef::cylinder(0.1, 0.3);
    let magnet = world.add_body(at(4.0).with_mass(50.0).with_shape(magnet))?;
    let rope = JointDef::new(trolley, magnet, Rope::new(3.9));
    let rope = world.add_joint(rope.with_anchors([0.0; 3], [0.0, 0.1, 0.0]))?;
    for (load, x) in loads {
        while world.contacts_between(magnet, load).next().is_none() && world.step_count() < 9999 {
            run(&mut world, (trolley, rope), 0.0, 0.3, 1)?;
        }
        assert!(world.contacts_between(magnet, load).next().is_some(), "the magnet touches it");
        let weld = JointDef::new(magnet, load, Fixed::new());
        let weld = world.add_joint(weld.at([0.0, 1.0, 0.0]))?;
        run(&mut world, (trolley, rope), 0.0, -0.5, 11)?;
        run(&mut world, (trolley, rope), 0.0, 0.0, 4)?;
        let pull = world.joint(rope).ok_or("no rope")?.force().length();
        println!("the rope bears {pull:.0} N of {:.0} N", 450.0 * 9.81);
        assert!((pull - 450.0 * 9.81).abs() < 50.0);
        run(&mut world, (trolley, rope), x / 3.0, 0.0, 6)?;
        world.body_mut(load).ok_or("no load")?.set_damping(1.0, 1.0);
        run(&mut world, (trolley, rope), 0.0, 0.0, 40)?;
        run(&mut world, (trolley, rope), 0.0, 0.3, 40)?;
        world.body_mut(load).ok_or("no load")?.set_damping(0.0, 0.0);
        world.remove_joint(weld);
        run(&mut world, (trolley, rope), 0.0, -0.5, 8)?;
        run(&mut world, (trolley, rope), x / -3.0, 0.0, 6)?;
        world.body_mut(magnet).ok_or("no magnet")?.set_damping(1.0, 1.0);
        run(&mut world, (trolley, rope), 0.0, 0.0, 20)?;
        let at = world.body(load).ok_or("no load")?.position();
        assert!((at.y - 0.5).abs() < 0.01 && (at.x - x).abs() < 0.3, "put down at {at:?}");
    }
    Ok(())
}
