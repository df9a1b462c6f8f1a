//! The sync test of rollback libraries. In every frame a game of 500 bodies rolls back seven frames
//! and replays them, and each frame must give the same result as before. Balls are added and
//! removed within those frames.
//!
//! `cargo run --release --example sync_test`

use drystone::{BodyDef, BodyId, DefError, ShapeDef, StageHashes, World};

const DT: f32 = 1.0 / 60.0;
const FRAMES: usize = 120;
/// Number of frames that every frame rolls back, and number of states stored for that.
const BACK: usize = 7;
const KEPT: usize = BACK + 1;

/// Everything that a frame changes.
#[derive(Default)]
struct Game {
    world: World,
    /// Balls that were thrown, the latest last.
    balls: Vec<BodyId>,
}

impl Game {
    /// A pile of 500 boxes.
    fn new() -> Result<Self, DefError> {
        let mut world = World::default();
        world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
        for i in 0..500_u16 {
            let [x, y, z] = [i % 10, i / 50, i / 10 % 5].map(f32::from);
            let at = BodyDef::dynamic().with_position([1.05 * x, 0.6 + 1.1 * y, 1.05 * z]);
            world.add_body(at.with_shape(ShapeDef::box_half([0.5; 3])))?;
        }
        Ok(Self { world, balls: Vec::new() })
    }

    /// Copies another game into this one, reusing its memory.
    fn copy(&mut self, from: &Self) {
        self.world.clone_from(&from.world);
        self.balls.clone_from(&from.balls);
    }

    /// Plays a frame. Here the players' input follows from its number; a game looks it up.
    fn advance(&mut self, frame: usize) -> Result<(), DefError> {
        if frame.is_multiple_of(5) {
            let from_side = if frame.is_multiple_of(10) { -4.0 } else { 14.0 };
            let ball = BodyDef::dynamic().with_position([from_side, 4.0, 2.0]);
            let ball = ball.with_linear_velocity([3.0 * (5.0 - from_side), 0.0, 0.0]);
            self.balls.push(self.world.add_body(ball.with_shape(ShapeDef::sphere(0.4)))?);
        }
        if self.balls.len() > 6 {
            self.world.remove_body(self.balls.remove(0));
        }
        self.world.step(DT);
        Ok(())
    }

    fn hashes(&self) -> StageHashes {
        self.world.stage_hashes()
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut game = Game::new()?;
    // States before each of the last frames, and the result of each.
    let mut kept: [Game; KEPT] = core::array::from_fn(|_| Game::default());
    let mut came: [StageHashes; KEPT] = core::array::from_fn(|_| game.hashes());
    let mut again = 0;
    for frame in 0..FRAMES {
        kept[frame % KEPT].copy(&game);
        game.advance(frame)?;
        came[frame % KEPT] = game.hashes();
        if frame < BACK {
            continue;
        }
        let first = frame - BACK;
        game.copy(&kept[first % KEPT]);
        for frame in first..=frame {
            kept[frame % KEPT].copy(&game);
            game.advance(frame)?;
            again += 1;
            if let Some(stage) = came[frame % KEPT].first_difference(&game.hashes()) {
                return Err(format!("frame {frame}: stage {} differs", stage.name()).into());
            }
        }
    }
    let counts = game.world.counts();
    println!("{FRAMES} frames of {} bodies, {again} again, every one the same", counts.dynamic);
    Ok(())
}
