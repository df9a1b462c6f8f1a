//! Measures the time per picture: `cargo run --release -p drystone-render --example frame_time
//! [SCENE]`.

use std::error::Error;
use std::time::Instant;

use drystone_render::{Canvas, Drawing, Look, Subject};

#[expect(clippy::print_stdout, reason = "an example tells its result")]
fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "large_pyramid".to_owned());
    let mut running = drystone_scene::named(&name)?.build()?;
    running.step(1.0 / 60.0)?;
    let subject = Subject::of(&running.world);
    let camera = subject.camera(subject.angles(), 16.0 / 9.0);
    let start = Instant::now();
    let mut canvas = Canvas::new(1280, 720)?;
    println!("{}: opened in {:.0} ms", canvas.device_name(), start.elapsed().as_secs_f64() * 1.0e3);
    for _ in 0..10 {
        let start = Instant::now();
        let drawing = Drawing::of(&running.world, &subject, &Look::default());
        let gathered = start.elapsed();
        canvas.draw(&drawing, &camera)?;
        let (gathered, all) =
            (gathered.as_secs_f64() * 1.0e3, start.elapsed().as_secs_f64() * 1.0e3);
        println!("{name}: {all:.1} ms, {gathered:.1} of them gathering what is drawn");
    }
    Ok(())
}
