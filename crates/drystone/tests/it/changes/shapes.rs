//! Changes to existing shapes.

use std::sync::Arc;

use drystone::{
    BodyDef, BodyId, BodyKind, DefError, Filter, Mesh, Pose, Shape, ShapeDef, ShapeId, Vec3, World,
    vec3,
};

use super::{DT, FLOORS, Floor, GRAVITY, Stack, brittle, glued, in_all_states, shape_of};

#[test]
fn shapes_meet_others_in_any_state() {
    in_all_states(&[
        (
            "meets nothing",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_filter(Filter {
                    layers: 1,
                    mask: 0,
                    ..Filter::default()
                });
                Ok(())
            }],
        ),
        (
            "meets nothing and all again",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_filter(Filter {
                    layers: 1,
                    mask: 0,
                    ..Filter::default()
                });
                w.shape_mut(s).unwrap().set_filter(Filter::default());
                Ok(())
            }],
        ),
        ("sensor", &[|w, _, s| w.shape_mut(s).unwrap().set_sensor(true)]),
        (
            "sensor and back",
            &[
                |w, _, s| w.shape_mut(s).unwrap().set_sensor(true),
                |w, _, s| w.shape_mut(s).unwrap().set_sensor(false),
            ],
        ),
    ]);
}

#[test]
fn shapes_get_another_mass_place_and_form_in_any_state() {
    in_all_states(&[
        ("light", &[|w, _, s| w.shape_mut(s).unwrap().set_density(30.0)]),
        ("heavy", &[|w, _, s| w.shape_mut(s).unwrap().set_density(3.0e4)]),
        ("without density", &[|w, _, s| w.shape_mut(s).unwrap().set_density(0.0)]),
        ("moved", &[|w, _, s| w.shape_mut(s).unwrap().set_local_pose(Pose::at([0.3, 0.1, 0.0]))]),
        (
            "moved far",
            &[|w, _, s| w.shape_mut(s).unwrap().set_local_pose(Pose::at([9.0, 0.0, 0.0]))],
        ),
        ("ball", &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::sphere(0.5))]),
        ("small", &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::box_half([0.2; 3]))]),
        ("large", &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::box_half([0.6; 3]))]),
        (
            "half-space",
            &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::half_space(Vec3::Y, 0.25))],
        ),
        (
            "mesh and back",
            &[
                |w, _, s| {
                    let corners = vec![
                        [-2.0, 0.2, -2.0],
                        [-2.0, 0.2, 2.0],
                        [2.0, 0.3, 2.0],
                        [2.0, 0.3, -2.0],
                    ];
                    let corners = corners.into_iter().map(Vec3::from).collect();
                    let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
                    w.shape_mut(s).unwrap().set_geometry(Shape::Mesh(Arc::new(mesh)))
                },
                |w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::cylinder(0.3, 1.0)),
            ],
        ),
        (
            "disabled",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_enabled(false);
                Ok(())
            }],
        ),
        (
            "disabled and back",
            &[
                |w, _, s| {
                    w.shape_mut(s).unwrap().set_enabled(false);
                    Ok(())
                },
                |w, _, s| {
                    w.shape_mut(s).unwrap().set_enabled(true);
                    Ok(())
                },
            ],
        ),
        (
            "disabled, with its body",
            &[
                |w, b, s| {
                    w.shape_mut(s).unwrap().set_enabled(false);
                    w.body_mut(b).unwrap().set_enabled(false);
                    Ok(())
                },
                |w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::box_half([0.4; 3])),
                |w, b, _| {
                    w.body_mut(b).unwrap().set_enabled(true);
                    Ok(())
                },
            ],
        ),
        (
            "disabled, of a body of another kind",
            &[
                |w, b, s| {
                    w.shape_mut(s).unwrap().set_enabled(false);
                    let kind = w.body(b).unwrap().kind();
                    let other =
                        if kind == BodyKind::Static { BodyKind::Dynamic } else { BodyKind::Static };
                    w.body_mut(b).unwrap().set_kind(other)
                },
                |w, _, s| {
                    w.shape_mut(s).unwrap().set_enabled(true);
                    Ok(())
                },
            ],
        ),
        (
            "more and fewer shapes",
            &[|w, b, s| {
                w.add_shape(b, ShapeDef::sphere(0.3).with_position([0.9, 0.0, 0.0]))?;
                w.remove_shape(s);
                Ok(())
            }],
        ),
        (
            "user data",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_user_data(7);
                assert_eq!(w.shape(s).unwrap().user_data(), 7);
                Ok(())
            }],
        ),
    ]);
}

#[test]
fn a_shape_given_the_form_and_place_it_has_ends_no_touch_and_moves_nothing() {
    for under in FLOORS {
        for cube in [0, 2] {
            for sleeps in [false, true] {
                let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
                stack = if sleeps { stack.asleep() } else { stack };
                let shape = shape_of(&stack.world, stack.cubes[cube]);
                let mut shape = stack.world.shape_mut(shape).unwrap();
                shape.set_geometry(Shape::box_half([0.5; 3])).unwrap();
                shape.set_local_pose(Pose::IDENTITY).unwrap();
                shape.set_density(1000.0).unwrap();
                for _ in 0..3 {
                    stack.world.step(DT);
                    let events = stack.world.events();
                    let touches = (&events.contact_begin, &events.contact_end);
                    assert_eq!(touches, (&vec![], &vec![]), "{under:?}, cube {cube}");
                }
                stack.stands(&format!("{under:?}, cube {cube}, sleeps: {sleeps}"), 40, 0.01);
            }
        }
    }
}

#[test]
fn densities_and_filters_that_come_back_move_nothing_that_stands() {
    for under in FLOORS {
        let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
        for (cube, density) in [(1, 100.0), (3, 5000.0)] {
            let shape = shape_of(&stack.world, stack.cubes[cube]);
            let before = stack.world.body(stack.cubes[cube]).unwrap().mass();
            stack.world.shape_mut(shape).unwrap().set_density(density).unwrap();
            let now = stack.world.body(stack.cubes[cube]).unwrap().mass();
            assert!((now / before - density / 1000.0).abs() < 1.0e-5, "{now} kg");
            let limit = stack.speed_of_new_loads();
            let of = format!("{under:?}, cube {cube} of {density} kg/m³");
            stack.is_no_faster(&of, 40, 0.02, limit);
        }
        let shape = shape_of(&stack.world, stack.floor);
        let nothing = Filter { layers: 1, mask: 0, ..Filter::default() };
        stack.world.shape_mut(shape).unwrap().set_filter(nothing);
        assert_eq!(stack.world.shape(shape).unwrap().filter(), nothing);
        stack.world.shape_mut(shape).unwrap().set_filter(Filter::default());
        stack.stands(&format!("{under:?}, filter"), 40, 0.02);
    }
}

#[test]
fn a_density_moves_the_center_of_mass_and_no_shape() {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let part = |x: f32| ShapeDef::box_half([0.5; 3]).with_position([x, 0.0, 0.0]);
    let dumbbell = BodyDef::dynamic()
        .with_position([3.0, 4.0, 5.0])
        .with_angular_velocity([0.0, 0.0, 3.0])
        .with_shape(part(-1.0))
        .with_shape(part(1.0));
    let dumbbell = world.add_body(dumbbell).unwrap();
    let shapes: Vec<ShapeId> = world.body(dumbbell).unwrap().shapes().collect();
    let places = |world: &World| -> Vec<Vec3> {
        shapes.iter().map(|s| world.shape(*s).unwrap().pose().position).collect()
    };
    let before = places(&world);
    let tip = world.body(dumbbell).unwrap().velocity_at([5.0, 4.0, 5.0]);
    world.shape_mut(shapes[1]).unwrap().set_density(3000.0).unwrap();
    let body = world.body(dumbbell).unwrap();
    assert_eq!(body.mass(), 4000.0);
    assert!((body.center_of_mass() - vec3(3.5, 4.0, 5.0)).length() < 1.0e-6);
    assert!((body.velocity_at([5.0, 4.0, 5.0]) - tip).length() < 1.0e-5);
    // Two cubes of 1 and 3 t at distances of 1.5 and 0.5 m from the center.
    let across = 4000.0 / 6.0 + 1000.0 * 2.25 + 3000.0 * 0.25;
    assert!((body.inertia().zz / across - 1.0).abs() < 1.0e-5);
    for (a, b) in before.iter().zip(places(&world)) {
        assert!((*a - b).length() < 1.0e-6);
    }
}

#[test]
fn what_carries_no_longer_lets_fall_what_sleeps_on_it() {
    type Let = fn(&mut World, ShapeId);
    let ways: [(&str, Let); 5] = [
        ("filter", |w, s| {
            let nothing = Filter { layers: 1, mask: 0, ..Filter::default() };
            w.shape_mut(s).unwrap().set_filter(nothing);
        }),
        ("sensor", |w, s| w.shape_mut(s).unwrap().set_sensor(true).unwrap()),
        ("disabled", |w, s| w.shape_mut(s).unwrap().set_enabled(false)),
        ("moved", |w, s| {
            w.shape_mut(s).unwrap().set_local_pose(Pose::at([0.0, -20.0, 0.0])).unwrap();
        }),
        ("another form", |w, s| {
            w.shape_mut(s).unwrap().set_geometry(Shape::half_space(Vec3::Y, -20.0)).unwrap();
        }),
    ];
    for under in FLOORS {
        for (name, way) in ways {
            let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic).asleep();
            let before = stack.places();
            let shape = shape_of(&stack.world, stack.floor);
            way(&mut stack.world, shape);
            let of = format!("{under:?}, {name}");
            let (mut ends, mut entered) = (0, 0);
            for _ in 0..20 {
                stack.world.step(DT);
                ends += stack.world.events().contact_end.len();
                entered += stack.world.events().sensor_enter.len();
            }
            assert_eq!((ends, entered), (1, usize::from(name == "sensor")), "{of}");
            let fall = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
            for (a, b) in before.iter().zip(stack.places()) {
                assert!((a.y - b.y - fall).abs() < 0.02, "{of}: {} m, not {fall}", a.y - b.y);
            }
        }
    }
}

#[test]
fn a_sensor_that_is_moved_sees_what_sleeps_where_it_comes_to() {
    for kind in [BodyKind::Static, BodyKind::Kinematic] {
        let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic).asleep();
        let gate = BodyDef { kind, ..BodyDef::default() }.with_position([20.0, 2.0, 0.0]);
        let gate = gate.with_shape(ShapeDef::box_half([1.0, 0.2, 1.0]).as_sensor());
        let gate = stack.world.add_body(gate).unwrap();
        let shape = shape_of(&stack.world, gate);
        stack.steps(2);
        assert!(stack.world.events().sensor_enter.is_empty());
        let mut moved = stack.world.shape_mut(shape).unwrap();
        moved.set_local_pose(Pose::at([-20.0, 0.4, 0.0])).unwrap();
        stack.world.step(DT);
        let seen: Vec<BodyId> =
            stack.world.events().sensor_enter.iter().map(|e| e.visitor_body).collect();
        assert_eq!(seen, [stack.cubes[2]], "{kind:?}");
        let mut moved = stack.world.shape_mut(shape).unwrap();
        moved.set_geometry(Shape::box_half([1.0, 1.2, 1.0])).unwrap();
        stack.world.step(DT);
        assert_eq!(stack.world.events().sensor_enter.len(), 2, "{kind:?}");
        stack.world.shape_mut(shape).unwrap().set_enabled(false);
        stack.world.step(DT);
        assert_eq!(stack.world.events().sensor_exit.len(), 3, "{kind:?}");
    }
}

#[test]
fn what_is_disabled_is_found_by_no_query_and_stops_nothing_fast() {
    for bullet_is_out in [false, true] {
        let mut world = World::default();
        world.set_gravity([0.0; 3]);
        let wall = BodyDef::fixed().with_position([5.0, 0.0, 0.0]);
        let wall = world.add_body(wall.with_shape(ShapeDef::box_half([0.05, 2.0, 2.0]))).unwrap();
        let bullet = BodyDef::dynamic().with_linear_velocity([400.0, 0.0, 0.0]);
        let bullet = world.add_body(bullet.with_shape(ShapeDef::box_half([0.1; 3]))).unwrap();
        let out = shape_of(&world, if bullet_is_out { bullet } else { wall });
        let mass = world.body(bullet).unwrap().mass();
        world.shape_mut(out).unwrap().set_enabled(false);
        assert!(!world.shape(out).unwrap().is_enabled());
        assert_eq!(world.body(bullet).unwrap().mass(), mass);
        let query = world.query();
        let from = if bullet_is_out { vec3(-1.0, 0.0, 0.0) } else { vec3(4.0, 0.0, 0.0) };
        assert_eq!(query.cast_ray(from, Vec3::X * 2.0, Filter::default()).unwrap(), None);
        assert!(query.overlap_point(from + Vec3::X, Filter::default()).unwrap().is_empty());
        for _ in 0..3 {
            world.step(DT);
            assert!(world.events().contact_begin.is_empty());
        }
        let way = world.body(bullet).unwrap().position().x;
        assert!((way - 20.0).abs() < 1.0e-3, "{way} m");
        world.shape_mut(out).unwrap().set_enabled(true);
        let hit = world.query().cast_ray([20.0, 0.0, -3.0], [0.0, 0.0, 6.0], Filter::default());
        assert_eq!(hit.unwrap().map(|hit| hit.body), Some(bullet));
    }
}

#[test]
fn what_no_shape_can_be_is_refused_by_name() {
    let field = |result: Result<(), DefError>| result.unwrap_err().field().to_owned();
    let mut world = World::default();
    let cube = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    let cube = shape_of(&world, cube);
    let before = world.snapshot();
    let mut shape = world.shape_mut(cube).unwrap();
    assert_eq!(field(shape.set_density(-1.0)), "density");
    assert_eq!(field(shape.set_density(f32::NAN)), "density");
    assert_eq!(field(shape.set_density(0.0)), "mass");
    assert_eq!(field(shape.set_local_pose(Pose::at([f32::INFINITY; 3]))), "pose.position");
    assert_eq!(field(shape.set_geometry(Shape::sphere(-1.0))), "radius");
    assert_eq!(field(shape.set_geometry(Shape::half_space(Vec3::Y, 0.0))), "shape");
    assert_eq!(field(shape.set_geometry(Shape::sphere(1.0e-12))), "radius");
    assert!(world.snapshot() == before);
    let (mut world, body) = glued();
    let piece = shape_of(&world, body);
    let before = world.snapshot();
    let mut shape = world.shape_mut(piece).unwrap();
    assert_eq!(field(shape.set_geometry(Shape::sphere(0.5))), "shape");
    assert_eq!(field(shape.set_local_pose(Pose::IDENTITY)), "shape");
    assert_eq!(field(shape.set_density(0.0)), "density");
    assert!(world.snapshot() == before);
    world.shape_mut(piece).unwrap().set_density(2000.0).unwrap();
    let (mut world, body) = brittle();
    let whole = shape_of(&world, body);
    let mut shape = world.shape_mut(whole).unwrap();
    assert_eq!(field(shape.set_geometry(Shape::sphere(0.5))), "shape");
    shape.set_geometry(Shape::box_half([0.4, 0.5, 0.4])).unwrap();
}
