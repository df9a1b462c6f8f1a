//! Axis-aligned bounding boxes.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::math::{Vec3, greater, lesser};

/// A box with faces along the axes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub struct Aabb {
    /// Lowest corner [m].
    pub min: Vec3,
    /// Highest corner [m].
    pub max: Vec3,
}

impl Aabb {
    /// The empty box; its union with another box is that box.
    pub const EMPTY: Self =
        Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// The box with these two corners.
    #[must_use]
    pub const fn new(min: Vec3, max: Vec3) -> Self {
        Self { min, max }
    }

    /// Returns the smallest box around some points.
    #[must_use]
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self::new(b.min.min(p), b.max.max(p)))
    }

    /// Returns the smallest box around both.
    #[must_use]
    #[inline]
    pub fn union(&self, o: &Self) -> Self {
        Self::new(self.min.min(o.min), self.max.max(o.max))
    }

    /// Returns the box enlarged by `margin` [m] on every side.
    #[must_use]
    #[inline]
    pub fn grown(&self, margin: f32) -> Self {
        Self::new(self.min - Vec3::splat(margin), self.max + Vec3::splat(margin))
    }

    /// Returns the box relative to another origin [m]; the result is rounded outward.
    pub(crate) fn told_from(&self, origin: Vec3) -> Self {
        let below = |x: f32, o: f32| outward(x, o, f32::next_down, |now, exact| now > exact);
        let above = |x: f32, o: f32| outward(x, o, f32::next_up, |now, exact| now < exact);
        let each = |v: Vec3, of: &dyn Fn(f32, f32) -> f32| Vec3 {
            x: of(v.x, origin.x),
            y: of(v.y, origin.y),
            z: of(v.z, origin.z),
        };
        Self::new(each(self.min, &below), each(self.max, &above))
    }

    /// True if the boxes share a point.
    #[must_use]
    #[inline]
    pub fn overlaps(&self, o: &Self) -> bool {
        self.min.x <= o.max.x
            && o.min.x <= self.max.x
            && self.min.y <= o.max.y
            && o.min.y <= self.max.y
            && self.min.z <= o.max.z
            && o.min.z <= self.max.z
    }

    /// True if `o` lies completely inside.
    #[must_use]
    #[inline]
    pub fn contains(&self, o: &Self) -> bool {
        self.min.x <= o.min.x
            && self.min.y <= o.min.y
            && self.min.z <= o.min.z
            && o.max.x <= self.max.x
            && o.max.y <= self.max.y
            && o.max.z <= self.max.z
    }

    /// Center [m].
    #[must_use]
    #[inline]
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Half the edge lengths [m].
    #[must_use]
    #[inline]
    pub fn half_extents(&self) -> Vec3 {
        (self.max - self.min) * 0.5
    }

    /// Half the surface area [m²].
    #[must_use]
    #[inline]
    pub fn half_area(&self) -> f32 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// True if the segment from `origin` along `delta`, up to `max_fraction` of it, hits the box.
    /// `inv_delta` holds 1/delta per component (infinite where delta is zero).
    #[must_use]
    #[inline]
    pub fn meets_ray(&self, origin: Vec3, inv_delta: Vec3, max_fraction: f32) -> bool {
        let (mut low, mut high) = (0.0, max_fraction);
        for i in 0..3 {
            if inv_delta[i].is_infinite() {
                if origin[i] < self.min[i] || origin[i] > self.max[i] {
                    return false;
                }
                continue;
            }
            let a = (self.min[i] - origin[i]) * inv_delta[i];
            let b = (self.max[i] - origin[i]) * inv_delta[i];
            low = greater(low, lesser(a, b));
            high = lesser(high, greater(a, b));
        }
        // Each bound has three roundings; without the allowance a ray through a vertex shared by
        // boxes can miss them all.
        low <= high * (1.0 + 4.0 * f32::EPSILON)
    }
}
/// Subtracts an origin from a coordinate, and steps outward if the result was rounded inward.
fn outward(x: f32, origin: f32, step: fn(f32) -> f32, is_inside: fn(f64, f64) -> bool) -> f32 {
    let now = x - origin;
    let exact = f64::from(x) - f64::from(origin);
    if is_inside(f64::from(now), exact) { step(now) } else { now }
}
