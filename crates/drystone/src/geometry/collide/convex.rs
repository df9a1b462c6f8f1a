//! The functions of a convex core that the general narrowphase needs: its support point and the
//! features that carry a contact along a normal.

use super::frustum::Frustum;
use crate::base::math::{Vec3, greater, vec3};
use crate::geometry::convex::clip::Polygon;
use crate::geometry::convex::sat;
use crate::geometry::hull::Hull;
use crate::geometry::solid::Core;

/// A bounded convex core, in its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Convex<'a> {
    Point,
    Segment { half_height: f32 },
    Hull(&'a Hull),
    Frustum(Frustum),
}

impl<'a> Convex<'a> {
    /// `None` for half-spaces and meshes.
    pub(crate) fn of(core: &'a Core) -> Option<Self> {
        Some(match core {
            Core::Point => Self::Point,
            Core::Segment { half_height } => Self::Segment { half_height: *half_height },
            Core::Hull(hull) => Self::Hull(hull),
            Core::Frustum { half_height, radius_bottom, radius_top } => {
                Self::Frustum(Frustum::new(*half_height, *radius_bottom, *radius_top))
            }
            Core::HalfSpace { .. } | Core::Mesh(_) => return None,
        })
    }

    /// Returns the point farthest along `direction`.
    #[inline]
    pub(crate) fn support(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Point => Vec3::ZERO,
            Self::Segment { half_height } => {
                vec3(0.0, if direction.y < 0.0 { -half_height } else { *half_height }, 0.0)
            }
            Self::Hull(x) => sat::support(x, direction),
            Self::Frustum(x) => x.support(direction),
        }
    }

    /// Returns a point inside.
    pub(crate) fn center(&self) -> Vec3 {
        if let Self::Hull(x) = self { x.center } else { Vec3::ZERO }
    }

    /// Approximate extent [m]; 0 for a point.
    pub(crate) fn size(&self) -> f32 {
        match self {
            Self::Point => 0.0,
            Self::Segment { half_height } => *half_height,
            Self::Hull(x) => x.vertices.first().map_or(0.0, |v| (*v - x.center).length()),
            Self::Frustum(x) => greater(x.half_height, greater(x.bottom, x.top)),
        }
    }

    /// Normal of the flat side that faces `direction` most.
    pub(crate) fn face_normal(&self, direction: Vec3) -> Option<Vec3> {
        match self {
            Self::Point | Self::Segment { .. } => None,
            Self::Hull(x) => x.planes.get(sat::face_along(x, direction)).map(|p| p.normal),
            Self::Frustum(x) => x.cap_normal(direction),
        }
    }

    /// Writes the corners of that flat side.
    pub(crate) fn face(&self, direction: Vec3, out: &mut Polygon) {
        match self {
            Self::Point | Self::Segment { .. } => out.clear(),
            Self::Hull(x) => sat::face_polygon(x, sat::face_along(x, direction), out),
            Self::Frustum(x) => x.disc(direction, out),
        }
    }

    /// Returns the straight line on the surface farthest along `direction`, and the cosine of the
    /// angle between `direction` and the normals of the line.
    pub(crate) fn line(&self, direction: Vec3) -> Option<([Vec3; 2], f32)> {
        match self {
            Self::Point => None,
            Self::Segment { half_height } => {
                let end = vec3(0.0, *half_height, 0.0);
                Some(([-end, end], vec3(direction.x, 0.0, direction.z).length()))
            }
            Self::Hull(x) => hull_line(x, direction),
            Self::Frustum(x) => {
                let normal = x.side_normal(direction);
                Some((x.side_line(direction), normal.dot(direction)))
            }
        }
    }

    /// Writes the corners of the feature that faces `direction` most: a face or a line; none for a
    /// point.
    pub(crate) fn incident(&self, direction: Vec3, out: &mut Polygon) {
        out.clear();
        let by_line = match self {
            Self::Point => return,
            Self::Segment { .. } => true,
            Self::Hull(_) => false,
            Self::Frustum(x) => x
                .cap_normal(direction)
                .is_none_or(|n| n.dot(direction) < x.side_normal(direction).dot(direction)),
        };
        if !by_line {
            self.face(direction, out);
        } else if let Some(([tail, head], _)) = self.line(direction) {
            out.add(tail, 0x400);
            out.add(head, 0x401);
        }
    }
}

fn hull_line(x: &Hull, direction: Vec3) -> Option<([Vec3; 2], f32)> {
    let mut best = None;
    let mut maximum = f32::NEG_INFINITY;
    for pair in x.edges.chunks_exact(2) {
        let ends = [pair[0], pair[1]].map(|e| x.vertices[usize::from(e.origin)]);
        let reach = direction.dot(ends[0]) + direction.dot(ends[1]);
        if reach > maximum {
            (best, maximum) = (Some(ends), reach);
        }
    }
    let ends = best?;
    let along = (ends[1] - ends[0]).try_normalize()?;
    let s = along.dot(direction);
    Some((ends, greater(1.0 - s * s, 0.0).sqrt()))
}
