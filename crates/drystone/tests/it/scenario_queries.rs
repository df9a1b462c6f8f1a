//! Shape casts, and nearest-shape queries.

use drystone::{BodyDef, Filter, Mesh, Pose, Quat, Shape, ShapeDef, Vec3, World, vec3};
use std::sync::Arc;

/// A floor of triangles with a wall at x = 2, a ball, a sensor, and a glass that only layer 2 hits.
fn room() -> World {
    let mut world = World::default();
    let square = |p: Vec3, u: Vec3, v: Vec3| [p, p + u, p + u + v, p + v];
    let floor = square(vec3(-5.0, 0.0, -5.0), vec3(10.0, 0.0, 0.0), vec3(0.0, 0.0, 10.0));
    let wall = square(vec3(2.0, 0.0, -5.0), vec3(0.0, 4.0, 0.0), vec3(0.0, 0.0, 10.0));
    let mesh = Mesh::new([floor, wall].concat(), vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
    let mesh = ShapeDef::new(Shape::Mesh(Arc::new(mesh.unwrap())));
    world.add_body(BodyDef::fixed().with_shape(mesh)).unwrap();
    let ball = BodyDef::dynamic().with_position([-2.0, 1.0, 0.0]);
    world.add_body(ball.with_shape(ShapeDef::sphere(0.5))).unwrap();
    let sensor = ShapeDef { sensor: true, ..ShapeDef::box_half([0.1, 1.0, 1.0]) };
    world.add_body(BodyDef::fixed().with_position([1.0, 1.0, 0.0]).with_shape(sensor)).unwrap();
    let glass = ShapeDef { filter: Filter::layers(2, 2), ..ShapeDef::box_half([0.1, 1.0, 1.0]) };
    world.add_body(BodyDef::fixed().with_position([0.8, 1.0, 0.0]).with_shape(glass)).unwrap();
    world
}

#[test]
fn a_capsule_slides_over_the_floor_up_to_the_wall() {
    let world = room();
    let (query, capsule) = (world.query(), Shape::capsule(0.5, 0.25));
    let all = Filter::layers(1, 1);
    // Slightly above the floor, as movers stand: the wall is an obstacle, the floor is not.
    let stands = Pose::at([0.0, 0.751, 0.0]);
    let hit = query.cast_shape(&capsule, stands, [4.0, 0.0, 0.0], all).unwrap().unwrap();
    assert!((hit.fraction * 4.0 - 1.75).abs() < 1e-5, "{hit:?}");
    assert!((hit.normal - vec3(-1.0, 0.0, 0.0)).length() < 1e-4, "{hit:?}");
    assert!((hit.point.x - 2.0).abs() < 1e-5);
    // The glass is an obstacle only in layer 2.
    let both = Filter::layers(3, 3);
    let hit = query.cast_shape(&capsule, stands, [4.0, 0.0, 0.0], both).unwrap().unwrap();
    assert!((hit.fraction * 4.0 - 0.45).abs() < 1e-5, "{hit:?}");
    // Down, by that small distance.
    let hit = query.cast_shape(&capsule, stands, [0.0, -0.1, 0.0], all).unwrap().unwrap();
    assert!((hit.fraction * 0.1 - 0.001).abs() < 1e-5 && hit.normal.y > 0.999, "{hit:?}");
    // Upward, or not far enough: no hit.
    assert!(query.cast_shape(&capsule, stands, [0.0, 1.0, 0.0], all).unwrap().is_none());
    assert!(query.cast_shape(&capsule, stands, [1.7, 0.0, 0.0], all).unwrap().is_none());
}

#[test]
fn a_turned_box_meets_a_ball_with_its_edge_and_an_overlap_at_once() {
    let world = room();
    let (query, cube) = (world.query(), Shape::box_half([0.5; 3]));
    let turned = Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_4);
    let from = Pose::new([-2.0, 4.0, 0.0], turned);
    let hit = query.cast_shape(&cube, from, [0.0, -5.0, 0.0], Filter::default()).unwrap().unwrap();
    let way = 3.0 - 0.5 - 0.5_f32.sqrt();
    assert!((hit.fraction * 5.0 - way).abs() < 1e-5, "{hit:?}");
    assert!((hit.normal - Vec3::Y).length() < 1e-3 && (hit.point.y - 1.5).abs() < 1e-4, "{hit:?}");
    let inside = Pose::at([-2.0, 1.8, 0.0]);
    let hit = query.cast_shape(&cube, inside, [0.0, 5.0, 0.0], Filter::default()).unwrap().unwrap();
    assert!(hit.fraction <= 0.0 && (hit.normal - Vec3::Y).length() < 1e-3, "{hit:?}");
}

#[test]
fn the_nearest_shape_is_found_at_any_distance_and_told_apart_from_an_overlap() {
    let world = room();
    let (query, ball) = (world.query(), Shape::sphere(0.1));
    let near = |at: [f32; 3], reach: f32| {
        query.nearest_shape(&ball, Pose::at(at), reach, Filter::layers(1, 1)).unwrap()
    };
    let found = near([-2.0, 3.0, 0.0], 10.0).unwrap();
    assert!((found.distance - 1.4).abs() < 1e-5 && (found.normal - Vec3::Y).length() < 1e-4);
    assert!((found.own_point - found.point - found.normal * found.distance).length() < 1e-5);
    // The wall is the nearest of ball, floor and wall; also from above, and from very far.
    let found = near([1.5, 2.0, 0.0], 10.0).unwrap();
    assert!((found.distance - 0.4).abs() < 1e-5 && found.normal.x < -0.999, "{found:?}");
    let found = near([0.0, 900.0, 0.0], 1000.0).unwrap();
    assert!((found.distance - ((2.0_f32.powi(2) + 896.0_f32.powi(2)).sqrt() - 0.1)).abs() < 1e-3);
    assert!(near([-2.0, 3.0, 0.0], 1.3).is_none());
    let found = near([-2.0, 1.55, 0.0], 1.0).unwrap();
    assert!((found.distance + 0.05).abs() < 1e-5 && found.normal.y > 0.999, "{found:?}");
}

#[test]
fn questions_that_make_no_sense_are_refused_by_name() {
    let world = room();
    let (query, all) = (world.query(), Filter::default());
    let (ball, here) = (Shape::sphere(0.5), Pose::IDENTITY);
    let plane = Shape::HalfSpace { normal: Vec3::Y, offset: 0.0 };
    let lost = Pose::at([f32::NAN, 0.0, 0.0]);
    for (refused, field) in [
        (query.cast_shape(&plane, here, Vec3::Y, all).unwrap_err(), "shape"),
        (query.cast_shape(&ball, lost, Vec3::Y, all).unwrap_err(), "pose.position"),
        (query.cast_shape(&ball, here, [0.0, f32::INFINITY, 0.0], all).unwrap_err(), "delta"),
        (query.nearest_shape(&ball, here, -1.0, all).unwrap_err(), "reach"),
        (query.nearest_shape(&ball, here, f32::NAN, all).unwrap_err(), "reach"),
        (query.nearest_shape(&Shape::sphere(-1.0), here, 1.0, all).unwrap_err(), "radius"),
    ] {
        assert!(refused.to_string().contains(field), "{refused}");
    }
}
