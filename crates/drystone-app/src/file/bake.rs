//! The motion of a run, kept for the baked file.

use std::path::{Path, PathBuf};

use drystone::{BodyDef, BodyId, BodyRef, Pose, ShapeDef, World};
use drystone_scene::bake::{self, Motion};
use drystone_scene::{Running, SceneBody};

use crate::load::Loaded;
use crate::output::{self, Failure, probe};

/// How a body looked over a part of the run.
#[derive(Debug, Default)]
struct Track {
    /// The first of the times at which it was there.
    first: usize,
    poses: Vec<Pose>,
}

/// The state of a body in the baked file so far.
#[derive(Debug)]
struct Follow {
    /// Its track, by its place among those of the scene or of the pieces.
    track: usize,
    is_piece: bool,
    /// Its shapes: a glued body loses some.
    shapes: usize,
}

/// Poses of the bodies over the run; 28 bytes a body and step.
#[derive(Debug)]
pub(crate) struct Bake {
    path: PathBuf,
    times: Vec<f32>,
    /// Tracks of the bodies that scene and script bring, and of the pieces that bodies broke into.
    /// A body that lost some of its shapes goes on as a piece.
    own: Vec<Track>,
    pieces: Vec<(SceneBody, Track)>,
    /// The state of each body of the run, in the order in which they came.
    follow: Vec<Follow>,
}

impl Bake {
    /// Nothing kept yet; the file can be written.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        probe(path)?;
        Ok(Self {
            path: path.to_owned(),
            times: Vec::new(),
            own: Vec::new(),
            pieces: Vec::new(),
            follow: Vec::new(),
        })
    }

    /// Adds the poses at `time` [s]; of static bodies too: one without any is taken for one that
    /// never came.
    pub(crate) fn add(&mut self, time: f64, running: &Running) {
        let time = seconds(time);
        if self.times.last().is_some_and(|&last| last >= time) {
            // The step is too short for times in f32.
            return;
        }
        let frame = self.times.len();
        self.times.push(time);
        let bodies = running.bodies.iter().zip(&running.names).enumerate();
        for (number, (&id, name)) in bodies {
            let body = running.world.body(id);
            let shapes = body.map_or(0, |b| b.shapes().count());
            if number == self.follow.len() {
                self.meet(running, id, name, shapes);
            }
            let Some(body) = body else { continue };
            if shapes != self.follow[number].shapes {
                // The same body, but it looks otherwise.
                self.follow[number] = Follow { track: self.pieces.len(), is_piece: true, shapes };
                let now = look(&running.world, &body, name.clone());
                self.pieces.push((now, Track::default()));
            }
            let Follow { track, is_piece, .. } = self.follow[number];
            let track = if is_piece { &mut self.pieces[track].1 } else { &mut self.own[track] };
            if track.poses.is_empty() {
                track.first = frame;
            }
            track.poses.push(body.pose());
        }
    }

    /// A body that was not there before.
    fn meet(&mut self, running: &Running, id: BodyId, name: &str, shapes: usize) {
        let is_piece = running.is_piece(id);
        let track = if is_piece { self.pieces.len() } else { self.own.len() };
        self.follow.push(Follow { track, is_piece, shapes });
        if !is_piece {
            self.own.push(Track::default());
        } else if let Some(body) = running.world.body(id) {
            let now = look(&running.world, &body, name.to_owned());
            self.pieces.push((now, Track::default()));
        } else {
            // Broken in the step in which it came.
            let gone = SceneBody { name: name.to_owned(), def: BodyDef::default() };
            self.pieces.push((gone, Track::default()));
        }
    }

    /// Writes the file; returns its path.
    pub(crate) fn finish(mut self, loaded: &Loaded) -> Result<PathBuf, Failure> {
        // Bodies that the script has not brought yet.
        let scene = loaded.scene();
        self.own.resize_with(scene.bodies.len() + scene.script.joining().count(), Track::default);
        let (pieces, tracks): (Vec<SceneBody>, Vec<Track>) = self.pieces.into_iter().unzip();
        let mut motion = Motion { times: self.times, ..Motion::default() };
        for track in self.own.into_iter().chain(tracks) {
            motion.gone.push(motion.times.len() - (track.first + track.poses.len()));
            motion.poses.push(track.poses);
        }
        let ending = match loaded {
            Loaded::BuiltIn(scene) | Loaded::Read(scene) | Loaded::Own(scene, _) => {
                bake::write_scene(&self.path, scene, &pieces, &motion)
            }
            Loaded::Gltf(loaded) => bake::write(&self.path, loaded, &motion),
            Loaded::Obj(loaded) => bake::write_objects(&self.path, loaded, &motion),
        }
        .map_err(Failure::failed)?;
        output::warn_of(ending, &self.path);
        Ok(self.path)
    }
}

/// A body as it looks now.
fn look(world: &World, body: &BodyRef<'_>, name: String) -> SceneBody {
    let shapes = body.shapes().filter_map(|id| world.shape(id));
    let shapes = shapes.map(|s| ShapeDef {
        pose: s.local_pose(),
        sensor: s.is_sensor(),
        ..ShapeDef::new(s.shape().clone())
    });
    let def = BodyDef {
        kind: body.kind(),
        position: body.position(),
        rotation: body.rotation(),
        shapes: shapes.collect(),
        ..BodyDef::default()
    };
    SceneBody { name, def }
}

/// The file keeps times as f32.
#[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
const fn seconds(time: f64) -> f32 {
    time as f32
}
