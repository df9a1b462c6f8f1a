//! The trajectory as CSV: one row a body and kept step.
//!
//! No line says that the file is whole, for readers of CSV would take it for a row: it has its name
//! when it is.

use std::path::{Path, PathBuf};

use drystone::{Pose, Quat, Vec3};
use drystone_scene::{Running, SceneFrame};

use crate::output::{Failure, Output};

const HEADER: &[u8] = b"step,time,body,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,asleep\n";

/// A trace being written.
#[derive(Debug)]
pub(crate) struct Trace {
    output: Output,
    every: u64,
    /// Names as they stand in the file, quoted where they must be; in the order of the bodies.
    names: Vec<String>,
    row: Vec<u8>,
}

impl Trace {
    /// Opens the file and writes the header. Every `every`-th step is kept, step 0 among them.
    pub(crate) fn create(path: &Path, every: u64) -> Result<Self, Failure> {
        let mut output = Output::create(path)?;
        output.write(HEADER)?;
        Ok(Self { output, every, names: Vec::new(), row: Vec::new() })
    }

    /// Adds the state after step `step`, at `time` [s].
    pub(crate) fn add(&mut self, step: u64, time: f64, running: &Running) -> Result<(), Failure> {
        let Running { world, bodies, names, frames, .. } = running;
        if !step.is_multiple_of(self.every) {
            return Ok(());
        }
        // Bodies may join while the scene runs.
        self.names.extend(names.iter().skip(self.names.len()).map(|name| quoted(name)));
        let mut start = format!("{step},").into_bytes();
        push_f64(&mut start, time);
        for (name, &id) in self.names.iter().zip(bodies) {
            let Some(body) = world.body(id) else { continue };
            let state = State {
                pose: Pose { position: body.position(), rotation: body.rotation() },
                velocity: body.linear_velocity(),
                spin: body.angular_velocity(),
                is_asleep: body.is_asleep(),
            };
            state.push(&start, name, &mut self.row);
            self.output.write(&self.row)?;
        }
        for frame in frames {
            let Some(body) = bodies.get(frame.body).and_then(|id| world.body(*id)) else {
                continue;
            };
            let on = Pose { position: body.position(), rotation: body.rotation() };
            let SceneFrame { name, pose, center, .. } = frame;
            let (v, w) = (body.linear_velocity(), body.angular_velocity());
            let arm = on.point(*center) - body.center_of_mass();
            let state = State {
                pose: on.compose(pose),
                velocity: v + w.cross(arm),
                spin: w,
                is_asleep: body.is_asleep(),
            };
            state.push(&start, &quoted(name), &mut self.row);
            self.output.write(&self.row)?;
        }
        self.output.end_moment()
    }

    /// Gives the file its name; returns the path.
    pub(crate) fn finish(self) -> Result<PathBuf, Failure> {
        self.output.finish()
    }
}

/// The motion in a row: of a body, or of a link that is one with it.
struct State {
    pose: Pose,
    /// Velocity of its own center of mass [m/s, world].
    velocity: Vec3,
    /// [rad/s, world]
    spin: Vec3,
    is_asleep: bool,
}

impl State {
    /// Makes it the row, behind step and time.
    fn push(&self, start: &[u8], name: &str, row: &mut Vec<u8>) {
        row.clear();
        row.extend_from_slice(start);
        row.push(b',');
        row.extend_from_slice(name.as_bytes());
        let (p, Quat { x, y, z, w }) = (self.pose.position, self.pose.rotation);
        let (v, s) = (self.velocity, self.spin);
        for number in [p.x, p.y, p.z, x, y, z, w, v.x, v.y, v.z, s.x, s.y, s.z] {
            row.push(b',');
            push_f32(row, number);
        }
        row.extend_from_slice(if self.is_asleep { b",1\n" } else { b",0\n" });
    }
}

/// Appends the shortest text that reads back to the same number.
fn push_f32(row: &mut Vec<u8>, x: f32) {
    row.extend_from_slice(zmij::Buffer::new().format(x).as_bytes());
}

fn push_f64(row: &mut Vec<u8>, x: f64) {
    row.extend_from_slice(zmij::Buffer::new().format(x).as_bytes());
}

/// A CSV field, in quotes if it must be.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) || name != name.trim() {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::{push_f32, quoted};

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        let mut bits = 1_u32;
        for _ in 0..10_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let x = f32::from_bits(bits);
            if x.is_nan() {
                continue;
            }
            let mut text = Vec::new();
            push_f32(&mut text, x);
            let back: f32 = std::str::from_utf8(&text).unwrap().parse().unwrap();
            assert_eq!(back.to_bits(), x.to_bits());
        }
        for x in [0.0_f32, -0.0, f32::MIN_POSITIVE, f32::from_bits(1), f32::INFINITY] {
            let mut text = Vec::new();
            push_f32(&mut text, x);
            let back: f32 = std::str::from_utf8(&text).unwrap().parse().unwrap();
            assert_eq!(back.to_bits(), x.to_bits());
        }
    }

    #[test]
    fn names_are_quoted_as_csv_has_it() {
        assert_eq!(quoted("box 1"), "box 1");
        assert_eq!(quoted("a,b"), "\"a,b\"");
        assert_eq!(quoted("6\" pipe"), "\"6\"\" pipe\"");
    }
}
