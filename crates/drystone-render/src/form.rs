//! Triangles of the kinds of shapes. A form is uploaded once for all shapes that are scaled copies
//! of it.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use drystone::{Hull, Mesh, Shape, Vec3};
use drystone_scene::bake::solids::{self, Surface};
use drystone_scene::visual::{VisualVertex, Visuals};

use crate::sheet::Sheet;

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Vertex {
    /// Position, in the form's units.
    place: [f32; 3],
    /// The end of a capsule that the corner belongs to, −1 or 1; 0 for other forms.
    end: f32,
    normal: [f32; 3],
}

impl Vertex {
    /// A corner that belongs to no capsule.
    pub(crate) fn new(place: Vec3, normal: Vec3) -> Self {
        Self { place: place.to_array(), end: 0.0, normal: normal.to_array() }
    }

    #[cfg(test)]
    pub(crate) fn normal(&self) -> [f32; 3] {
        self.normal
    }
}

/// A corner of a triangle of a file's mesh.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct VisualCorner {
    place: [f32; 3],
    end: f32,
    normal: [f32; 3],
    uv: [f32; 2],
    color: [f32; 4],
}

/// A form: geometry that is uploaded once and placed many times.
#[derive(Clone, Debug)]
pub(crate) enum Form {
    /// Radius 1.
    Sphere,
    /// Radius 1; the ends are moved apart for each instance.
    Capsule,
    /// Half extents 1.
    Box,
    /// Radius and half height 1.
    Cylinder,
    /// Half height 1, the larger radius 1.
    Cone { bottom: f32, top: f32 },
    /// A square of half edge 1 about the origin, facing +y.
    Square,
    /// In meters.
    Hull(Arc<Hull>),
    /// In meters.
    Mesh(Arc<Mesh>),
    /// In meters from the drawing's origin.
    Sheet(Arc<Sheet>),
    /// A mesh of a file by its number, in meters.
    Visual(Arc<Visuals>, usize),
    /// A shape of a kind that has no form of its own, in meters.
    Other,
}

/// How to scale a form to a shape: scale [m, form's axes] and half the distance between a capsule's
/// ends [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fit {
    pub(crate) scale: Vec3,
    pub(crate) end: f32,
}

impl Form {
    /// The form of a shape, and its scale.
    pub(crate) fn of(shape: &Shape) -> (Self, Fit) {
        let fit = |x: f32, y: f32, z: f32| Fit { scale: Vec3::from([x, y, z]), end: 0.0 };
        match shape {
            &Shape::Sphere { radius: r } => (Self::Sphere, fit(r, r, r)),
            &Shape::Capsule { half_height, radius: r } => {
                (Self::Capsule, Fit { end: half_height, ..fit(r, r, r) })
            }
            &Shape::Box { half_extents: h } => (Self::Box, fit(h.x, h.y, h.z)),
            &Shape::Cylinder { half_height, radius } => {
                (Self::Cylinder, fit(radius, half_height, radius))
            }
            &Shape::Cone { half_height, radius_bottom, radius_top } => {
                let r = radius_bottom.max(radius_top);
                let form = Self::Cone { bottom: radius_bottom / r, top: radius_top / r };
                (form, fit(r, half_height, r))
            }
            Shape::HalfSpace { .. } => (Self::Square, fit(1.0, 1.0, 1.0)),
            Shape::Hull(hull) => (Self::Hull(Arc::clone(hull)), fit(1.0, 1.0, 1.0)),
            Shape::Mesh(mesh) => (Self::Mesh(Arc::clone(mesh)), fit(1.0, 1.0, 1.0)),
            _ => (Self::Other, fit(1.0, 1.0, 1.0)),
        }
    }

    /// Key that identifies a form. Hulls, meshes, sheets and visuals are identified by address, so
    /// the holder of a key must keep the form too. Keys are only looked up, never ordered.
    pub(crate) fn key(&self) -> [usize; 3] {
        let bits = |x: f32| x.to_bits() as usize;
        match self {
            Self::Sphere => [0, 0, 0],
            Self::Capsule => [1, 0, 0],
            Self::Box => [2, 0, 0],
            Self::Cylinder => [3, 0, 0],
            Self::Cone { bottom, top } => [4, bits(*bottom), bits(*top)],
            Self::Square => [5, 0, 0],
            Self::Hull(hull) => [6, Arc::as_ptr(hull).addr(), 0],
            Self::Mesh(mesh) => [7, Arc::as_ptr(mesh).addr(), 0],
            Self::Other => [8, 0, 0],
            Self::Sheet(sheet) => [9, Arc::as_ptr(sheet).addr(), 0],
            Self::Visual(visuals, number) => [10, Arc::as_ptr(visuals).addr(), *number],
        }
    }

    /// Its vertices and triangle indices, as bytes in the device's layout.
    pub(crate) fn bytes(&self) -> (Vec<u8>, Vec<u32>) {
        let Self::Visual(visuals, number) = self else {
            let (vertices, indices) = self.triangles();
            return (bytemuck::cast_slice(&vertices).to_vec(), indices);
        };
        let Some(mesh) = visuals.meshes.get(*number) else { return Default::default() };
        let corner = |v: &VisualVertex| VisualCorner {
            place: v.place,
            end: 0.0,
            normal: v.normal,
            uv: v.uv,
            color: v.color,
        };
        let corners: Vec<VisualCorner> = mesh.vertices.iter().map(corner).collect();
        (bytemuck::cast_slice(&corners).to_vec(), mesh.indices.clone())
    }

    /// Its triangles. Meshes of files have another kind of vertex.
    fn triangles(&self) -> (Vec<Vertex>, Vec<u32>) {
        /// Half the distance between the ends in the capsule's form.
        const APART: f32 = 2.0;
        let surface = match self {
            Self::Sheet(sheet) => return (sheet.vertices.clone(), sheet.indices.to_vec()),
            Self::Sphere => solids::of(&Shape::sphere(1.0)),
            Self::Capsule => solids::of(&Shape::capsule(APART, 1.0)),
            Self::Box => solids::of(&Shape::box_half([1.0; 3])),
            Self::Cylinder => solids::of(&Shape::cylinder(1.0, 1.0)),
            &Self::Cone { bottom, top } => solids::of(&Shape::Cone {
                half_height: 1.0,
                radius_bottom: bottom,
                radius_top: top,
            }),
            Self::Square => square(),
            Self::Hull(hull) => solids::of(&Shape::Hull(Arc::clone(hull))),
            Self::Mesh(mesh) => solids::of(&Shape::Mesh(Arc::clone(mesh))),
            Self::Other | Self::Visual(..) => Surface::default(),
        };
        // A hull has true edges; the triangles of a mesh often approximate a smooth surface.
        let crease = if matches!(self, Self::Mesh(_)) { 0.8 } else { 0.999 };
        let (mut vertices, indices) = shaded(&surface, crease);
        if matches!(self, Self::Capsule) {
            for vertex in &mut vertices {
                vertex.end = vertex.place[1].signum();
                vertex.place[1] -= vertex.end * APART;
            }
        }
        (vertices, indices)
    }
}

fn square() -> Surface {
    Surface {
        points: [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
            .map(|(x, z)| Vec3::from([x, 0.0, z]))
            .to_vec(),
        normals: vec![Vec3::Y; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Vertices with a normal at every corner. If the surface has none, a normal is the mean over
/// triangles around the point. It counts those whose normals have at least the cosine `crease` with
/// the corner's own.
fn shaded(surface: &Surface, crease: f32) -> (Vec<Vertex>, Vec<u32>) {
    let Surface { points, normals, triangles } = surface;
    if normals.len() == points.len() {
        let vertices = points.iter().zip(normals).map(|(p, n)| Vertex::new(*p, *n)).collect();
        return (vertices, triangles.iter().flatten().copied().collect());
    }
    let corner = |t: &[u32; 3]| t.map(|i| points.get(i as usize).copied().unwrap_or(Vec3::ZERO));
    let flat: Vec<Vec3> = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = corner(t);
            (b - a).cross(c - a)
        })
        .collect();
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for (number, triangle) in triangles.iter().enumerate() {
        for &i in triangle {
            if let Some(list) = around.get_mut(i as usize) {
                list.push(number);
            }
        }
    }
    let mut vertices = Vec::with_capacity(3 * triangles.len());
    for (triangle, own) in triangles.iter().zip(&flat) {
        let unit = own.normalize_or(Vec3::Y);
        for (place, &i) in corner(triangle).into_iter().zip(triangle) {
            let alike = |other: &&usize| flat[**other].normalize_or(Vec3::ZERO).dot(unit) >= crease;
            let near = around.get(i as usize).into_iter().flatten().filter(alike);
            let sum = near.fold(Vec3::ZERO, |sum, other| sum + flat[*other]);
            vertices.push(Vertex::new(place, sum.normalize_or(unit)));
        }
    }
    let indices = (0_u32..).take(vertices.len()).collect();
    (vertices, indices)
}
