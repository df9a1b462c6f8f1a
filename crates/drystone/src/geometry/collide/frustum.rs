//! Cylinders, cones and truncated cones about y: support, features, and the distance of a point.
//!
//! In the half plane of radius ρ and height y the body is a trapezoid; its slanted side has the
//! normal (c, s).

use crate::base::math::{Vec3, greater, vec3};
use crate::geometry::convex::clip::{Polygon, clamp01};
use crate::geometry::manifold::Manifold;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    pub(crate) half_height: f32,
    /// Radii at y = -half_height and y = +half_height [m].
    pub(crate) bottom: f32,
    pub(crate) top: f32,
    c: f32,
    s: f32,
}

/// cos k π/8, k = 0 to 4 (in reverse order the sines), for the corners of the polygon of a disc.
const COS: [f32; 5] = [1.0, 0.923_879_5, 0.707_106_77, 0.382_683_43, 0.0];
const DISC_CORNERS: usize = 16;

impl Frustum {
    pub(crate) fn new(half_height: f32, bottom: f32, top: f32) -> Self {
        let (rise, run) = (2.0 * half_height, bottom - top);
        let length = (rise * rise + run * run).sqrt();
        Self { half_height, bottom, top, c: rise / length, s: run / length }
    }

    pub(crate) fn support(&self, d: Vec3) -> Vec3 {
        let across = (d.x * d.x + d.z * d.z).sqrt();
        let up = self.half_height * d.y;
        let (radius, y) = if self.top * across + up >= self.bottom * across - up {
            (self.top, self.half_height)
        } else {
            (self.bottom, -self.half_height)
        };
        if across > 0.0 {
            let k = radius / across;
            vec3(d.x * k, y, d.z * k)
        } else {
            vec3(0.0, y, 0.0)
        }
    }

    /// Normal of the end that faces `d`, unless that end is a tip.
    pub(crate) fn cap_normal(&self, d: Vec3) -> Option<Vec3> {
        let (radius, normal) =
            if d.y < 0.0 { (self.bottom, -Vec3::Y) } else { (self.top, Vec3::Y) };
        (radius > 0.0).then_some(normal)
    }

    /// Unit direction of `d` across the axis.
    fn azimuth(d: Vec3) -> Vec3 {
        vec3(d.x, 0.0, d.z).normalize_or(Vec3::X)
    }

    pub(crate) fn side_normal(&self, d: Vec3) -> Vec3 {
        Self::azimuth(d) * self.c + Vec3::Y * self.s
    }

    /// Line of the side at the azimuth of `d`, bottom first.
    pub(crate) fn side_line(&self, d: Vec3) -> [Vec3; 2] {
        let u = Self::azimuth(d);
        let end = vec3(0.0, self.half_height, 0.0);
        [u * self.bottom - end, u * self.top + end]
    }

    /// Writes the end that faces `d` as a polygon. Most corners turn with the body, so that a body
    /// at rest keeps its points. One exact corner is at the azimuth of `d`, so that a body rolls
    /// smoothly on its rim.
    pub(crate) fn disc(&self, d: Vec3, out: &mut Polygon) {
        out.clear();
        let up = d.y >= 0.0;
        let (radius, y) =
            if up { (self.top, self.half_height) } else { (self.bottom, -self.half_height) };
        let lowest = Self::azimuth(d);
        let mut inserted = false;
        for k in 0..DISC_CORNERS {
            // Counter-clockwise seen from outside: on the upper end from z to x.
            let at = |k: usize| rim(if up { DISC_CORNERS - k } else { k });
            let (here, next) = (at(k), at(k + 1));
            out.add(vec3(here.x * radius, y, here.z * radius), number(k));
            let sign = if up { 1.0 } else { -1.0 };
            let after = |p: Vec3, q: Vec3| sign * p.cross(q).y > 0.0;
            if !inserted && after(here, lowest) && after(lowest, next) {
                out.add(vec3(lowest.x * radius, y, lowest.z * radius), number(DISC_CORNERS));
                inserted = true;
            }
        }
    }

    /// Contact of the frustum (A) with the point `p`, both in the frame of the frustum.
    pub(crate) fn against_point(&self, p: Vec3, margin: f32) -> Manifold {
        let rho = (p.x * p.x + p.z * p.z).sqrt();
        let u = Self::azimuth(p);
        let (h, c, s) = (self.half_height, self.c, self.s);
        let below = -h - p.y;
        let above = p.y - h;
        let beside = (rho - self.bottom) * c + (p.y + h) * s;
        let (mut distance, mut out_rho, mut out_y) = if beside >= greater(below, above) {
            (beside, c, s)
        } else if below >= above {
            (below, 0.0, -1.0)
        } else {
            (above, 0.0, 1.0)
        };
        if distance > 0.0 {
            let (mut rho_on, mut y_on, mut minimum) = (0.0, 0.0, f32::INFINITY);
            let corners = [(0.0, -h), (self.bottom, -h), (self.top, h), (0.0, h)];
            for i in 0..3 {
                let ((x0, y0), (x1, y1)) = (corners[i], corners[i + 1]);
                let (dx, dy) = (x1 - x0, y1 - y0);
                let square = dx * dx + dy * dy;
                let t = if square > 0.0 {
                    clamp01(((rho - x0) * dx + (p.y - y0) * dy) / square)
                } else {
                    0.0
                };
                let (x, y) = (x0 + dx * t, y0 + dy * t);
                let d = (rho - x) * (rho - x) + (p.y - y) * (p.y - y);
                if d < minimum {
                    (rho_on, y_on, minimum) = (x, y, d);
                }
            }
            let length = minimum.sqrt();
            // So close to the surface, the difference of the points has no direction.
            if length > 1.0e-6 * (h + self.bottom + self.top) {
                distance = length;
                (out_rho, out_y) = ((rho - rho_on) / length, (p.y - y_on) / length);
            }
        }
        let outward = u * out_rho + Vec3::Y * out_y;
        if distance <= margin {
            Manifold::single(outward, p - outward * (0.5 * distance), distance, 0)
        } else {
            Manifold::apart(distance)
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a corner of a disc")]
const fn number(k: usize) -> u32 {
    k as u32
}

/// Point of the unit circle at k π/8, from x to z.
fn rim(k: usize) -> Vec3 {
    let k = k % DISC_CORNERS;
    let j = k % 4;
    let (x, z) = (COS[j], COS[4 - j]);
    match k / 4 {
        0 => vec3(x, 0.0, z),
        1 => vec3(-z, 0.0, x),
        2 => vec3(-x, 0.0, -z),
        _ => vec3(z, 0.0, -x),
    }
}
