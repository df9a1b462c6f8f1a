//! The camera of a picture.

use drystone::math::trig;
use drystone::{Vec3, vec3};

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position [m, world].
    pub eye: Vec3,
    /// The point in the middle of the picture [m, world].
    pub target: Vec3,
    /// The direction that is up in the picture; need not be perpendicular to the view [world].
    pub up: Vec3,
    /// Angle from the lower to the upper edge of the picture [rad], above 0 and below π.
    pub field_of_view: f32,
}

/// Columns of a 4×4 matrix.
pub(crate) type Columns = [[f32; 4]; 4];

/// Default angle of view of a camera [rad]: 35°, with little distortion by perspective.
pub const FIELD_OF_VIEW: f32 = 0.61;

impl Camera {
    /// The right, up and forward directions of the picture: perpendicular unit vectors [world].
    #[must_use]
    pub fn axes(&self) -> [Vec3; 3] {
        let forward = (self.target - self.eye).normalize_or(-Vec3::Z);
        let side = forward.cross(self.up);
        let right = side.try_normalize().unwrap_or_else(|| forward.any_perpendicular());
        [right, right.cross(forward), forward]
    }

    /// Distance from eye to target [m].
    #[must_use]
    pub fn distance(&self) -> f32 {
        (self.target - self.eye).length()
    }

    /// Half the height and half the width of the picture at distance 1. The picture is `aspect`
    /// times as wide as high.
    pub(crate) fn half_size(&self, aspect: f32) -> (f32, f32) {
        let half = (0.5 * self.field_of_view).clamp(1.0e-3, 1.5);
        let half_height = trig::tan(half);
        (half_height, half_height * aspect)
    }

    /// Distance of the near plane [m].
    pub(crate) fn near(&self) -> f32 {
        (0.01 * self.distance()).clamp(1.0e-4, 1.0e3)
    }

    /// Transform from the world, with its origin at `origin`, to clip space; depth is 1 at the near
    /// plane and 0 at infinity.
    pub(crate) fn matrix(&self, origin: Vec3, aspect: f32) -> Columns {
        let [right, above, forward] = self.axes();
        let (half_height, half_width) = self.half_size(aspect);
        let (r, a) = (right / half_width, above / half_height);
        let eye = self.eye - origin;
        [
            [r.x, a.x, 0.0, forward.x],
            [r.y, a.y, 0.0, forward.y],
            [r.z, a.z, 0.0, forward.z],
            [-r.dot(eye), -a.dot(eye), self.near(), -forward.dot(eye)],
        ]
    }

    /// The direction through a point of the picture, given from −1 to 1 to the right and up: unit
    /// [world].
    #[must_use]
    pub fn ray(&self, x: f32, y: f32, aspect: f32) -> Vec3 {
        let [right, above, forward] = self.axes();
        let (half_height, half_width) = self.half_size(aspect);
        (forward + right * (x * half_width) + above * (y * half_height)).normalize_or(forward)
    }

    /// The camera turned about its target: by `yaw` about the picture's up direction, then by
    /// `pitch` upward [rad]. The turn stops short of looking straight up or down.
    #[must_use]
    pub fn orbited(&self, yaw: f32, pitch: f32) -> Self {
        let up = self.up.normalize_or(Vec3::Y);
        let (side, ahead) = horizontal_axes(up);
        let from_target = self.eye - self.target;
        let (x, y, z) = (from_target.dot(side), from_target.dot(up), from_target.dot(ahead));
        let flat = (x * x + z * z).sqrt();
        let turned = trig::atan2(x, z) + yaw;
        let most = 0.495 * core::f32::consts::PI;
        let raised = (trig::atan2(y, flat) + pitch).clamp(-most, most);
        let offset = spherical(up, turned, raised) * self.distance();
        Self { eye: self.target + offset, ..*self }
    }

    /// The camera at `times` the distance from its target.
    #[must_use]
    pub fn dollied(&self, times: f32) -> Self {
        let distance = (self.distance() * times).clamp(1.0e-3, 1.0e6);
        let back = (self.eye - self.target).normalize_or(Vec3::Z);
        Self { eye: self.target + back * distance, ..*self }
    }

    /// The camera moved sideways, by these fractions of half the picture's height at the target.
    #[must_use]
    pub fn panned(&self, right: f32, above: f32) -> Self {
        let axes = self.axes();
        let (half_height, _) = self.half_size(1.0);
        let by = (axes[0] * right + axes[1] * above) * (half_height * self.distance());
        Self { eye: self.eye + by, target: self.target + by, ..*self }
    }
}

/// Two unit directions perpendicular to `up` and to each other: the x and z axes if y is up.
pub(crate) fn horizontal_axes(up: Vec3) -> (Vec3, Vec3) {
    let reference = if up.y.abs() > 0.9 { Vec3::Z } else { -Vec3::Y };
    let side = up.cross(reference).normalize_or(Vec3::X);
    (side, side.cross(up))
}

/// Unit direction at the angle `yaw` about `up`, from the second horizontal axis toward the first,
/// and `pitch` above the horizon [rad].
pub(crate) fn spherical(up: Vec3, yaw: f32, pitch: f32) -> Vec3 {
    let (side, ahead) = horizontal_axes(up);
    let (sy, cy) = trig::sin_cos(yaw);
    let (sp, cp) = trig::sin_cos(pitch);
    (side * sy + ahead * cy) * cp + up * sp
}

impl Default for Camera {
    /// 10 m from the origin and a little above it.
    fn default() -> Self {
        Self {
            eye: vec3(4.0, 3.0, 9.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            field_of_view: FIELD_OF_VIEW,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Camera, Vec3, horizontal_axes, vec3};

    fn project(camera: &Camera, p: Vec3) -> [f32; 3] {
        let origin = vec3(1.0, 2.0, 3.0);
        let m = camera.matrix(origin, 2.0);
        let q = p - origin;
        let row = |i: usize| m[0][i] * q.x + m[1][i] * q.y + m[2][i] * q.z + m[3][i];
        [row(0) / row(3), row(1) / row(3), row(2) / row(3)]
    }

    #[test]
    fn the_target_is_in_the_middle_and_depth_is_one_at_the_near_plane() {
        let camera = Camera::default();
        let [x, y, depth] = project(&camera, camera.target);
        assert!(x.abs() < 1.0e-6 && y.abs() < 1.0e-6);
        assert!((depth - camera.near() / camera.distance()).abs() < 1.0e-6);
        let [_, _, forward] = camera.axes();
        let [.., depth] = project(&camera, camera.eye + forward * camera.near());
        assert!((depth - 1.0).abs() < 1.0e-3);
    }

    #[test]
    fn a_ray_meets_the_place_of_the_picture_it_was_asked_for() {
        let camera = Camera::default();
        let p = camera.eye + camera.ray(0.5, -0.25, 2.0) * 7.0;
        let [x, y, _] = project(&camera, p);
        assert!((x - 0.5).abs() < 1.0e-5 && (y + 0.25).abs() < 1.0e-5);
    }

    #[test]
    fn orbits_keep_the_distance_and_come_back() {
        let camera = Camera::default();
        let there = camera.orbited(0.7, 0.2);
        assert!((there.distance() - camera.distance()).abs() < 1.0e-4);
        assert!((there.orbited(-0.7, -0.2).eye - camera.eye).length() < 1.0e-4);
        let over = camera.orbited(0.0, 10.0);
        assert!(over.axes().iter().all(|a| a.is_finite()));
        for up in [Vec3::Y, Vec3::Z, -Vec3::Y, vec3(0.6, 0.0, 0.8)] {
            let (a, b) = horizontal_axes(up);
            assert!(
                a.dot(up).abs() < 1.0e-6 && b.dot(up).abs() < 1.0e-6 && a.dot(b).abs() < 1.0e-6
            );
        }
        assert_eq!(horizontal_axes(Vec3::Y), (Vec3::X, Vec3::Z));
    }
}
