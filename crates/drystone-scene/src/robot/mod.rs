//! A robot as plain data, beside the [`crate::Scene`] of its bodies: joints with their coordinates,
//! tendons, sites, actuators, sensors and keyframes.
//!
//! Positions of all joints one after the other are `q`, velocities `v`: a free joint has 7 and 6
//! numbers, a ball joint 4 and 3, a slide or hinge one. Quaternions are w, x, y, z. Angles are
//! radians, whatever the file has. A defaults' class is resolved, and a short form such as
//! `<position kp="5"/>` is the general actuator that it stands for.

mod actuator;
mod sensor;

use drystone::{Pose, Vec3};

pub use self::actuator::{Actuator, Dynamics, Law, NUMBERS, Transmission};
pub use self::sensor::{Object, Sensor};

/// A robot's joints, and what drives and senses them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Robot {
    /// Joints in the order of their coordinates.
    pub joints: Vec<Joint>,
    /// Tendons.
    pub tendons: Vec<Tendon>,
    /// Sites that have a name.
    pub sites: Vec<Site>,
    /// Actuators, in the order of their controls.
    pub actuators: Vec<Actuator>,
    /// Sensors, in the order of their readings.
    pub sensors: Vec<Sensor>,
    /// Poses to start from.
    pub keyframes: Vec<Keyframe>,
    /// Positions at rest, as the file has them: `q` without a keyframe.
    pub start: Vec<f32>,
    /// Poses [world] of the bodies that the user moves, in order.
    pub mocap: Vec<Pose>,
    /// Things that are left out, a line each.
    pub left_out: Vec<String>,
}

impl Robot {
    /// The number of velocities.
    #[must_use]
    pub fn velocities(&self) -> usize {
        self.joints.last().map_or(0, |joint| joint.v + joint.kind.velocities())
    }

    /// The number of activations, which actuators with dynamics have.
    #[must_use]
    pub fn activations(&self) -> usize {
        self.actuators.iter().map(|a| a.activations).sum()
    }

    /// The number of readings of all sensors; `None` if one has a size that the file does not say.
    #[must_use]
    pub fn readings(&self) -> Option<usize> {
        self.sensors.iter().map(|s| s.size).sum()
    }
}

/// The motion that a joint allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointType {
    /// Anything: its position is that of the link, then its rotation.
    Free,
    /// Turn about any axis.
    Ball,
    /// Move along the axis.
    Slide,
    /// Turn about the axis.
    Hinge,
}

impl JointType {
    /// How many numbers its position has.
    #[must_use]
    pub const fn positions(self) -> usize {
        match self {
            Self::Free => 7,
            Self::Ball => 4,
            Self::Slide | Self::Hinge => 1,
        }
    }

    /// How many numbers its velocity has.
    #[must_use]
    pub const fn velocities(self) -> usize {
        match self {
            Self::Free => 6,
            Self::Ball => 3,
            Self::Slide | Self::Hinge => 1,
        }
    }
}

/// A joint. Forces are N on slides and N m on hinges and balls.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name, empty if it has none.
    pub name: String,
    /// Name of the link that it moves.
    pub link: String,
    /// The motion that it allows.
    pub kind: JointType,
    /// Its axis: unit [frame of the link].
    pub axis: Vec3,
    /// A point of its axis [m, frame of the link].
    pub anchor: Vec3,
    /// Its first position among all.
    pub q: usize,
    /// Its first velocity among all.
    pub v: usize,
    /// Its coordinate in the file's pose [m; rad]; 0 for balls and free joints.
    pub reference: f32,
    /// Least and greatest coordinate [m; rad]; of balls, 0 and the greatest turn.
    pub range: Option<[f32; 2]>,
    /// Distance at which limits begin to act [m; rad].
    pub margin: f32,
    /// Stiffness of its spring, and factors of the second and third power [N/m; N m/rad].
    pub stiffness: [f32; 3],
    /// Coordinate at which its spring is at rest [m; rad].
    pub spring_reference: f32,
    /// Damping, and factors of the second and third power [N s/m; N m s/rad].
    pub damping: [f32; 3],
    /// Time constant [s] and damping ratio that replace stiffness and damping.
    pub spring_damper: Option<[f32; 2]>,
    /// Inertia of a rotor [kg; kg m²].
    pub armature: f32,
    /// Greatest force of dry friction [N; N m].
    pub friction: f32,
    /// Bounds of what all actuators do to it together [N; N m].
    pub force_range: Option<[f32; 2]>,
    /// Whether its share of gravity compensation counts as done by actuators.
    pub gravity_by_actuators: bool,
}

/// A place on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Its name.
    pub name: String,
    /// Name of the link.
    pub link: String,
    /// Its pose [frame of the link].
    pub pose: Pose,
}

/// A part of a tendon's path.
#[derive(Clone, Debug, PartialEq)]
pub enum Stage {
    /// It is longer by this times the coordinate of a joint, by its number: of fixed tendons.
    Joint(usize, f32),
    /// It passes through a site, by its number.
    Site(usize),
    /// It wraps around a shape, by its name, on the side of a site if one is given.
    Geom(String, Option<usize>),
    /// Behind it, length counts divided by this.
    Pulley(f32),
}

/// A tendon, of joints or through sites.
#[derive(Clone, Debug, PartialEq)]
pub struct Tendon {
    /// Its name, empty if it has none.
    pub name: String,
    /// Its parts: only [`Stage::Joint`] for fixed tendons, all others for spatial ones.
    pub path: Vec<Stage>,
    /// Least and greatest length [m, or that of the coordinates].
    pub range: Option<[f32; 2]>,
    /// Distance at which limits begin to act.
    pub margin: f32,
    /// Stiffness, and factors of the second and third power.
    pub stiffness: [f32; 3],
    /// Damping, and factors of the second and third power.
    pub damping: [f32; 3],
    /// Lengths between which its spring is at rest; `None`: its length in the file's pose.
    pub spring_length: Option<[f32; 2]>,
    /// Greatest force of dry friction [N].
    pub friction: f32,
    /// Inertia along it [kg].
    pub armature: f32,
    /// Bounds of what all actuators do to it together [N].
    pub force_range: Option<[f32; 2]>,
}

/// A state to start from; every list is whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframe {
    /// Its name, empty if it has none.
    pub name: String,
    /// Its time [s].
    pub time: f32,
    /// Positions.
    pub q: Vec<f32>,
    /// Velocities.
    pub v: Vec<f32>,
    /// Activations.
    pub activations: Vec<f32>,
    /// Controls.
    pub controls: Vec<f32>,
    /// Poses [world] of the bodies that the user moves.
    pub mocap: Vec<Pose>,
}
