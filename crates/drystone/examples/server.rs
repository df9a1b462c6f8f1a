//! A server has the true state, and a client runs ahead of it. Packets from the server arrive late,
//! out of order or not at all. The client corrects its stored state of that frame and replays up to
//! the present. Bodies that agree keep their state, including sleep.
//!
//! `cargo run --release --example server`

use drystone::{BodyDef, BodyId, DefError, Pose, ShapeDef, Vec3, World};

const DT: f32 = 1.0 / 60.0;
const FRAMES: usize = 600;
/// Another player kicks boxes until this frame; the client sees only the effects.
const KICKS_UNTIL: usize = 240;
/// Number of states that the client stores. Packets for older frames are useless.
const KEPT: usize = 24;

/// State of a body after a frame, as the server sends it.
struct State {
    body: BodyId,
    pose: Pose,
    velocities: [Vec3; 2],
    asleep: bool,
}

struct Packet {
    /// Frame of the states, and frame of arrival.
    frame: usize,
    arrives: usize,
    states: Vec<State>,
}

/// Random numbers from a seed: the same run every time.
struct Random(u64);

impl Random {
    /// A number below `n`.
    fn below(&mut self, n: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }
}

fn level() -> Result<(World, Vec<BodyId>), DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let mut boxes = Vec::new();
    for i in 0..48_u16 {
        let [x, y] = [i % 8, i / 8].map(f32::from);
        let at = BodyDef::dynamic().with_position([2.0 * x, 0.5 + y, 0.0]);
        boxes.push(world.add_body(at.with_shape(ShapeDef::box_half([0.5; 3])))?);
    }
    Ok((world, boxes))
}

fn states(world: &World, boxes: &[BodyId]) -> Vec<State> {
    let of = |body: &BodyId| {
        let b = world.body(*body)?;
        let velocities = [b.linear_velocity(), b.angular_velocity()];
        Some(State { body: *body, pose: b.pose(), velocities, asleep: b.is_asleep() })
    };
    boxes.iter().filter_map(of).collect()
}

/// Corrects a world to the server's states; returns the number of bodies that differed.
fn correct(world: &mut World, states: &[State]) -> Result<u32, DefError> {
    let mut corrected = 0;
    for state in states {
        let Some(mut body) = world.body_mut(state.body) else { continue };
        let [v, w] = state.velocities;
        corrected += u32::from(body.correct_state(state.pose, v, w)?);
    }
    // Sleep comes last, because a corrected body wakes its neighbors. Boxes of one stack sleep
    // together.
    for state in states.iter().filter(|state| state.asleep) {
        if let Some(mut body) = world.body_mut(state.body) {
            body.sleep();
        }
    }
    Ok(corrected)
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ((mut server, boxes), (mut client, _)) = (level()?, level()?);
    let mut random = Random(7);
    let mut channel: Vec<Packet> = Vec::new();
    // States before each of the last frames.
    let mut kept = vec![World::default(); KEPT];
    let (mut newest, mut corrections, mut again, mut farthest) = (None, 0, 0, 0.0_f32);
    for frame in 0..FRAMES {
        if frame < KICKS_UNTIL && random.below(40) == 0 {
            let hit = boxes[usize::try_from(random.below(48))?];
            if let Some(mut body) = server.body_mut(hit) {
                body.apply_impulse([0.0, 2000.0, 3000.0]);
            }
        }
        server.step(DT);
        // One packet in five is lost; the others take 4 to 11 frames.
        if random.below(5) > 0 {
            let arrives = frame + 4 + usize::try_from(random.below(8))?;
            channel.push(Packet { frame, arrives, states: states(&server, &boxes) });
        }

        kept[frame % KEPT].clone_from(&client);
        client.step(DT);
        while let Some(i) = channel.iter().position(|packet| packet.arrives == frame) {
            let packet = channel.swap_remove(i);
            // Packets older than the newest one contain nothing new.
            if newest > Some(packet.frame) {
                continue;
            }
            newest = Some(packet.frame);
            let next = packet.frame + 1;
            // The state after that frame; for the current frame it is the present state.
            let corrected = correct(&mut kept[next % KEPT], &packet.states)?;
            if corrected == 0 {
                continue;
            }
            corrections += corrected;
            client.clone_from(&kept[next % KEPT]);
            for frame in next..=frame {
                kept[frame % KEPT].clone_from(&client);
                client.step(DT);
                again += 1;
            }
        }
        let (here, there) = (states(&client, &boxes), states(&server, &boxes));
        let apart =
            here.iter().zip(&there).map(|(a, b)| (a.pose.position - b.pose.position).length());
        farthest = apart.fold(farthest, f32::max);
    }
    println!(
        "{corrections} corrections, {again} frames again; boxes were {farthest:.2} m apart at most"
    );
    for (a, b) in states(&client, &boxes).iter().zip(states(&server, &boxes)) {
        assert_eq!((a.pose, a.asleep), (b.pose, b.asleep), "all came to rest in the same place");
    }
    Ok(())
}
