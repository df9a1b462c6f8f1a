//! A world on the threads of a rayon pool, which a program may already have. The bits are the same
//! as on the engine's own team, and on threads of the program that join a team.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use drystone::threads::{Executor, Team};
use drystone::{BodyDef, DefError, ShapeDef, World};
use rayon::prelude::*;

/// Runs chunks as a parallel iterator of the pool.
#[derive(Debug)]
struct Rayon(rayon::ThreadPool);

impl Executor for Rayon {
    fn workers(&self) -> usize {
        self.0.current_num_threads()
    }

    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        self.0.install(|| {
            (0..chunks).into_par_iter().with_max_len(1).for_each(|chunk| {
                task(rayon::current_thread_index().unwrap_or(0), chunk);
            });
        });
    }
}

/// About a hundred boxes that fall on a floor.
fn scene(executor: Arc<dyn Executor>) -> Result<World, DefError> {
    let mut world = World::default().with_executor(executor);
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    for i in 0..400_u16 {
        let [x, y, z] = [i % 7, i / 49, i / 7 % 7].map(f32::from);
        let body = BodyDef::dynamic().with_position([0.9 * x, 0.6 + 1.1 * y, 0.9 * z + 0.1 * y]);
        world.add_body(body.with_shape(ShapeDef::box_half([0.4, 0.5, 0.3])))?;
    }
    Ok(world)
}

fn run(world: &mut World) -> u64 {
    (0..90).for_each(|_| world.step(1.0 / 60.0));
    world.state_hash()
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn core::error::Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build()?;
    let on_rayon = run(&mut scene(Arc::new(Rayon(pool)))?);
    let on_team = run(&mut scene(Arc::new(Team::with_threads(3)))?);

    // The program's own threads, which join the team until it releases them.
    let team = Arc::new(Team::hosted(3));
    let mut world = scene(team.clone())?;
    let leave = AtomicBool::new(false);
    let on_lent = std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| team.join(&leave));
        }
        let hash = run(&mut world);
        team.release(&leave);
        hash
    });
    println!("rayon {on_rayon:016x}, team {on_team:016x}, lent threads {on_lent:016x}");
    assert!(on_rayon == on_team && on_rayon == on_lent);
    Ok(())
}
