//! Bodies on triangle meshes.

use std::sync::Arc;

use drystone::{BodyDef, Hull, Material, Mesh, Shape, ShapeDef, Vec3, World, vec3};

const DT: f32 = 1.0 / 60.0;

/// A flat sheet at y = 0 in squares of 0.37 m over [-12, 12]², each of two triangles.
fn sheet() -> Shape {
    let n: u16 = 64;
    let at = |i: u16| 0.37 * (f32::from(i) - 32.0);
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..=n {
        for k in 0..=n {
            vertices.push(vec3(at(i), 0.0, at(k)));
        }
    }
    for i in 0..n {
        for k in 0..n {
            let a = u32::from(i) * u32::from(n + 1) + u32::from(k);
            let b = a + u32::from(n) + 1;
            triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]);
        }
    }
    Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()))
}

fn prism() -> Shape {
    let h = 3.0_f32.sqrt() * 0.2;
    let rim = [(0.4, 0.0), (0.2, h), (-0.2, h), (-0.4, 0.0), (-0.2, -h), (0.2, -h)];
    let points: Vec<Vec3> =
        [-0.3, 0.3].iter().flat_map(|y| rim.map(|(x, z)| vec3(x, *y, z))).collect();
    Shape::Hull(Arc::new(Hull::from_points(&points).unwrap()))
}

/// Velocity and spin of a body after it slid over `ground` for two seconds.
fn slide(ground: Shape, body: Shape, friction: f32) -> (Vec3, Vec3) {
    let material = Material { friction, ..Material::default() };
    let mut world = World::default();
    world
        .add_body(BodyDef::fixed().with_shape(ShapeDef::new(ground).with_material(material)))
        .unwrap();
    let def = BodyDef::dynamic()
        .with_position([-8.0, 0.3, -3.0])
        .with_linear_velocity([5.0, 0.0, 1.7])
        .with_shape(ShapeDef::new(body).with_material(material));
    let id = world.add_body(def).unwrap();
    for _ in 0..120 {
        world.step(DT);
        // Inner edges do not lift the body: only the motion of a box that falls by less than the
        // rest offset, 5e-5 m, remains.
        let v = world.body(id).unwrap().linear_velocity();
        assert!(v.y.abs() < 0.01, "{v:?}");
    }
    let body = world.body(id).unwrap();
    (body.linear_velocity(), body.angular_velocity())
}

#[test]
fn inner_edges_neither_brake_nor_turn_what_slides_over_them() {
    for body in [Shape::box_half([0.5, 0.3, 0.4]), prism(), Shape::cylinder(0.3, 0.4)] {
        let (v, w) = slide(sheet(), body, 0.0);
        // 960 substeps of rounding at 5 m/s, half an ulp (2.4e-7) each, at random.
        assert!((v - vec3(5.0, 0.0, 1.7)).length() < 1e-3, "{v:?}");
        assert!(w.length() < 1e-3, "{w:?}");
    }
}

#[test]
fn friction_on_a_mesh_is_that_on_a_plane() {
    for body in [Shape::box_half([0.5, 0.3, 0.4]), prism()] {
        let plane = Shape::half_space([0.0, 1.0, 0.0], 0.0);
        let ((on_mesh, _), (on_plane, _)) =
            (slide(sheet(), body.clone(), 0.2), slide(plane, body, 0.2));
        // v0 - mu g t, for both; the box settles on its contacts within the first steps, by 1 % of
        // g t.
        let speed = vec3(5.0, 0.0, 1.7).length() - 0.2 * 9.81 * 2.0;
        for v in [on_mesh, on_plane] {
            assert!((v.length() - speed).abs() < 0.04, "{on_mesh:?} {on_plane:?} {speed}");
        }
        assert!((on_mesh - on_plane).length() < 0.01, "{on_mesh:?} {on_plane:?}");
    }
}

#[test]
fn a_sheet_holds_from_both_sides() {
    for side in [1.0, -1.0] {
        for body in [Shape::box_half([0.5, 0.3, 0.4]), prism(), Shape::sphere(0.3)] {
            let mut world = World::default();
            world.set_gravity([0.0, -9.81 * side, 0.0]);
            world.add_body(BodyDef::fixed().with_shape(ShapeDef::new(sheet()))).unwrap();
            let def = BodyDef::dynamic().with_position([0.1, 2.0 * side, 0.2]);
            let id = world.add_body(def.with_shape(ShapeDef::new(body))).unwrap();
            for _ in 0..180 {
                world.step(DT);
            }
            // At rest on the sheet, within slop and sag: some 1e-4 m.
            let y = world.body(id).unwrap().position().y;
            assert!((y - 0.3 * side).abs() < 1e-3, "{y}");
        }
    }
}
