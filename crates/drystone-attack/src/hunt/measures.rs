//! Lengths of shapes, for the oracles.

use drystone::{Shape, Vec3, vec3};

/// Lengths of a shape in its own frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measures {
    /// A point well inside [m].
    pub(super) middle: Vec3,
    /// Half extents of a box about the middle that lies inside [m].
    pub(super) core: Vec3,
    /// Half the minimum thickness [m].
    pub(super) thin: f32,
    /// Half the maximum length [m].
    pub(super) large: f32,
    /// It can roll.
    pub(super) rolls: bool,
}

/// 1/√3 and 1/√2: half extents of the box inside a unit ball and a unit disc.
const BALL: f32 = 0.577;
const DISC: f32 = 0.707;

/// Measures of a convex shape; `None` for a plane or a mesh.
pub(super) fn measures(shape: &Shape) -> Option<Measures> {
    let of = |core: Vec3, thin: f32, large: f32, rolls: bool| {
        Some(Measures { middle: Vec3::ZERO, core, thin, large, rolls })
    };
    match shape {
        Shape::Sphere { radius: r } => of(Vec3::splat(BALL * r), *r, *r, true),
        Shape::Box { half_extents: h } => of(*h, h.min_element(), h.max_element(), false),
        Shape::Capsule { half_height, radius: r } => {
            let core = vec3(BALL * r, half_height + BALL * r, BALL * r);
            of(core, *r, half_height + r, true)
        }
        Shape::Cylinder { half_height: h, radius: r } => {
            of(vec3(DISC * r, *h, DISC * r), h.min(*r), h.max(*r), true)
        }
        Shape::Cone { half_height: h, radius_bottom, radius_top } => {
            let r = 0.5 * (radius_bottom + radius_top);
            let large = h.max(*radius_bottom).max(*radius_top);
            // At half height the section has the mean radius; the box fits in half that radius, and
            // has half the height.
            of(vec3(0.35 * r, 0.5 * h, 0.35 * r), h.min(r), large, true)
        }
        Shape::Hull(hull) => {
            let corners = hull.vertices();
            #[expect(clippy::cast_precision_loss, reason = "some tens")]
            let count = corners.len() as f32;
            let middle = corners.iter().fold(Vec3::ZERO, |sum, p| sum + *p) * (1.0 / count);
            let depth = |plane: &drystone::geometry::Plane| -plane.distance(middle);
            let thin = hull.planes().iter().map(depth).fold(f32::INFINITY, f32::min);
            let large = corners.iter().map(|p| (*p - middle).length()).fold(0.0, f32::max);
            Some(Measures { middle, core: Vec3::splat(BALL * thin), thin, large, rolls: false })
        }
        _ => None,
    }
}

/// Maximum extent of a convex shape along a unit vector of its frame [m].
pub(super) fn support(shape: &Shape, d: Vec3) -> f32 {
    let across = (1.0 - d.y * d.y).max(0.0).sqrt();
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Box { half_extents: h } => h.dot(d.abs()),
        Shape::Capsule { half_height, radius } => half_height * d.y.abs() + radius,
        Shape::Cylinder { half_height, radius } => half_height * d.y.abs() + radius * across,
        Shape::Cone { half_height, radius_bottom, radius_top } => (half_height * d.y
            + radius_top * across)
            .max(radius_bottom * across - half_height * d.y),
        Shape::Hull(hull) => hull.vertices().iter().map(|p| p.dot(d)).fold(f32::MIN, f32::max),
        _ => 0.0,
    }
}

/// Whether the segment from `a` to `b` enters the box of these half extents about the origin.
pub(super) fn meets_box(a: Vec3, b: Vec3, half: Vec3) -> bool {
    let (mut from, mut to) = (0.0_f32, 1.0_f32);
    for ((a, b), half) in a.to_array().into_iter().zip(b.to_array()).zip(half.to_array()) {
        let way = b - a;
        if way.abs() < 1.0e-12 {
            if a.abs() > half {
                return false;
            }
            continue;
        }
        let (p, q) = ((-half - a) / way, (half - a) / way);
        from = from.max(p.min(q));
        to = to.min(p.max(q));
    }
    from <= to
}

#[cfg(test)]
mod tests {
    use drystone::{Shape, Vec3, vec3};

    use super::{measures, meets_box, support};

    #[test]
    fn a_way_through_a_box_meets_it_and_one_beside_it_does_not() {
        let half = vec3(1.0, 0.1, 1.0);
        assert!(meets_box(vec3(0.5, 3.0, 0.5), vec3(0.5, -3.0, 0.5), half));
        assert!(!meets_box(vec3(1.5, 3.0, 0.5), vec3(1.5, -3.0, 0.5), half));
        assert!(!meets_box(vec3(0.5, 3.0, 0.5), vec3(0.5, 0.2, 0.5), half));
        assert!(meets_box(Vec3::ZERO, Vec3::ZERO, half));
    }

    #[test]
    fn the_core_of_a_shape_lies_within_its_support() {
        let cone = Shape::Cone { half_height: 1.0, radius_bottom: 0.5, radius_top: 0.0 };
        for shape in [Shape::sphere(0.3), Shape::capsule(0.5, 0.1), Shape::cylinder(0.1, 1.0), cone]
        {
            let core = measures(&shape).unwrap().core;
            for d in [Vec3::X, Vec3::Y, vec3(0.6, 0.8, 0.0), vec3(0.6, -0.8, 0.0)] {
                assert!(core.dot(d.abs()) <= support(&shape, d) + 1.0e-6, "{shape:?} {d:?}");
            }
        }
    }
}
