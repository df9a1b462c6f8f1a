//! `--camera`: where pictures are taken from, as far as the user says it.

use std::str::FromStr;

use drystone::Vec3;
use drystone_render::{Camera, Subject, ViewAngles};

/// Cameras that are allowed, for messages.
pub(crate) const ALLOWED: &str = "front, back, left, right, top, turntable, or yaw=DEGREES, \
     pitch=DEGREES, zoom=FACTOR, turn=DEGREES_A_SECOND, eye=X:Y:Z, at=X:Y:Z, fov=DEGREES; several \
     separated by commas";

/// A camera as far as it is not found by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CameraSpec {
    yaw: Option<f32>,
    pitch: Option<f32>,
    zoom: Option<f32>,
    turn: Turn,
    eye: Option<Vec3>,
    at: Option<Vec3>,
    fov: Option<f32>,
}

/// How a film's camera goes around.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Turn {
    #[default]
    None,
    /// Once in the film.
    Once,
    /// Degrees a second.
    Speed(f32),
}

impl CameraSpec {
    /// The angles said, else those that show the subject best.
    pub(crate) fn angles(&self, subject: &Subject) -> ViewAngles {
        let best = subject.angles();
        ViewAngles {
            yaw: self.yaw.map_or(best.yaw, f32::to_radians),
            pitch: self.pitch.map_or(best.pitch, f32::to_radians),
        }
    }

    /// The camera for one picture of a subject.
    pub(crate) fn still(&self, subject: &Subject, aspect: f32) -> Camera {
        self.placed(subject.camera(self.angles(subject), aspect))
    }

    /// How far it has gone around at `time` of a film of `seconds` [rad].
    pub(crate) fn turned(&self, time: f64, seconds: f64) -> f64 {
        match self.turn {
            Turn::None => 0.0,
            Turn::Once => core::f64::consts::TAU * time / seconds.max(1.0e-3),
            Turn::Speed(degrees) => f64::from(degrees).to_radians() * time,
        }
    }

    /// A camera that was found, put where it is said to be.
    pub(crate) fn placed(&self, found: Camera) -> Camera {
        let field_of_view = self.fov.map_or(found.field_of_view, f32::to_radians);
        // A longer lens stands farther off, so the frame stays.
        let half = |angle: f32| drystone::math::trig::tan(0.5 * angle);
        let farther = half(found.field_of_view) / half(field_of_view);
        let mut camera = found.dollied(farther / self.zoom.unwrap_or(1.0));
        camera.field_of_view = field_of_view;
        if let Some(at) = self.at {
            camera.eye += at - camera.target;
            camera.target = at;
        }
        if let Some(eye) = self.eye {
            camera.eye = eye;
        }
        camera
    }

    fn set(&mut self, key: &str, value: &str) -> Option<()> {
        let number =
            |low: f32, high: f32| value.parse::<f32>().ok().filter(|x| (low..=high).contains(x));
        match key {
            "yaw" => self.yaw = Some(number(-1.0e4, 1.0e4)?),
            "pitch" => self.pitch = Some(number(-89.0, 89.0)?),
            "zoom" => self.zoom = Some(number(0.01, 100.0)?),
            "turn" => self.turn = Turn::Speed(number(-1.0e4, 1.0e4)?),
            "fov" => self.fov = Some(number(1.0, 150.0)?),
            "eye" => self.eye = Some(place(value)?),
            "at" => self.at = Some(place(value)?),
            _ => return None,
        }
        Some(())
    }
}

fn place(text: &str) -> Option<Vec3> {
    let mut parts = text.split(':').map(|part| part.trim().parse::<f32>().ok());
    let v = Vec3::from([parts.next()??, parts.next()??, parts.next()??]);
    (parts.next().is_none() && v.abs().max_element() <= 1.0e6).then_some(v)
}

impl FromStr for CameraSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut spec = Self::default();
        let mut view = |yaw: f32, pitch: f32| (spec.yaw, spec.pitch) = (Some(yaw), Some(pitch));
        for part in text.split(',').map(str::trim) {
            match part {
                "front" => view(0.0, 4.0),
                "right" => view(90.0, 4.0),
                "back" => view(180.0, 4.0),
                "left" => view(270.0, 4.0),
                "top" => view(0.0, 88.0),
                _ => {}
            }
        }
        for part in text.split(',').map(str::trim) {
            match part.split_once('=') {
                None if ["front", "right", "back", "left", "top", "auto"].contains(&part) => {}
                None if part == "turntable" => spec.turn = Turn::Once,
                Some((key, value)) if spec.set(key.trim(), value.trim()).is_some() => {}
                _ => return Err(format!("'{part}' is not understood, expected {ALLOWED}")),
            }
        }
        Ok(spec)
    }
}

#[cfg(test)]
mod tests {
    use drystone::vec3;

    use super::{Camera, CameraSpec, Turn};

    #[test]
    fn cameras_are_read() {
        let spec: CameraSpec = "front, pitch=10,turntable".parse().unwrap();
        assert_eq!((spec.yaw, spec.pitch, spec.turn), (Some(0.0), Some(10.0), Turn::Once));
        let spec: CameraSpec = "eye=1:2:-3.5,at=0:1:0,fov=50".parse().unwrap();
        let camera = spec.placed(Camera::default());
        assert_eq!((camera.eye, camera.target), (vec3(1.0, 2.0, -3.5), vec3(0.0, 1.0, 0.0)));
        for bad in ["", "behind", "yaw", "yaw=x", "yaw=nan", "eye=1:2", "eye=1:2:3:4", "zoom=0"] {
            assert!(bad.parse::<CameraSpec>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_turntable_goes_around_once() {
        let spec: CameraSpec = "turntable".parse().unwrap();
        assert!((spec.turned(5.0, 10.0) - core::f64::consts::PI).abs() < 1.0e-12);
    }
}
