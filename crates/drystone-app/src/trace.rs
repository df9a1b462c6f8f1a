//! The trajectory as CSV: one row a body and kept step.

use std::path::{Path, PathBuf};

use drystone::{BodyId, World};

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
    /// Opens the file and writes the header. Of the steps every `every`-th is kept, 0 among them.
    pub(crate) fn create(path: &Path, every: u64) -> Result<Self, Failure> {
        let mut output = Output::create(path)?;
        output.write(HEADER)?;
        Ok(Self { output, every, names: Vec::new(), row: Vec::new() })
    }

    /// Adds the state after step `step`, at `time` [s].
    pub(crate) fn add(
        &mut self,
        step: u64,
        time: f64,
        world: &World,
        bodies: &[BodyId],
        names: &[String],
    ) -> Result<(), Failure> {
        if !step.is_multiple_of(self.every) {
            return Ok(());
        }
        // Bodies may join while the scene runs.
        self.names.extend(names.iter().skip(self.names.len()).map(|name| quoted(name)));
        let mut start = format!("{step},").into_bytes();
        push_f64(&mut start, time);
        for (name, &id) in self.names.iter().zip(bodies) {
            let Some(body) = world.body(id) else { continue };
            self.row.clear();
            self.row.extend_from_slice(&start);
            self.row.push(b',');
            self.row.extend_from_slice(name.as_bytes());
            let (p, q) = (body.position(), body.rotation());
            let (v, w) = (body.linear_velocity(), body.angular_velocity());
            for x in [p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z] {
                self.row.push(b',');
                push_f32(&mut self.row, x);
            }
            self.row.extend_from_slice(if body.is_asleep() { b",1\n" } else { b",0\n" });
            self.output.write(&self.row)?;
        }
        Ok(())
    }

    /// Writes out what is buffered; returns the path.
    pub(crate) fn finish(self) -> Result<PathBuf, Failure> {
        self.output.finish()
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
