//! Pause, slow and fast motion change no bit; drawn poses are between the last two steps.

use drystone::{BodyDef, BodyId, Clock, DefError, Quat, ShapeDef, World, vec3};

const DT: f32 = 1.0 / 60.0;
const SPIN: [f32; 3] = [0.0, 3.0, 4.0];

fn scene() -> Result<(World, BodyId), DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    for i in 0..10_u8 {
        let at = BodyDef::dynamic().with_position([0.0, 0.5 + f32::from(i), 0.0]);
        world.add_body(at.with_shape(ShapeDef::box_half([0.5; 3])))?;
    }
    let at = BodyDef::dynamic().with_position([-20.0, 3.0, 0.0]).with_angular_velocity(SPIN);
    let ball = at.with_linear_velocity([9.0, 9.81, 0.0]).with_shape(ShapeDef::sphere(0.4));
    let ball = world.add_body(ball)?;
    Ok((world, ball))
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ((mut world, ball), (mut plain, _), mut clock) = (scene()?, scene()?, Clock::new(DT)?);
    clock.set_most_steps(15);
    let (mut steps, mut way, mut turn) = (0_u16, 0.0_f32, 0.0_f32);
    for frame in 0..200_u16 {
        clock.set_scale([1.0, 0.1, 4.0, 0.0, 1.0][usize::from(frame / 30 % 5)]);
        let length = 0.003 + 0.037 * f32::from(frame * 13 % 30) / 30.0;
        let (hash, taken) = (world.state_hash(), clock.advance(&mut world, length, |_| {}));
        assert!(taken > 0 || world.state_hash() == hash, "a pause changes nothing");
        steps += u16::try_from(taken)?;
        if (2..90).contains(&steps) {
            let t = (f32::from(steps - 1) + clock.part()) * DT;
            let shown = clock.pose(&world, ball).ok_or("no ball")?;
            let path = vec3(9.0 * t - 20.0, 3.0 + 9.81 * (t - 0.5 * t * t), 0.0);
            way = way.max((shown.position - path).length());
            let exact = Quat::from_axis_angle(SPIN, 5.0 * t);
            turn = turn.max((exact.conjugate() * shown.rotation).angle());
        }
    }
    (0..steps).for_each(|_| plain.step(DT));
    println!("{steps} steps; drawn {:.2} mm and {turn:.5} rad off the exact path", way * 1e3);
    assert!(world.state_hash() == plain.state_hash() && way < 0.001 && turn < 0.001);
    Ok(())
}
