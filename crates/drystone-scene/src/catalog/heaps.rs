//! Many bodies dropped somewhere.

use std::sync::Arc;

use drystone::{BodyDef, Mesh, Shape, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{GROUND, Lcg, hull, real};
use crate::scene::Scene;

/// Distance at which the bodies of `pile` are let go [m]: no two of them can touch.
const PILE_PITCH: f32 = 0.8;

pub(super) fn pile(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let n = values.whole("n");
    scene.seconds = 15.0;
    let side = (1..).find(|k| k * k * k >= n).unwrap_or(1);
    let half = 0.5 * PILE_PITCH * real(side) + 0.2;
    let rim = 1.0 + 0.2 * real(side);
    let tray = BodyDef::fixed()
        .with_shape(
            ShapeDef::box_half(vec3(half + 1.0, 0.5, half + 1.0)).with_position(-0.5 * Vec3::Y),
        )
        .with_shape(wall_shape(vec3(0.5, rim, half + 1.0), vec3(half + 0.5, rim, 0.0)))
        .with_shape(wall_shape(vec3(0.5, rim, half + 1.0), vec3(-half - 0.5, rim, 0.0)))
        .with_shape(wall_shape(vec3(half + 1.0, rim, 0.5), vec3(0.0, rim, half + 0.5)))
        .with_shape(wall_shape(vec3(half + 1.0, rim, 0.5), vec3(0.0, rim, -half - 0.5)));
    scene.add(GROUND, tray);

    let mut random = Lcg::new(7);
    let mut stones = Vec::new();
    for corners in [6, 8, 10, 12] {
        let radius = 0.2 + 0.01 * real(corners);
        let points: Vec<Vec3> = (0..corners).map(|_| random.direction() * radius).collect();
        stones.push(hull(&points)?);
    }
    for i in 0..n {
        let (layer, place) = (i / (side * side), i % (side * side));
        let middle = 0.5 * real(side - 1);
        let position = vec3(
            PILE_PITCH * (real(place % side) - middle),
            0.6 + PILE_PITCH * real(layer),
            PILE_PITCH * (real(place / side) - middle),
        );
        let mut size = || random.between(0.12, 0.22);
        let (kind, shape) = match i % 6 {
            0 => ("ball", Shape::sphere(size())),
            1 => ("box", Shape::box_half(vec3(size(), size(), size()))),
            2 => ("capsule", Shape::capsule(size(), 0.8 * size())),
            3 => ("cylinder", Shape::cylinder(size(), size())),
            4 => ("cone", Shape::cone(size(), size())),
            _ => ("stone", stones[i / 6 % stones.len()].clone()),
        };
        let mut shape = ShapeDef::new(shape);
        shape.material.rolling_resistance = 0.05;
        let def = BodyDef::dynamic()
            .with_position(position)
            .with_rotation(random.rotation())
            .with_shape(shape);
        scene.add(format!("{kind} {i}"), def);
    }
    Ok(scene)
}

fn wall_shape(half: Vec3, position: Vec3) -> ShapeDef {
    ShapeDef::box_half(half).with_position(position)
}

/// A landscape of square columns, 1 m wide, of whole heights.
struct Columns {
    side: usize,
    heights: Vec<u16>,
}

impl Columns {
    /// Random steps up and down along x, and along z.
    fn new(side: usize) -> Self {
        let mut random = Lcg::new(3);
        let mut walk = || {
            let mut height: u16 = 2;
            let step = |_| {
                let r = random.between(0.0, 1.0);
                if r < 0.3 {
                    height = height.saturating_sub(1);
                } else if r > 0.7 {
                    height = (height + 1).min(4);
                }
                height
            };
            (0..side).map(step).collect::<Vec<u16>>()
        };
        let (along_x, along_z) = (walk(), walk());
        let heights = along_z.iter().flat_map(|z| along_x.iter().map(move |x| x + z)).collect();
        Self { side, heights }
    }

    fn height(&self, i: usize, j: usize) -> u16 {
        self.heights[j * self.side + i]
    }

    /// Its surface, centered on the y axis: a square on each column and one in each step.
    fn mesh(&self) -> Result<Mesh, CatalogError> {
        let mut vertices: Vec<Vec3> = Vec::new();
        let mut triangles = Vec::new();
        let center = vec3(0.5 * real(self.side), 0.0, 0.5 * real(self.side));
        let mut number: u32 = 0;
        let mut add_square = |corners: [Vec3; 4]| {
            vertices.extend(corners.map(|c| c - center));
            triangles.push([number, number + 1, number + 2]);
            triangles.push([number, number + 2, number + 3]);
            number += 4;
        };
        for j in 0..self.side {
            for i in 0..self.side {
                let (x, z, top) = (real(i), real(j), self.height(i, j));
                let h = f32::from(top);
                let at = |dx: f32, y: f32, dz: f32| vec3(x + dx, y, z + dz);
                add_square([at(0.0, h, 0.0), at(0.0, h, 1.0), at(1.0, h, 1.0), at(1.0, h, 0.0)]);
                if i + 1 < self.side && self.height(i + 1, j) != top {
                    let o = f32::from(self.height(i + 1, j));
                    add_square([
                        at(1.0, h, 0.0),
                        at(1.0, h, 1.0),
                        at(1.0, o, 1.0),
                        at(1.0, o, 0.0),
                    ]);
                }
                if j + 1 < self.side && self.height(i, j + 1) != top {
                    let o = f32::from(self.height(i, j + 1));
                    add_square([
                        at(0.0, h, 1.0),
                        at(1.0, h, 1.0),
                        at(1.0, o, 1.0),
                        at(0.0, o, 1.0),
                    ]);
                }
            }
        }
        Ok(Mesh::new(vertices, triangles)?)
    }
}

pub(super) fn voxels(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (cells, boxes) = (values.whole("cells"), values.whole("boxes"));
    let columns = Columns::new(cells);
    let land = Shape::Mesh(Arc::new(columns.mesh()?));
    scene.add(GROUND, BodyDef::fixed().with_shape(ShapeDef::new(land)));
    let mut random = Lcg::new(5);
    let across = cells - 4;
    let half_width = 0.5 * real(across - 1);
    for i in 0..boxes {
        let (layer, place) = (i / (across * across), i % (across * across));
        let x = real(place % across) - half_width;
        let z = real(place / across) - half_width;
        let mut size = || random.between(0.2, 0.4);
        let cube = ShapeDef::box_half(vec3(size(), size(), size()));
        let def = BodyDef::dynamic()
            .with_position(vec3(x, 10.0 + 1.6 * real(layer), z))
            .with_rotation(random.rotation())
            .with_linear_velocity(vec3(1.0, 0.0, 0.5))
            .with_shape(cube);
        scene.add(format!("box {i}"), def);
    }
    Ok(scene)
}
