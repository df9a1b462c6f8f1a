//! Debug lines lie on the objects that they show.

use drystone::draw::{DebugColor, DebugDraw, DebugDrawOptions, DebugTint};
use drystone::geometry::Aabb;
use drystone::joint::Distance;
use drystone::particle::RopeDef;
use drystone::query::QueryFilter;
use drystone::{
    BodyDef, Hull, JointDef, Mesh, Quat, Shape, ShapeDef, Vec3, World, WorldConfig, vec3,
};
use std::collections::BTreeSet;
use std::sync::Arc;

#[derive(Default, PartialEq, Debug)]
struct Lines {
    lines: Vec<(Vec3, Vec3, DebugColor)>,
    points: Vec<(Vec3, DebugColor)>,
}

impl DebugDraw for Lines {
    fn line(&mut self, a: Vec3, b: Vec3, color: DebugColor) {
        self.lines.push((a, b, color));
    }

    fn point(&mut self, at: Vec3, color: DebugColor) {
        self.points.push((at, color));
    }
}

fn drawn(world: &World, options: DebugDrawOptions) -> Lines {
    let mut lines = Lines::default();
    world.debug_draw(&mut lines, &options);
    lines
}

const SHAPES: DebugDrawOptions = DebugDrawOptions { shapes: true, ..DebugDrawOptions::NOTHING };

fn alone(shape: ShapeDef) -> World {
    let mut world = World::default();
    let turn = Quat::from_axis_angle(vec3(0.6, 0.0, 0.8), 0.7);
    let body = BodyDef::fixed().with_position([3.0, -2.0, 1.0]).with_rotation(turn);
    world.add_body(body.with_shape(shape.with_position([0.2, 0.1, 0.0]))).unwrap();
    world
}

#[test]
fn outlines_lie_on_surfaces() {
    let tip = [[0.3, -0.2, 0.1], [-0.3, -0.2, 0.2], [0.0, -0.2, -0.3], [0.1, 0.4, 0.0]];
    let hull = Hull::from_points(&tip.map(Vec3::from)).unwrap();
    let corners = vec![vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0)];
    let mesh = Mesh::new(corners, vec![[0, 2, 1]]).unwrap();
    let (circle, sides) = (24, 4);
    let shapes = [
        (ShapeDef::sphere(0.7), 3 * circle),
        (ShapeDef::box_half([0.1, 0.2, 0.3]), 12),
        (ShapeDef::capsule(0.5, 0.2), 6 * circle + sides),
        (ShapeDef::cylinder(0.5, 0.2), 2 * circle + sides),
        (ShapeDef::cone(0.5, 0.2), circle + sides),
        (ShapeDef::new(Shape::Hull(Arc::new(hull))), 6),
        (ShapeDef::new(Shape::Mesh(Arc::new(mesh))), 3),
    ];
    for (shape, count) in shapes {
        let world = alone(shape.clone());
        let lines = drawn(&world, SHAPES).lines;
        assert_eq!(lines.len(), count, "{shape:?}");
        let middle = world.bodies().next().unwrap().pose().point(vec3(0.2, 0.1, 0.0));
        let is_mesh = matches!(shape.shape, Shape::Mesh(_));
        let meets = |at: Vec3| {
            // A ball of 0.01 mm.
            !world.query().overlap_point(at, QueryFilter::default()).unwrap().is_empty()
        };
        for end in lines.iter().flat_map(|(a, b, _)| [*a, *b]) {
            assert!(meets(end + (middle - end) * 1.0e-4), "{shape:?}: {end:?} is outside");
            assert!(
                is_mesh || !meets(end + (end - middle) * 1.0e-3),
                "{shape:?}: {end:?} is inside"
            );
        }
    }
}

#[test]
fn what_is_not_asked_for_is_not_drawn_and_a_region_leaves_out_the_rest() {
    let mut world = World::default();
    for x in [0.0, 10.0] {
        let body = BodyDef::dynamic().with_position([x, 0.0, 0.0]);
        world.add_body(body.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    }
    assert_eq!(drawn(&world, DebugDrawOptions::NOTHING), Lines::default());
    assert_eq!(drawn(&world, SHAPES).lines.len(), 24);
    let region = Some(Aabb::new(Vec3::splat(-1.0), Vec3::splat(1.0)));
    let near = drawn(&world, DebugDrawOptions { region, bounds: true, axes: true, ..SHAPES });
    assert_eq!(near.lines.len(), 12 + 12 + 3);
    assert!(near.lines.iter().all(|(a, b, _)| a.x < 2.0 && b.x < 2.0));
    // An invalid size is 0: no axis has a length, and no number is NaN.
    for size in [f32::NAN, f32::INFINITY, -1.0] {
        let axes = DebugDrawOptions { axes: true, size, ..DebugDrawOptions::NOTHING };
        assert!(drawn(&world, axes).lines.iter().all(|(a, b, _)| a == b));
    }
}

#[test]
fn contacts_joints_particles_and_islands_show() {
    let mut world = World::new(WorldConfig::default()).unwrap();
    let floor = ShapeDef::half_space(Vec3::Y, 0.0);
    let floor = world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let cube = |x: f32, y: f32| {
        let body = BodyDef::dynamic().with_position([x, y, 0.0]);
        body.with_shape(ShapeDef::box_half([0.5; 3]))
    };
    for (x, y) in [(0.0, 0.5), (0.0, 1.5), (5.0, 0.5)] {
        world.add_body(cube(x, y)).unwrap();
    }
    let hung = world.add_body(cube(10.0, 3.0)).unwrap();
    let rod = JointDef::new(floor, hung, Distance::exact(2.0));
    world.add_joint(rod.with_anchors([10.0, 5.0, 0.0], [0.0; 3])).unwrap();
    world.add_rope(RopeDef::between([20.0, 5.0, 0.0], [21.0, 5.0, 0.0], 4)).unwrap();
    (0..20).for_each(|_| world.step(1.0 / 60.0));
    let only = DebugDrawOptions::NOTHING;
    let contacts = drawn(&world, DebugDrawOptions { contacts: true, size: 0.5, ..only });
    assert_eq!(contacts.points.len(), 12);
    let normals = contacts
        .lines
        .iter()
        .filter(|(a, b, _)| (*b - *a).try_normalize().is_some_and(|n| n.y.abs() > 0.99));
    let longest = normals.map(|(a, b, _)| (*b - *a).length()).fold(0.0, f32::max);
    // The contact with the largest load has the full size, plus a tenth, as every contact.
    assert!((longest - 0.55).abs() < 1.0e-4, "{longest}");
    let joints = drawn(&world, DebugDrawOptions { joints: true, limits: true, ..only });
    assert_eq!((joints.lines.len(), joints.points.len()), (2, 2));
    let particles = drawn(&world, DebugDrawOptions { particles: true, ..only });
    assert_eq!((particles.lines.len(), particles.points.len()), (4, 5));
    let tint = DebugTint::Island;
    let colors = |lines: Lines| -> BTreeSet<[u8; 3]> {
        lines.lines.iter().map(|(_, _, c)| [c.red, c.green, c.blue]).collect()
    };
    // The floor, two islands and the hanging bodies; by kinds, the floor and the awake bodies.
    assert_eq!(colors(drawn(&world, DebugDrawOptions { tint, ..SHAPES })).len(), 4);
    assert_eq!(colors(drawn(&world, SHAPES)).len(), 2);
}
