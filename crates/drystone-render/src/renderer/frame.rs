//! Values of a whole picture that the shaders read.

use bytemuck::{Pod, Zeroable};
use drystone::Vec3;

use crate::camera::{Camera, Columns, horizontal_axes, spherical};
use crate::drawing::Drawing;

/// Elevation of the sun [rad].
const SUN_HEIGHT: f32 = 0.92;
/// Azimuth of the sun, from the front toward the left [rad].
const SUN_SIDE: f32 = -0.62;
/// Half the edge of the region in the shadow map, in radii of the subject.
const SHADOW_REACH: f32 = 1.6;
/// Depth of that region toward and away from the sun, in radii of the subject.
const SHADOW_DEPTH: f32 = 8.0;

/// `Frame` of the shaders.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Frame {
    view: Columns,
    light: Columns,
    eye: [f32; 4],
    right: [f32; 4],
    above: [f32; 4],
    forward: [f32; 4],
    up: [f32; 4],
    sun: [f32; 4],
    fog: [f32; 4],
}

impl Frame {
    #[expect(clippy::cast_precision_loss, reason = "sizes of pictures are far below 2^24")]
    pub(super) fn new(
        drawing: &Drawing,
        camera: &Camera,
        (width, height): (u32, u32),
        shadow_size: u32,
        encode: bool,
    ) -> Self {
        let (width, height) = (width as f32, height as f32);
        let aspect = width / height;
        let [right, above, forward] = camera.axes();
        let (half_height, half_width) = camera.half_size(aspect);
        let radius = drawing.radius;
        let sun = spherical(drawing.up, SUN_SIDE, SUN_HEIGHT);
        let reach = SHADOW_REACH * radius;
        let texel = 2.0 * reach / shadow_size as f32;
        let range = camera.distance().max(radius);
        Self {
            view: camera.matrix(drawing.origin, aspect),
            light: light(sun, drawing.up, drawing.middle - drawing.origin, radius),
            eye: with(camera.eye - drawing.origin, camera.near()),
            right: with(right * half_width, width),
            above: with(above * half_height, height),
            forward: with(forward, texel),
            up: with(drawing.up, radius),
            sun: with(sun, drawing.cell()),
            fog: [range + 3.0 * radius, 14.0 * radius, shadow_size as f32, f32::from(encode)],
        }
    }
}

/// Transform from the drawing's space to the shadow map.
fn light(sun: Vec3, up: Vec3, middle: Vec3, radius: f32) -> Columns {
    let (side, _) = horizontal_axes(up);
    let x = side.cross(sun).normalize_or(Vec3::X);
    let y = sun.cross(x);
    let (reach, deep) = (SHADOW_REACH * radius, SHADOW_DEPTH * radius);
    let (x, y, z) = (x / reach, y / reach, sun / (-2.0 * deep));
    [
        [x.x, y.x, z.x, 0.0],
        [x.y, y.y, z.y, 0.0],
        [x.z, y.z, z.z, 0.0],
        [-x.dot(middle), -y.dot(middle), 0.5 - z.dot(middle), 1.0],
    ]
}

const fn with(v: Vec3, w: f32) -> [f32; 4] {
    [v.x, v.y, v.z, w]
}

#[cfg(test)]
mod tests {
    use drystone::vec3;

    use super::{Vec3, light, spherical};

    #[test]
    fn what_is_nearer_to_the_sun_is_nearer_in_the_shadow_map() {
        let middle = vec3(1.0, 2.0, 3.0);
        let sun = spherical(Vec3::Y, 0.3, 0.9);
        let m = light(sun, Vec3::Y, middle, 2.0);
        let at =
            |p: Vec3, row: usize| m[0][row] * p.x + m[1][row] * p.y + m[2][row] * p.z + m[3][row];
        for (p, depth) in [(middle, 0.5), (middle + sun * 16.0, 0.0), (middle - sun * 16.0, 1.0)] {
            assert!(at(p, 0).abs() < 1.0e-5 && at(p, 1).abs() < 1.0e-5);
            assert!((at(p, 2) - depth).abs() < 1.0e-5);
        }
    }
}
