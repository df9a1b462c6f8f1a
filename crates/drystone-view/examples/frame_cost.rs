//! The cost of watching: `cargo run --release -p drystone-view --example frame_cost [SCENE]`. Times
//! are those of the processor on the thread that draws, without those of the graphics driver on
//! other threads.

use std::error::Error;
use std::fs::read_to_string;

use drystone_render::Canvas;
use drystone_view::sim::{Command, Opened, Simulation};

const TIMES: u32 = 64;
/// Fewer pictures: a software renderer falls behind.
const PICTURES: u32 = 12;

#[expect(clippy::print_stdout, reason = "an example tells its result")]
fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "many_pyramids".to_owned());
    let scene = drystone_scene::named(&name)?;
    let mut bare = scene.build()?;
    let opened = Opened { name, running: scene.build()?, hz: 60.0, notes: Vec::new() };
    let mut simulation = Simulation::new(opened, Box::new(|_| Err(String::new())), false);
    let mut canvas = Canvas::new(1280, 720)?;
    // The clock of a thread is coarse: it is read around many of each.
    for _ in 0..30 {
        bare.step(1.0 / 60.0)?;
        simulation.obey(Command::Step);
    }
    let alone = timed(TIMES, || bare.step(1.0 / 60.0).is_ok())?;
    let watched = timed(TIMES, || simulation.step())?;
    simulation.obey(Command::Play(true));
    let shown = simulation.shown();
    let gathered = timed(TIMES, || simulation.shown())?;
    let camera = shown.subject.camera(shown.subject.angles(), 16.0 / 9.0);
    let drawing = &shown.views[0].drawing;
    canvas.draw(drawing, &camera)?;
    let ordered = timed(PICTURES, || canvas.order(drawing, &camera).is_ok())?;
    println!("step alone               {alone:.3} ms");
    println!("step and what is kept    {watched:.3} ms");
    println!("gathering what is drawn  {gathered:.3} ms");
    println!("telling the device       {ordered:.3} ms");
    Ok(())
}

/// Processor time of this thread for something [ms].
fn timed<T>(times: u32, mut what: impl FnMut() -> T) -> Result<f64, Box<dyn Error>> {
    let now = || -> Result<f64, Box<dyn Error>> {
        let text = read_to_string("/proc/thread-self/schedstat")?;
        Ok(text.split(' ').next().unwrap_or_default().parse::<f64>()? * 1.0e-6)
    };
    let start = now()?;
    for _ in 0..times {
        drop(what());
    }
    Ok((now()? - start) / f64::from(times))
}
