//! Promises of the public API: bad input is refused by name, stale ids find nothing, nothing
//! panics, events are correct.

use drystone::events::FaultKind;
use drystone::geometry::Aabb;
use drystone::joint::Ball;
use drystone::math::Sym3;
use drystone::threads::{Executor, Team};
use drystone::{
    AxisLocks, BodyDef, BodyId, Filter, JointDef, MassDef, Material, Pose, Quat, Shape, ShapeDef,
    Vec3, World, WorldConfig, vec3,
};
use proptest::prelude::{Strategy, any, prop, prop_oneof, proptest};
use std::sync::Arc;

const DT: f32 = 1.0 / 60.0;

fn ground(world: &mut World) -> BodyId {
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0))).unwrap()
}

fn cube_at(position: [f32; 3]) -> BodyDef {
    BodyDef::dynamic().with_position(position).with_shape(ShapeDef::box_half([0.5, 0.5, 0.5]))
}

fn run(world: &mut World, seconds: f32) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
    for _ in 0..(seconds * 60.0).round() as u32 {
        world.step(DT);
    }
}

#[test]
fn a_bad_definition_names_its_field_and_changes_nothing() {
    let mut world = World::default();
    let nan = f32::NAN;
    let cube = || cube_at([0.0, 1.0, 0.0]);
    let shaped = |s: ShapeDef| BodyDef::dynamic().with_shape(s);
    let cases: Vec<(BodyDef, &str)> = vec![
        (cube().with_position([nan, 0.0, 0.0]), "position"),
        (cube().with_position([1.0e9, 0.0, 0.0]), "position"),
        (cube().with_rotation([0.0, 0.0, 0.0, 0.0]), "rotation"),
        (cube().with_linear_velocity([f32::INFINITY, 0.0, 0.0]), "linear_velocity"),
        (cube().with_angular_velocity([0.0, nan, 0.0]), "angular_velocity"),
        (cube().with_mass(-1.0), "mass"),
        (cube().with_mass(0.0), "mass"),
        (BodyDef { gravity_scale: nan, ..cube() }, "gravity_scale"),
        (BodyDef { linear_damping: -1.0, ..cube() }, "linear_damping"),
        (BodyDef::dynamic(), "mass"),
        (shaped(ShapeDef::sphere(0.0)), "shapes[0].radius"),
        (shaped(ShapeDef::sphere(nan)), "shapes[0].radius"),
        (shaped(ShapeDef::capsule(-1.0, 1.0)), "shapes[0].half_height"),
        (shaped(ShapeDef::box_half([1.0, -1.0, 1.0])), "shapes[0].half_extents.y"),
        (shaped(ShapeDef::sphere(1.0).with_density(nan)), "shapes[0].density"),
        (shaped(ShapeDef::sphere(1.0).with_friction(-0.1)), "shapes[0].material.friction"),
        (shaped(ShapeDef::sphere(1.0).with_restitution(1.5)), "shapes[0].material.restitution"),
        (shaped(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)), "shapes[0].shape"),
        (BodyDef::fixed().with_shape(ShapeDef::half_space([0.0; 3], 0.0)), "shapes[0].normal"),
        (
            BodyDef {
                mass: MassDef::Exact {
                    mass: 1.0,
                    center: Vec3::ZERO,
                    inertia: Sym3::diagonal(vec3(1.0, -1.0, 1.0)),
                },
                ..cube()
            },
            "inertia",
        ),
    ];
    for (def, field) in cases {
        let error = world.add_body(def).unwrap_err();
        assert_eq!(error.field(), field, "{error}");
        assert!(!error.allowed().is_empty());
    }
    assert_eq!(world.bodies().count(), 0);
    let bad = WorldConfig { substeps: 1000, ..WorldConfig::default() };
    assert_eq!(World::new(bad).unwrap_err().field(), "substeps");
}

#[test]
fn stale_ids_find_nothing() {
    let mut world = World::default();
    let a = world.add_body(cube_at([0.0; 3])).unwrap();
    let b = world.add_body(cube_at([5.0, 0.0, 0.0])).unwrap();
    let joint = world
        .add_joint(JointDef::new(a, b, Ball::new()).with_anchors([2.5, 0.0, 0.0], [-2.5, 0.0, 0.0]))
        .unwrap();
    let shape = world.body(a).unwrap().shapes().next().unwrap();
    assert!(world.remove_body(a));
    assert!(!world.remove_body(a) && !world.remove_joint(joint) && !world.remove_shape(shape));
    assert!(world.body(a).is_none() && world.body_mut(a).is_none());
    assert!(world.shape(shape).is_none() && world.joint(joint).is_none());
    assert!(world.add_joint(JointDef::new(a, b, Ball::new())).is_err());
    assert!(world.add_shape(a, ShapeDef::sphere(1.0)).is_err());
    let again = world.add_body(cube_at([0.0; 3])).unwrap();
    assert!(again != a && world.body(a).is_none() && world.body(again).is_some());
}

#[test]
fn a_bad_time_step_is_a_fault_and_steps_nothing() {
    let mut world = World::default();
    world.add_body(cube_at([0.0, 5.0, 0.0])).unwrap();
    let before = world.state_hash();
    for dt in [0.0, -1.0, f32::NAN, f32::INFINITY, 100.0] {
        world.step(dt);
        assert_eq!(world.events().faults[0].kind, FaultKind::BadTimeStep);
    }
    assert_eq!((world.state_hash(), world.step_count()), (before, 0));
}

/// An executor that reports no workers and therefore runs nothing.
#[derive(Debug)]
struct Nobody;

impl Executor for Nobody {
    fn workers(&self) -> usize {
        0
    }

    fn run(&self, _: usize, _: &(dyn Fn(usize, usize) + Sync)) {}
}

#[test]
fn where_nobody_works_the_caller_does() {
    let [mut one, mut other] = [World::default(), World::default().with_executor(Arc::new(Nobody))];
    for world in [&mut one, &mut other] {
        ground(world);
        world.add_body(cube_at([0.0, 1.0, 0.0])).unwrap();
        run(world, 1.0);
    }
    assert_eq!(one.state_hash(), other.state_hash());
}

#[test]
fn a_body_that_leaves_the_numbers_is_quarantined_and_can_be_put_back() {
    let mut world = World::default();
    ground(&mut world);
    let wild = world.add_body(cube_at([0.0, 5.0, 0.0])).unwrap();
    let calm = world.add_body(cube_at([3.0, 0.5, 0.0])).unwrap();
    // 1e10 m/s² accelerate it beyond 1e8 m/s in a step of 1/60 s.
    let mass = world.body(wild).unwrap().mass();
    world.body_mut(wild).unwrap().add_step_force([9.0e9 * mass, 9.0e9 * mass, 0.0]);
    run(&mut world, 0.6);
    let body = world.body(wild).unwrap();
    assert!(body.is_faulted() && body.position().is_finite());
    assert!((world.body(calm).unwrap().position().y - 0.5).abs() < 1e-3);
    world.body_mut(wild).unwrap().set_pose(Pose::at([0.0, 2.0, 0.0]));
    run(&mut world, 2.0);
    let body = world.body(wild).unwrap();
    assert!(!body.is_faulted() && (body.position().y - 0.5).abs() < 1e-3, "{:?}", body.position());
}

#[test]
fn a_ball_that_falls_and_bounces_off_reports_begin_hit_and_end() {
    let mut world = World::default();
    let floor = ground(&mut world);
    let ball = world
        .add_body(
            BodyDef::dynamic()
                .with_position([0.0, 2.0, 0.0])
                .with_shape(ShapeDef::sphere(0.5).with_restitution(0.8)),
        )
        .unwrap();
    let (mut begins, mut ends, mut hits) = (0, 0, Vec::new());
    for _ in 0..70 {
        world.step(DT);
        begins += world.events().contact_begin.len();
        ends += world.events().contact_end.len();
        hits.extend(world.events().hits.iter().copied());
    }
    assert_eq!((begins, ends, hits.len()), (1, 1, 1));
    let hit = hits[0];
    let sides = [hit.body_a, hit.body_b];
    assert!(sides.contains(&floor) && sides.contains(&ball));
    // After a fall of 1.5 m: v = sqrt(2 g h), less at most one step of gravity.
    let v = (2.0 * 9.81 * 1.5_f32).sqrt();
    assert!(hit.speed <= v && hit.speed > v - 9.81 * DT * 1.01, "{} {v}", hit.speed);
}

#[test]
fn a_sensor_reports_who_comes_and_goes_and_moves_nobody() {
    let mut world = World::default();
    let gate = world
        .add_body(BodyDef::fixed().with_shape(ShapeDef::box_half([1.0, 0.5, 1.0]).as_sensor()))
        .unwrap();
    let ball = world
        .add_body(
            BodyDef::dynamic().with_position([0.0, 3.0, 0.0]).with_shape(ShapeDef::sphere(0.2)),
        )
        .unwrap();
    let (mut enter, mut exit) = (Vec::new(), Vec::new());
    for step in 1..=90_u16 {
        world.step(DT);
        enter.extend(
            world.events().sensor_enter.iter().map(|e| (step, e.sensor_body, e.visitor_body)),
        );
        exit.extend(
            world.events().sensor_exit.iter().map(|e| (step, e.sensor_body, e.visitor_body)),
        );
    }
    assert_eq!((enter.len(), exit.len()), (1, 1));
    assert_eq!((enter[0].1, enter[0].2), (gate, ball));
    // The surfaces touch at y = 0.7 and separate at y = -0.7; the event comes with the next
    // narrowphase.
    let time = |y: f32| (2.0 * (3.0 - y) / 9.81_f32).sqrt() * 60.0;
    for (step, y) in [(enter[0].0, 0.7), (exit[0].0, -0.7)] {
        assert!((f32::from(step) - time(y)).abs() <= 2.0, "step {step}, expected {}", time(y));
    }
    // Free fall through the sensor, exact up to rounding: f32 at 11 m over 90 additions.
    let t = 1.5_f32;
    let y = world.body(ball).unwrap().position().y;
    assert!((y - (3.0 - 0.5 * 9.81 * t * t)).abs() < 1e-4, "{y}");
}

#[test]
fn still_bodies_sleep_and_what_disturbs_them_wakes_them() {
    let mut world = World::default();
    ground(&mut world);
    let low = world.add_body(cube_at([0.0, 0.5, 0.0])).unwrap();
    let high = world.add_body(cube_at([0.0, 1.5, 0.0])).unwrap();
    run(&mut world, 2.0);
    assert!(world.body(low).unwrap().is_asleep() && world.body(high).unwrap().is_asleep());
    let hash = world.state_hash();
    run(&mut world, 1.0);
    assert_eq!(hash, world.state_hash(), "sleepers do not move");
    assert!(world.remove_body(low));
    run(&mut world, 1.0);
    let y = world.body(high).unwrap().position().y;
    assert!((y - 0.5).abs() < 2e-3, "the upper cube falls when its support is taken away: {y}");
    run(&mut world, 2.0);
    assert!(world.body(high).unwrap().is_asleep());
    world.body_mut(high).unwrap().apply_impulse([0.0, 5000.0, 0.0]);
    assert!(!world.body(high).unwrap().is_asleep());
    run(&mut world, 3.0);
    assert!(world.body(high).unwrap().is_asleep());
    let ball = BodyDef::dynamic().with_position([0.0, 3.0, 0.0]).with_shape(ShapeDef::sphere(0.3));
    world.add_body(ball).unwrap();
    let mut woken = false;
    for _ in 0..60 {
        world.step(DT);
        woken |= world.events().wake.contains(&high);
    }
    assert!(woken, "a ball that falls on a sleeper wakes it");
}

#[test]
fn levels_count_the_contacts_to_the_ground() {
    let mut world = World::default();
    ground(&mut world);
    let ids: Vec<_> = [0.5, 1.5, 2.5, 3.5]
        .map(|y| world.add_body(cube_at([0.0, y, 0.0])).unwrap())
        .into_iter()
        .collect();
    let flying = world.add_body(cube_at([9.0, 50.0, 0.0])).unwrap();
    run(&mut world, 0.5);
    for (level, id) in (1..).zip(&ids) {
        assert_eq!(world.body(*id).unwrap().support_level(), Some(level));
    }
    assert_eq!(world.body(flying).unwrap().support_level(), None);
}

#[test]
fn forces_for_a_step_last_a_step_and_lasting_ones_last() {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let id = world.add_body(cube_at([0.0; 3]).with_mass(2.0)).unwrap();
    world.body_mut(id).unwrap().add_step_force([12.0, 0.0, 0.0]);
    run(&mut world, 1.0);
    // One step of 6 m/s² is 0.1 m/s.
    assert!((world.body(id).unwrap().linear_velocity().x - 0.1).abs() < 1e-6);
    world.body_mut(id).unwrap().set_lasting_force([0.0, 2.0, 0.0]);
    run(&mut world, 1.0);
    assert!((world.body(id).unwrap().linear_velocity().y - 1.0).abs() < 1e-5);
    // An impulse off center: dω = I⁻¹ r × J with I = m a²/6 = 1/3.
    world.body_mut(id).unwrap().set_lasting_force([0.0; 3]);
    let p = world.body(id).unwrap().position() + vec3(0.5, 0.0, 0.0);
    world.body_mut(id).unwrap().apply_impulse_at([0.0, 0.0, 1.0], p);
    let w = world.body(id).unwrap().angular_velocity();
    assert!((w - vec3(0.0, -1.5, 0.0)).length() < 1e-5, "{w:?}");
    world.body_mut(id).unwrap().apply_impulse([f32::NAN, 0.0, 0.0]);
    assert_eq!(world.body(id).unwrap().angular_velocity(), w);
}

#[test]
fn locked_axes_do_not_move_in_flight_or_in_contact() {
    let mut world = World::default();
    ground(&mut world);
    let def = BodyDef {
        locks: AxisLocks::PLANE_XY,
        ..cube_at([0.0, 2.0, 0.0])
            .with_rotation(Quat::from_axis_angle([0.0, 0.0, 1.0], 0.5))
            .with_linear_velocity([3.0, 0.0, 0.0])
    };
    let id = world.add_body(def).unwrap();
    for other in [-0.9_f32, 0.9] {
        let ball = ShapeDef::sphere(0.4);
        let def = BodyDef::dynamic().with_position([3.0, 0.4, other]).with_shape(ball);
        world.add_body(def.with_linear_velocity([-3.0, 0.0, -other])).unwrap();
    }
    for _ in 0..180 {
        world.step(DT);
        let body = world.body(id).unwrap();
        let (q, w) = (body.rotation(), body.angular_velocity());
        // In the plane up to rounding of a few hundred quaternion products.
        assert!(body.position().z.abs() < 1e-5, "{:?}", body.position());
        assert!(q.x.abs() < 1e-5 && q.y.abs() < 1e-5, "{q:?}");
        assert!(w.x.abs() < 1e-5 && w.y.abs() < 1e-5, "{w:?}");
    }
}

#[test]
fn a_kinematic_platform_carries_what_stands_on_it() {
    let mut world = World::default();
    let shape = ShapeDef::box_half([2.0, 0.1, 2.0]);
    let def = BodyDef::kinematic().with_shape(shape).with_linear_velocity([1.0, 0.0, 0.0]);
    let platform = world.add_body(def).unwrap();
    let rider = world.add_body(cube_at([0.0, 0.6, 0.0])).unwrap();
    run(&mut world, 3.0);
    assert!((world.body(platform).unwrap().position().x - 3.0).abs() < 1e-4);
    let body = world.body(rider).unwrap();
    assert!((body.linear_velocity() - vec3(1.0, 0.0, 0.0)).length() < 1e-3);
    // Friction 0.6 accelerates it in v/(mu g) = 0.17 s, in which it slips by v²/(2 mu g) = 0.085 m.
    let slip = 3.0 - body.position().x;
    assert!((slip - 0.085).abs() < 0.02, "{slip}");
}

#[test]
fn a_filter_lets_shapes_pass() {
    let mut world = World::default();
    ground(&mut world);
    let ghost = ShapeDef::sphere(0.5).with_filter(Filter::layers(2, 2));
    let id = world
        .add_body(BodyDef::dynamic().with_position([0.0, 1.0, 0.0]).with_shape(ghost))
        .unwrap();
    run(&mut world, 2.0);
    assert!(world.body(id).unwrap().position().y < -10.0);
}

#[test]
fn rays_and_overlaps_find_what_is_there() {
    let mut world = World::default();
    ground(&mut world);
    let id = world.add_body(cube_at([0.0, 2.0, 0.0])).unwrap();
    let query = world.query();
    let all = Filter::default();
    let hit = query.cast_ray([0.0, 10.0, 0.0], [0.0, -20.0, 0.0], all).unwrap().unwrap();
    assert_eq!(hit.body, id);
    assert!((hit.fraction - 7.5 / 20.0).abs() < 1e-6 && (hit.normal - Vec3::Y).length() < 1e-6);
    let beside = query.cast_ray([3.0, 10.0, 0.0], [0.0, -20.0, 0.0], all).unwrap().unwrap();
    assert!(beside.body != id && beside.point.y.abs() < 1e-5);
    assert!(query.cast_ray([0.0, 10.0, 0.0], [0.0, 5.0, 0.0], all).unwrap().is_none());
    assert!(query.cast_ray([f32::NAN; 3], [0.0, 5.0, 0.0], all).is_err());
    let ball = Shape::sphere(0.5);
    let near = query.overlap_shape(&ball, Pose::at([0.9, 2.0, 0.0]), all).unwrap();
    assert_eq!(near.len(), 1);
    assert!(query.overlap_shape(&ball, Pose::at([1.1, 2.0, 0.0]), all).unwrap().is_empty());
    assert_eq!(query.overlap_point([0.1, 2.1, 0.2], all).unwrap().len(), 1);
    let bounds = Aabb::new(vec3(0.4, 1.0, -1.0), vec3(1.0, 3.0, 1.0));
    assert_eq!(
        query.overlap_bounds(bounds, all).unwrap().len(),
        2,
        "the cube and the endless ground"
    );
}

#[test]
fn a_body_moves_the_same_whatever_else_is_solved_beside_it() {
    // A ball has one contact point, a cube four. Alone the ball's block has one row per contact,
    // with others four.
    let fall = |company: &[[f32; 3]]| {
        let mut world = World::default();
        ground(&mut world);
        let ball = BodyDef::dynamic()
            .with_position([0.0, 0.6, 0.0])
            .with_linear_velocity([1.0, -1.0, 0.0])
            .with_shape(ShapeDef::sphere(0.5));
        let ball = world.add_body(ball).unwrap();
        for position in company {
            world.add_body(cube_at(*position)).unwrap();
        }
        run(&mut world, 0.5);
        let ball = world.body(ball).unwrap();
        (ball.pose(), ball.linear_velocity(), ball.angular_velocity())
    };
    let alone = fall(&[]);
    assert_eq!(alone, fall(&[[10.0, 0.6, 0.0]]));
    assert_eq!(alone, fall(&[[10.0, 0.6, 0.0], [10.0, 1.7, 0.0], [-20.0, 0.5, 9.0]]));
}

#[test]
fn a_box_that_tips_over_an_edge_does_so_whatever_else_is_solved_beside_it() {
    // It stands on two points, and its center falls. In a block of contacts with four points, the
    // two missing points must not count as a hit.
    let tip = |company: u8| {
        let mut world = World::default();
        ground(&mut world);
        for i in 0..company {
            world.add_body(cube_at([3.0 + 3.0 * f32::from(i), 0.55, 0.0])).unwrap();
        }
        let (half, tilt) = ([0.2, 1.0, 0.3], 0.3_f32);
        let (s, c) = (0.295_520_2, 0.955_336_5);
        let slab = BodyDef::dynamic()
            .with_position([half[1] * s - half[0] * c, half[1] * c + half[0] * s, 0.0])
            .with_rotation(Quat::from_axis_angle(Vec3::Z, -tilt))
            .with_shape(ShapeDef::box_half(half));
        let slab = world.add_body(slab).unwrap();
        run(&mut world, 1.5);
        let slab = world.body(slab).unwrap();
        (slab.pose(), slab.linear_velocity(), slab.angular_velocity())
    };
    let alone = tip(0);
    for company in [1, 5, 12] {
        assert_eq!(alone, tip(company));
    }
}

#[test]
fn bodies_added_while_the_solver_has_its_plan_take_part() {
    let mut world = World::default();
    ground(&mut world);
    world.add_body(cube_at([0.0, 0.5, 0.0])).unwrap();
    run(&mut world, 0.1);
    let late: Vec<BodyId> =
        [1.5_f32, 3.0].map(|y| world.add_body(cube_at([0.0, y, 0.0])).unwrap()).into();
    run(&mut world, 0.1);
    assert!(world.remove_body(late[0]));
    run(&mut world, 2.0);
    let height = world.body(late[1]).unwrap().position().y;
    // On top of the first cube, within the sag of two.
    assert!((height - 1.5).abs() < 5.0e-3, "{height}");
}

#[test]
fn clones_go_on_alike() {
    let mut world = World::default();
    ground(&mut world);
    for i in 0..5_u8 {
        world.add_body(cube_at([0.3 * f32::from(i), 1.0 + 1.2 * f32::from(i), 0.1])).unwrap();
    }
    run(&mut world, 0.7);
    let mut twin = world.clone().with_executor(Arc::new(Team::with_threads(2)));
    run(&mut world, 1.0);
    run(&mut twin, 1.0);
    assert_eq!(world.state_hash(), twin.state_hash());
}

/// Possible actions of a careless user.
#[derive(Clone, Debug)]
enum Call {
    AddBody(u8, [f32; 3], f32),
    AddJoint(u8, u8),
    Remove(u8),
    Push(u8, [f32; 3]),
    Pose(u8, [f32; 3]),
    Step(u8),
}

fn call() -> impl Strategy<Value = Call> {
    let number = prop_oneof![
        8 => -10.0_f32..10.0,
        1 => prop::sample::select(vec![0.0, f32::NAN, f32::INFINITY, -1.0e30, 3.0e38, 1.0e-30]),
    ];
    let vector = prop::array::uniform3(number.clone());
    prop_oneof![
        3 => (any::<u8>(), vector.clone(), number).prop_map(|(k, p, s)| Call::AddBody(k, p, s)),
        1 => (any::<u8>(), any::<u8>()).prop_map(|(a, b)| Call::AddJoint(a, b)),
        1 => any::<u8>().prop_map(Call::Remove),
        1 => (any::<u8>(), vector.clone()).prop_map(|(b, v)| Call::Push(b, v)),
        1 => (any::<u8>(), vector).prop_map(|(b, v)| Call::Pose(b, v)),
        2 => (1_u8..20).prop_map(Call::Step),
    ]
}

fn shape_of(kind: u8, size: f32) -> ShapeDef {
    match kind % 6 {
        0 => ShapeDef::sphere(size),
        1 => ShapeDef::capsule(size, 0.3),
        2 => ShapeDef::box_half([size, 0.4, 0.5]),
        3 => ShapeDef::cylinder(0.4, size),
        4 => ShapeDef::cone(size, 0.5),
        _ => ShapeDef::half_space([0.1, 1.0, 0.0], size),
    }
    .with_material(Material {
        restitution: 0.5,
        rolling_resistance: 0.1,
        ..Material::default()
    })
}

proptest! {
    #![proptest_config(proptest::test_runner::Config::with_cases(if cfg!(debug_assertions) { 60 } else { 3000 }))]
    #[test]
    fn no_order_of_calls_panics_or_leaves_the_numbers(calls in prop::collection::vec(call(), 1..60)) {
        let mut world = World::default();
        let mut ids = vec![ground(&mut world)];
        for call in calls {
            let pick = |k: u8| ids[usize::from(k) % ids.len()];
            match call {
                Call::AddBody(kind, position, size) => {
                    let def = match kind % 3 {
                        0 => BodyDef::fixed(),
                        1 => BodyDef::kinematic().with_linear_velocity([0.5, 0.0, 0.0]),
                        _ => BodyDef::dynamic(),
                    };
                    let shape = shape_of(kind / 3, size);
                    if let Ok(id) = world.add_body(def.with_position(position).with_shape(shape)) {
                        ids.push(id);
                    }
                }
                Call::AddJoint(a, b) => {
                    let _ = world.add_joint(JointDef::new(pick(a), pick(b), Ball::new()).with_anchors([0.5; 3], [0.0; 3]));
                }
                Call::Remove(k) => {
                    world.remove_body(pick(k));
                }
                Call::Push(k, v) => {
                    if let Some(mut body) = world.body_mut(pick(k)) {
                        body.apply_impulse(v);
                        body.set_angular_velocity(v);
                    }
                }
                Call::Pose(k, v) => {
                    if let Some(mut body) = world.body_mut(pick(k)) {
                        body.set_pose(Pose::at(v));
                    }
                }
                Call::Step(n) => (0..n).for_each(|_| world.step(DT)),
            }
            for body in world.bodies() {
                assert!(body.position().is_finite() && body.rotation().is_finite());
            }
        }
    }
}

#[test]
fn a_box_comes_to_rest_on_a_mesh() {
    let mut world = World::default();
    let corner = |x: f32, z: f32| vec3(x, 0.0, z);
    let vertices = vec![corner(-5., -5.), corner(5., -5.), corner(5., 5.), corner(-5., 5.)];
    let mesh = drystone::Mesh::new(vertices, vec![[0, 2, 1], [0, 3, 2]]).unwrap();
    let floor = ShapeDef::new(Shape::Mesh(Arc::new(mesh)));
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let cube = world.add_body(cube_at([0.0, 0.6, 0.0])).unwrap();
    run(&mut world, 2.0);
    let height = world.body(cube).unwrap().position().y;
    assert!((height - 0.5).abs() < 0.01, "{height}");
    assert_eq!(world.counts().pairs, 1);
}

#[test]
fn a_shape_that_comes_and_goes_takes_its_mass_along_and_changes_no_motion() {
    let mut world = World::default();
    let def = cube_at([1.0, 5.0, 2.0])
        .with_linear_velocity([1.0, 0.0, 0.0])
        .with_angular_velocity([0.0, 0.0, 2.0]);
    let id = world.add_body(def).unwrap();
    let before = world.body(id).unwrap();
    let (mass, inertia, at) = (before.mass(), before.inertia(), before.position());
    let one_more = ShapeDef::box_half([0.5, 0.5, 0.5]).with_pose(Pose::at([1.0, 0.0, 0.0]));
    let shape = world.add_shape(id, one_more).unwrap();
    let two = world.body(id).unwrap();
    // Two equal cubes side by side: twice the mass, center half way between, I + m / 4 each about
    // z.
    assert!((two.mass() / (2.0 * mass) - 1.0).abs() < 1e-6);
    assert!((two.center_of_mass() - vec3(1.5, 5.0, 2.0)).length() < 1e-6);
    let expected = 2.0 * (inertia.zz + 0.25 * mass);
    assert!((two.inertia().zz / expected - 1.0).abs() < 1e-5);
    // The origin keeps its position and velocity; the new center rotates about it.
    assert!((two.position() - at).length() < 1e-6);
    assert!((two.velocity_at(at) - vec3(1.0, 0.0, 0.0)).length() < 1e-6);
    assert!((two.linear_velocity() - vec3(1.0, 1.0, 0.0)).length() < 1e-6);
    assert!(world.remove_shape(shape));
    let one = world.body(id).unwrap();
    assert!((one.mass() / mass - 1.0).abs() < 1e-6);
    assert!((one.center_of_mass() - vec3(1.0, 5.0, 2.0)).length() < 1e-6);
    assert!((one.linear_velocity() - vec3(1.0, 0.0, 0.0)).length() < 1e-6);
}

#[test]
fn a_given_mass_stays_when_a_shape_is_added() {
    let mut world = World::default();
    let more = || ShapeDef::box_half([0.5, 0.5, 0.5]).with_pose(Pose::at([1.0, 0.0, 0.0]));
    let some = world.add_body(cube_at([0.0; 3]).with_mass(7.0)).unwrap();
    world.add_shape(some, more()).unwrap();
    assert!((world.body(some).unwrap().mass() - 7.0).abs() < 1e-5);
    assert!((world.body(some).unwrap().center_of_mass() - vec3(0.5, 0.0, 0.0)).length() < 1e-6);
    let inertia = Sym3::diagonal(vec3(1.0, 2.0, 3.0));
    let mass = MassDef::Exact { mass: 5.0, center: Vec3::ZERO, inertia };
    let full = world.add_body(BodyDef { mass, ..cube_at([0.0, 9.0, 0.0]) }).unwrap();
    world.add_shape(full, more()).unwrap();
    assert_eq!(world.body(full).unwrap().center_of_mass(), vec3(0.0, 9.0, 0.0));
}

#[test]
fn what_lies_still_lies_still_when_a_shape_is_added() {
    let mut world = World::default();
    ground(&mut world);
    let id = world.add_body(cube_at([0.0, 0.5, 0.0])).unwrap();
    run(&mut world, 1.0);
    // Beside the first cube, also on the ground: the center moves by half a meter.
    let beside = ShapeDef::box_half([0.5, 0.5, 0.5]).with_pose(Pose::at([1.0, 0.0, 0.0]));
    world.add_shape(id, beside).unwrap();
    for _ in 0..60 {
        world.step(DT);
        let body = world.body(id).unwrap();
        // The new half settles on its contact within a step: g dt at most.
        assert!(body.linear_velocity().length() < 9.81 * DT, "{:?}", body.linear_velocity());
    }
    let body = world.body(id).unwrap();
    assert!((body.position() - vec3(0.0, 0.5, 0.0)).length() < 1e-3, "{:?}", body.position());
    assert!(body.linear_velocity().length() < 1e-3);
}

/// A mesh has several manifolds, but is one visitor for a sensor.
#[test]
fn a_sensor_over_a_mesh_enters_once_and_leaves_once() {
    let mut world = World::default();
    let points: Vec<Vec3> = [-1.0, 0.0, 1.0]
        .into_iter()
        .flat_map(|x| [-1.0, 0.0, 1.0].map(|z| vec3(x, 0.1 * x * x, z)))
        .collect();
    let triangles: Vec<[u32; 3]> =
        [0, 1, 3, 4].into_iter().flat_map(|i| [[i, i + 1, i + 4], [i, i + 4, i + 3]]).collect();
    let mesh = drystone::Mesh::new(points, triangles).unwrap();
    world
        .add_body(BodyDef::fixed().with_shape(ShapeDef::new(Shape::Mesh(Arc::new(mesh)))))
        .unwrap();
    let gate = ShapeDef::box_half([0.8, 0.3, 0.8]).as_sensor();
    let gate = world.add_body(BodyDef::kinematic().with_position([0.0, 2.0, 0.0]).with_shape(gate));
    let gate = gate.unwrap();
    let (mut entered, mut left) = (0, 0);
    for step in 0..240 {
        let down = if step < 120 { -1.0 } else { 1.0 };
        world.body_mut(gate).unwrap().set_linear_velocity([0.0, down, 0.0]);
        world.step(DT);
        entered += world.events().sensor_enter.len();
        left += world.events().sensor_exit.len();
        assert!(left <= entered && entered <= 1, "{entered} {left}");
    }
    assert_eq!((entered, left), (1, 1));
}
