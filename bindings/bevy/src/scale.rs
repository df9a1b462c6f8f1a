//! Scaled shapes.

use std::sync::Arc;

use drystone::math::trig;
use drystone::{Hull, Mesh, Pose, Shape, Vec3, vec3};

use crate::collider::Part;
use crate::convert::{same, times};

/// Number of sides of a round shape that an uneven scale turns into a hull, and of rings of a
/// ball's quarter. Its surface then lies within 2 % of the radius: 1 - cos(π/16).
const SIDES: usize = 16;
const RINGS: usize = 4;

/// The part under a scale of the collider's frame: pose and shape.
///
/// Boxes, hulls and meshes are exact under any scale, round shapes under one that keeps them round.
/// Other round shapes become hulls.
pub(crate) fn scaled(part: &Part, scale: Vec3) -> Result<(Pose, Shape), String> {
    if scale == Vec3::ONE {
        return Ok((part.pose, part.shape.clone()));
    }
    if scale.x == 0.0 || scale.y == 0.0 || scale.z == 0.0 || !scale.is_finite() {
        let (x, y, z) = (scale.x, scale.y, scale.z);
        return Err(format!(
            "`scale` must be three finite numbers other than 0 (got {x}, {y}, {z})"
        ));
    }
    let position = times(part.pose.position, scale);
    let is_turned = part.pose.rotation != drystone::Quat::IDENTITY;
    let size = vec3(scale.x.abs(), scale.y.abs(), scale.z.abs());
    let is_even = same(size.x, size.y) && same(size.y, size.z);
    let is_positive = scale == size;
    if (is_even && is_positive) || !is_turned {
        let pose = Pose { position, ..part.pose };
        if let Some(shape) = kept(&part.shape, scale, size)? {
            return Ok((pose, shape));
        }
    }
    if let Shape::HalfSpace { normal, offset } = part.shape {
        // A plane's normal scales by the inverse of the scale of its points.
        let normal = part.pose.rotation.rotate(normal);
        let point = times(normal * offset, scale);
        let normal = vec3(normal.x / scale.x, normal.y / scale.y, normal.z / scale.z);
        let normal = normal.normalize_or(Vec3::Y);
        return Ok((Pose::at(position), Shape::half_space(normal, normal.dot(point))));
    }
    let place = |p: Vec3| times(part.pose.point(p), scale);
    if let Shape::Mesh(mesh) = &part.shape {
        let vertices = mesh.vertices().iter().copied().map(place).collect();
        let mesh = Mesh::new(vertices, mesh.triangles().to_vec()).map_err(|e| e.to_string())?;
        return Ok((Pose::IDENTITY, Shape::Mesh(Arc::new(mesh))));
    }
    let points: Vec<Vec3> = points(&part.shape).into_iter().map(place).collect();
    let hull = Hull::from_points(&points).map_err(|e| e.to_string())?;
    Ok((Pose::IDENTITY, Shape::Hull(Arc::new(hull))))
}

/// The shape under a scale along its own axes, if it keeps its kind. `size`: the scale without its
/// signs.
fn kept(shape: &Shape, scale: Vec3, size: Vec3) -> Result<Option<Shape>, String> {
    let is_round = same(size.x, size.z);
    let is_even = is_round && same(size.x, size.y);
    Ok(match shape {
        Shape::Sphere { radius } if is_even => Some(Shape::sphere(radius * size.x)),
        Shape::Capsule { half_height, radius } if is_even => {
            Some(Shape::capsule(half_height * size.x, radius * size.x))
        }
        Shape::Box { half_extents } => Some(Shape::box_half(times(*half_extents, size))),
        Shape::Cylinder { half_height, radius } if is_round => {
            Some(Shape::cylinder(half_height * size.y, radius * size.x))
        }
        Shape::Cone { half_height, radius_bottom, radius_top } if is_round => {
            let (bottom, top) = (radius_bottom * size.x, radius_top * size.x);
            // A mirror image stands on its head.
            let [bottom, top] = if scale.y < 0.0 { [top, bottom] } else { [bottom, top] };
            Some(Shape::Cone {
                half_height: half_height * size.y,
                radius_bottom: bottom,
                radius_top: top,
            })
        }
        Shape::Hull(hull) => {
            let points: Vec<Vec3> = hull.vertices().iter().map(|p| times(*p, scale)).collect();
            let hull = Hull::from_points(&points).map_err(|e| e.to_string())?;
            Some(Shape::Hull(Arc::new(hull)))
        }
        _ => None,
    })
}

/// Points whose hull is the shape, or stands for it.
fn points(shape: &Shape) -> Vec<Vec3> {
    match shape {
        Shape::Sphere { radius } => ball(*radius, 0.0),
        Shape::Capsule { half_height, radius } => ball(*radius, *half_height),
        Shape::Box { half_extents: h } => {
            let signs = [-1.0_f32, 1.0];
            let corner = |x: f32, y: f32, z: f32| times(*h, vec3(x, y, z));
            let edges = signs.into_iter().flat_map(|x| signs.map(|y| (x, y)));
            edges.flat_map(|(x, y)| signs.map(|z| corner(x, y, z))).collect()
        }
        Shape::Cylinder { half_height, radius } => {
            let mut points = ring(*radius, -half_height);
            points.extend(ring(*radius, *half_height));
            points
        }
        Shape::Cone { half_height, radius_bottom, radius_top } => {
            let mut points = ring(*radius_bottom, -half_height);
            points.extend(ring(*radius_top, *half_height));
            points
        }
        Shape::Hull(hull) => hull.vertices().to_vec(),
        _ => Vec::new(),
    }
}

/// A circle about y, or its center if it has no radius.
fn ring(radius: f32, y: f32) -> Vec<Vec3> {
    if radius == 0.0 {
        return vec![vec3(0.0, y, 0.0)];
    }
    let point = |k: usize| {
        let (sin, cos) = trig::sin_cos(fraction(k, SIDES) * 2.0 * core::f32::consts::PI);
        vec3(radius * cos, y, radius * sin)
    };
    (0..SIDES).map(point).collect()
}

/// Two half balls, apart by twice `half_height` [m].
fn ball(radius: f32, half_height: f32) -> Vec<Vec3> {
    let mut points = Vec::new();
    for side in [-1.0, 1.0] {
        for k in 0..RINGS {
            let (sin, cos) = trig::sin_cos(fraction(k, RINGS) * 0.5 * core::f32::consts::PI);
            points.extend(ring(radius * cos, side * (half_height + radius * sin)));
        }
        points.push(vec3(0.0, side * (half_height + radius), 0.0));
    }
    points
}

/// `k` of `n` equal parts.
#[expect(clippy::cast_precision_loss, reason = "small whole numbers")]
fn fraction(k: usize, n: usize) -> f32 {
    k as f32 / n as f32
}

#[cfg(test)]
mod tests {
    use super::scaled;
    use crate::collider::Part;
    use crate::convert::same;
    use drystone::{Pose, Quat, Shape, Vec3, vec3};

    fn part(shape: Shape) -> Part {
        Part { pose: Pose::at([1.0, 2.0, 3.0]), shape }
    }

    #[test]
    fn an_even_scale_keeps_the_kind_and_moves_the_part() {
        let (pose, shape) = scaled(&part(Shape::sphere(0.5)), Vec3::splat(2.0)).expect("a ball");
        assert_eq!(pose.position, vec3(2.0, 4.0, 6.0));
        assert!(matches!(shape, Shape::Sphere { radius } if same(radius, 1.0)));
    }

    /// A box under a scale along the axes of its frame, but turned by a quarter about z against
    /// them: its x edge lies along y, and gets the scale of y.
    #[test]
    fn a_turned_box_is_scaled_along_the_axes_of_its_frame() {
        let turned = Quat::from_axis_angle([0.0, 0.0, 1.0], core::f32::consts::FRAC_PI_2);
        let pose = Pose { position: Vec3::ZERO, rotation: turned };
        let part = Part { pose, shape: Shape::box_half([1.0, 2.0, 3.0]) };
        let (_, shape) = scaled(&part, vec3(2.0, 5.0, 1.0)).expect("a hull");
        let Shape::Hull(hull) = shape else { unreachable!("a box becomes a hull") };
        let size = hull.bounds().max - hull.bounds().min;
        // Twice the half extents of y under the scale of x, and the reverse; roundings of size 10.
        assert!((size - vec3(8.0, 10.0, 6.0)).length() < 20.0 * f32::EPSILON, "{size:?}");
    }

    /// An ellipsoid has 4/3 π a b c. The hull of its points has less. A side of the polygons lies
    /// cos(π/16) of the radius from the axis, along the rings and across them; the hull contains
    /// the ellipsoid shrunk by the square of that, about 0.98².
    #[test]
    fn a_stretched_ball_is_nearly_an_ellipsoid() {
        let ball = Part { pose: Pose::IDENTITY, shape: Shape::sphere(1.0) };
        let (_, shape) = scaled(&ball, vec3(1.0, 2.0, 3.0)).expect("a hull");
        let Shape::Hull(hull) = shape else { unreachable!("it is no ball") };
        let whole = 4.0 / 3.0 * core::f32::consts::PI * 6.0;
        let part = hull.volume() / whole;
        assert!(part < 1.0 && part > 0.98_f32.powi(6), "{part}");
    }

    #[test]
    fn a_scale_of_zero_is_refused() {
        assert!(scaled(&part(Shape::sphere(0.5)), vec3(1.0, 0.0, 1.0)).is_err());
    }

    /// Ground below y = 1, raised by a scale of 2 to y = 2.
    #[test]
    fn a_half_space_moves_with_its_plane() {
        let ground = Part { pose: Pose::IDENTITY, shape: Shape::half_space([0.0, 1.0, 0.0], 1.0) };
        let (_, shape) = scaled(&ground, vec3(1.0, 2.0, 1.0)).expect("ground");
        assert!(matches!(shape, Shape::HalfSpace { offset, .. } if same(offset, 2.0)));
    }
}
