//! A mover is a character without a body: it stays off solid shapes, and walks like a person.

use drystone::math::trig;
use drystone::mover::{Moved, Mover};
use drystone::query::{BodyKinds, QueryFilter};
use drystone::{BodyDef, BodyId, Mesh, Pose, Quat, Shape, ShapeDef, Vec3, World, vec3};
use std::sync::Arc;

const SKIN: f32 = 0.01;

/// A person of 1.6 m: the origin is 0.8 m above the feet.
fn person() -> Mover {
    Mover::new(Shape::capsule(0.5, 0.3))
}

fn fixed(world: &mut World, at: [f32; 3], half: [f32; 3], degrees: f32) -> BodyId {
    let turn = Quat::from_axis_angle(Vec3::Z, degrees.to_radians());
    let body = BodyDef::fixed().with_position(at).with_rotation(turn);
    world.add_body(body.with_shape(ShapeDef::box_half(half))).unwrap()
}

/// A floor whose top is at 0.
fn floor() -> World {
    let mut world = World::default();
    fixed(&mut world, [0.0, -1.0, 0.0], [50.0, 1.0, 50.0], 0.0);
    world
}

/// Walks for some frames with gravity, as a program does: it falls when it is not grounded.
fn walk(world: &World, mover: &Mover, from: Vec3, step: Vec3, frames: u32) -> (Moved, f32) {
    let (mut moved, mut pose, mut fall, mut in_the_air) =
        (Moved::default(), Pose::at(from), 0.0, 0);
    for _ in 0..frames {
        fall = if moved.grounded { 0.0 } else { fall - 9.81 / 3600.0 };
        let filter = QueryFilter::default();
        mover.move_into(world, pose, step + Vec3::Y * fall, filter, &mut moved).unwrap();
        pose = moved.pose;
        in_the_air += u16::from(!moved.grounded);
    }
    (moved, f32::from(in_the_air))
}

/// Minimum distance of the mover's shape from all other shapes [m].
fn gap(world: &World, mover: &Mover, pose: Pose) -> f32 {
    let near = world.query().nearest_shape(mover.shape(), pose, 10.0, QueryFilter::default());
    near.unwrap().map_or(f32::INFINITY, |near| near.distance)
}

#[test]
fn on_a_flat_floor_it_goes_the_whole_way_a_skin_above() {
    let corners =
        vec![[-50.0, 0.0, -50.0], [50.0, 0.0, -50.0], [50.0, 0.0, 50.0], [-50.0, 0.0, 50.0]];
    let corners = corners.into_iter().map(Vec3::from).collect();
    let mesh = Mesh::new(corners, vec![[0, 2, 1], [0, 3, 2]]).unwrap();
    for ground in [
        ShapeDef::new(Shape::Mesh(Arc::new(mesh))),
        ShapeDef::half_space(Vec3::Y, 0.0),
        ShapeDef::box_half([50.0, 1.0, 50.0]).with_position([0.0, -1.0, 0.0]),
    ] {
        let mut world = World::default();
        world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
        let (moved, air) =
            walk(&world, &person(), vec3(0.0, 0.81, 0.0), vec3(0.03, 0.0, 0.02), 100);
        let off = moved.pose.position - vec3(3.0, 0.81, 2.0);
        // A hundred sums of numbers below 4, and fractions of casts.
        assert!(moved.grounded && air == 0.0 && off.length() < 1e-4, "{off:?}");
        assert!((moved.ground_normal - Vec3::Y).length() < 1e-5);
    }
}

#[test]
fn it_climbs_steps_up_to_the_limit_and_no_higher() {
    for (height, climbs) in [(0.1, true), (0.294, true), (0.306, false), (0.5, false), (0.9, false)]
    {
        for shape in
            [Shape::capsule(0.5, 0.3), Shape::box_half([0.3, 0.8, 0.3]), Shape::cylinder(0.8, 0.3)]
        {
            let mut world = floor();
            fixed(&mut world, [3.0, height - 1.0, 0.0], [2.0, 1.0, 5.0], 0.0);
            let mover = Mover::new(shape);
            let (moved, _) = walk(&world, &mover, vec3(0.0, 0.81, 0.0), vec3(0.03, 0.0, 0.0), 100);
            let at = moved.pose.position;
            let kind = mover.shape().kind();
            if climbs {
                assert!(
                    (at.x - 3.0).abs() < 0.2 && (at.y - 0.81 - height).abs() < 1e-3,
                    "{kind} {height}: {at:?}"
                );
            } else {
                // A skin width before the edge, at the height of the floor.
                assert!(
                    (at.x - 0.69).abs() < 2e-3 && (at.y - 0.81).abs() < 1e-3,
                    "{kind} {height}: {at:?}"
                );
            }
            assert!(moved.grounded && gap(&world, &mover, moved.pose) > 0.0);
        }
    }
}

#[test]
fn stairs_lead_up_and_down_without_a_moment_in_the_air() {
    let mut world = floor();
    for i in 0..5_u8 {
        let top = 0.28 * f32::from(i + 1);
        fixed(&mut world, [6.0 + 0.4 * f32::from(i), top - 1.0, 0.0], [5.0, 1.0, 5.0], 0.0);
    }
    let (up, air) = walk(&world, &person(), vec3(0.0, 0.81, 0.0), vec3(0.03, 0.0, 0.0), 150);
    assert!((up.pose.position.y - 0.81 - 1.4).abs() < 1e-3 && air == 0.0, "{:?} {air}", up.pose);
    let (down, air) = walk(&world, &person(), up.pose.position, vec3(-0.03, 0.0, 0.0), 150);
    assert!((down.pose.position.y - 0.81).abs() < 1e-3 && air == 0.0, "{:?} {air}", down.pose);
}

#[test]
fn slopes_below_the_limit_hold_it_and_those_above_do_not() {
    for (degrees, holds) in
        [(10.0, true), (30.0, true), (44.5, true), (45.5, false), (60.0, false), (80.0, false)]
    {
        let mut world = World::default();
        fixed(&mut world, [0.0; 3], [50.0, 1.0, 50.0], degrees);
        let (sin, cos) = trig::sin_cos(f32::to_radians(degrees));
        let up = vec3(-sin, cos, 0.0);
        // The lower center of the capsule is a radius and a skin width off the face.
        let start = up * (1.0 + 0.3 + SKIN) + Vec3::Y * 0.5;
        let (stays, _) = walk(&world, &person(), start, Vec3::ZERO, 60);
        let slid = stays.pose.position - start;
        assert_eq!(stays.grounded, holds, "{degrees}");
        if holds {
            assert!(slid.length() < 1e-4, "{degrees}: {slid:?}");
        } else {
            // It slides at least as far as a second of free fall along the slope, because only the
            // fall across the slope is lost.
            assert!(slid.y < -1.0 && slid.x < 0.0, "{degrees}: {slid:?}");
        }
        let (walks, air) = walk(&world, &person(), start, vec3(0.03, 0.0, 0.0), 60);
        let way = walks.pose.position - start;
        if holds {
            // As fast along the slope as on level ground.
            assert!(
                (way - vec3(cos, sin, 0.0) * 1.8).length() < 0.02 && air == 0.0,
                "{degrees}: {way:?}"
            );
        } else {
            assert!(way.x < 1e-3, "{degrees}: it does not come up: {way:?}");
        }
        assert!(gap(&world, &person(), walks.pose) > 0.0);
    }
}

#[test]
fn downhill_it_stays_on_the_ground() {
    for degrees in [30.0, 37.0, 44.0] {
        let mut world = World::default();
        fixed(&mut world, [0.0; 3], [50.0, 1.0, 50.0], degrees);
        let (sin, cos) = trig::sin_cos(f32::to_radians(degrees));
        let start = vec3(-sin, cos, 0.0) * 1.31 + Vec3::Y * 0.5;
        let (moved, air) = walk(&world, &person(), start, vec3(-0.05, 0.0, 0.0), 100);
        let way = moved.pose.position - start;
        assert!(air == 0.0 && (way.y / way.x - sin / cos).abs() < 1e-3, "{way:?} {air}");
    }
    // Over the edge of a step down it needs its snap for that.
    let mut world = floor();
    fixed(&mut world, [0.0, -0.8, 0.0], [1.0, 1.0, 5.0], 0.0);
    for (mover, flies) in [(person(), false), (person().with_snap(0.0), true)] {
        let (moved, air) = walk(&world, &mover, vec3(0.0, 1.01, 0.0), vec3(0.05, 0.0, 0.0), 60);
        assert!(moved.grounded && (moved.pose.position.y - 0.81).abs() < 1e-3);
        assert_eq!(air > 0.0, flies);
    }
}

#[test]
fn it_stops_in_corners_and_slides_along_walls() {
    for degrees in [20.0, 60.0, 90.0, 150.0] {
        // Two walls that meet at x = 0 at this angle, open toward -x.
        let mut world = floor();
        for side in [-1.0, 1.0] {
            let turn = Quat::from_axis_angle(Vec3::Y, side * f32::to_radians(degrees / 2.0));
            let middle = turn.rotate(vec3(-10.0, 0.0, 0.0)) + turn.rotate(vec3(0.0, 2.0, side));
            let wall = BodyDef::fixed().with_position(middle).with_rotation(turn);
            world.add_body(wall.with_shape(ShapeDef::box_half([10.0, 2.0, 1.0]))).unwrap();
        }
        let (sin, _) = trig::sin_cos(f32::to_radians(degrees / 2.0));
        let from = vec3(-5.0, 0.81, 0.01);
        let (moved, _) = walk(&world, &person(), from, vec3(0.05, 0.0, 0.005), 200);
        let (again, _) = walk(&world, &person(), moved.pose.position, vec3(0.05, 0.0, 0.005), 20);
        // As deep as its radius allows, less up to a skin width; it rests there.
        let depth = -0.3 / sin;
        let at = moved.pose.position;
        assert!(at.x <= depth && at.x > depth - 2.0 * SKIN / sin, "{degrees}: {at:?} {depth}");
        assert!((again.pose.position - at).length() < 1e-4, "{degrees}: trembles");
        assert!(moved.grounded && gap(&world, &person(), moved.pose) > 0.0);
    }
    // A wall at 45 degrees deflects half of the displacement along it.
    let mut world = floor();
    let turn = Quat::from_axis_angle(Vec3::Y, 45_f32.to_radians());
    let wall = BodyDef::fixed().with_position([3.0, 0.0, 0.0]).with_rotation(turn);
    world.add_body(wall.with_shape(ShapeDef::box_half([1.0, 5.0, 20.0]))).unwrap();
    let before = walk(&world, &person(), vec3(0.0, 0.81, 0.0), vec3(0.05, 0.0, 0.0), 40).0;
    let after = walk(&world, &person(), before.pose.position, vec3(0.05, 0.0, 0.0), 40).0;
    let way = after.pose.position - before.pose.position;
    assert!((way.x - 1.0).abs() < 0.01 && (way.z.abs() - 1.0).abs() < 0.01, "{way:?}");
}

#[test]
fn a_ceiling_stops_a_jump_and_a_low_one_a_step() {
    let mut world = floor();
    fixed(&mut world, [0.0, 3.0, 0.0], [5.0, 1.0, 5.0], 0.0);
    let from = Pose::at([0.0, 0.81, 0.0]);
    let moved = person().move_by(&world, from, [0.1, 1.0, 0.0], QueryFilter::default()).unwrap();
    // Its head is 0.8 m above its origin.
    assert!((moved.pose.position - vec3(0.1, 1.19, 0.0)).length() < 1e-4 && !moved.grounded);
    assert!((moved.hits[0].blocked - (1.0 - 0.38)).abs() < 1e-3 && moved.hits[0].normal.y < -0.99);
    // A step of 0.2 m with less than 1.8 m above the floor.
    fixed(&mut world, [2.0, -0.8, 0.0], [1.0, 1.0, 5.0], 0.0);
    fixed(&mut world, [2.0, 2.75, 0.0], [1.0, 1.0, 5.0], 0.0);
    let (moved, _) = walk(&world, &person(), vec3(0.0, 0.81, 0.0), vec3(0.03, 0.0, 0.0), 60);
    // Its foot reaches the step, with its head under the edge.
    assert!(moved.pose.position.x < 0.8 && moved.grounded);
}

#[test]
fn a_corridor_as_wide_as_itself_lets_it_through() {
    for width in [0.6, 0.605, 0.62, 0.64] {
        let mut world = floor();
        for side in [-1.0, 1.0] {
            fixed(&mut world, [0.0, 2.0, side * (width / 2.0 + 1.0)], [20.0, 2.0, 1.0], 0.0);
        }
        let (moved, _) = walk(&world, &person(), vec3(0.0, 0.81, 0.0), vec3(0.03, 0.0, 0.0), 100);
        let at = moved.pose.position;
        assert!((at.x - 3.0).abs() < 0.01 && (at.y - 0.81).abs() < 1e-3, "{width}: {at:?}");
        assert!(at.z.abs() <= (width - 0.6) / 2.0 + 1e-5);
    }
}

#[test]
fn it_rides_a_lift_at_any_speed() {
    let mut world = floor();
    let lift = BodyDef::kinematic().with_position([0.0, 0.1, 0.0]);
    let lift = world.add_body(lift.with_shape(ShapeDef::box_half([1.0, 0.1, 1.0]))).unwrap();
    let (mover, mut moved) = (person(), Moved::default());
    let mut pose = Pose::at([0.0, 1.01, 0.0]);
    for speed in [0.02, 2.0, 20.0, -2.0, -0.02, 0.0] {
        world.body_mut(lift).unwrap().set_linear_velocity([0.5, speed, 0.0]);
        for _ in 0..60 {
            let down = [0.0, -0.001, 0.0];
            mover.move_into(&world, pose, down, QueryFilter::default(), &mut moved).unwrap();
            assert!(moved.grounded && moved.ground == Some(lift));
            pose = moved.pose;
            pose.position += moved.ground_velocity(&world) * (1.0 / 60.0);
            world.step(1.0 / 60.0);
            let off = pose.position - world.body(lift).unwrap().position() - vec3(0.0, 0.91, 0.0);
            assert!(off.length() < 1e-3, "{speed}: {off:?}");
        }
    }
}

#[test]
fn a_small_overlap_pushes_it_out_and_a_wall_at_its_side_does_not_hold_it() {
    let mut world = floor();
    fixed(&mut world, [1.3, 1.0, 0.0], [1.0, 1.0, 5.0], 0.0);
    let from = Pose::at([0.05, 0.75, 0.0]);
    let moved = person().move_by(&world, from, Vec3::ZERO, QueryFilter::default()).unwrap();
    assert!((moved.pose.position - vec3(0.0, 0.81, 0.0)).length() < SKIN && moved.grounded);
    assert!(gap(&world, &person(), moved.pose) > -1e-6);
    let moved = person().move_by(&world, from, [-0.1, 0.0, 0.3], QueryFilter::default()).unwrap();
    assert!((moved.pose.position - vec3(-0.1, 0.81, 0.3)).length() < SKIN);
}

#[test]
fn the_size_of_the_world_does_not_matter() {
    let mut ends = Vec::new();
    for scale in [0.1_f32, 1.0, 10.0, 100.0] {
        let mut world = World::default();
        let mut put = |at: [f32; 3], half: [f32; 3]| {
            let half = ShapeDef::box_half(half.map(|x| scale * x));
            world
                .add_body(BodyDef::fixed().with_position(at.map(|x| scale * x)).with_shape(half))
                .unwrap()
        };
        put([0.0, -1.0, 0.0], [50.0, 1.0, 50.0]);
        put([3.0, -0.75, 0.0], [2.0, 1.0, 5.0]);
        put([5.0, 2.0, 0.0], [1.0, 2.0, 5.0]);
        let mover = Mover::new(Shape::capsule(0.5 * scale, 0.3 * scale));
        let mover = mover.with_step(0.3 * scale).with_snap(0.3 * scale).with_skin(SKIN * scale);
        let step = vec3(0.03, -0.01, 0.01) * scale;
        let mut pose = Pose::at(vec3(0.0, 0.81, 0.0) * scale);
        for _ in 0..150 {
            pose = mover.move_by(&world, pose, step, QueryFilter::default()).unwrap().pose;
        }
        ends.push(pose.position * (1.0 / scale));
    }
    // Up the step to a skin width before the wall; the displacement along the wall is not
    // shortened.
    assert!((ends[0].x - 3.69).abs() < 1e-3 && (ends[0].y - 1.06).abs() < 1e-3, "{ends:?}");
    assert!(ends[0].z >= 1.499);
    // Sums of 150 roundings.
    assert!(ends.iter().all(|end| (*end - ends[0]).length() < 150.0 * 2.4e-7 * 4.0), "{ends:?}");
}

#[test]
fn ways_of_any_length_end_before_a_wall() {
    let mut world = floor();
    fixed(&mut world, [10.0, 1.0, 0.0], [0.05, 1.0, 5.0], 0.0);
    let mover = person();
    for length in [1e-30, 1e-9, 1e-4, 9.0, 1e3, 1e5, 9e6] {
        let from = Pose::at([0.0, 0.81, 0.0]);
        let moved =
            mover.move_by(&world, from, [length, 0.0, 0.0], QueryFilter::default()).unwrap();
        let at = moved.pose.position;
        let want = f32::min(length, 10.0 - 0.05 - 0.3 - SKIN);
        assert!((at.x - want).abs() < 2e-3 && moved.grounded, "{length}: {at:?}");
    }
    for drop in [1.0, 1e3, 9e6] {
        let moved = mover.move_by(
            &world,
            Pose::at([0.0, 3.0, 0.0]),
            [0.0, -drop, 0.0],
            QueryFilter::default(),
        );
        assert!((moved.unwrap().pose.position.y - f32::max(3.0 - drop, 0.81)).abs() < 2e-3);
    }
}

#[test]
fn a_one_way_surface_holds_from_above_only() {
    let mut world = floor();
    let board = ShapeDef::box_half([2.0, 0.1, 2.0]).with_one_way(Vec3::Y);
    world.add_body(BodyDef::fixed().with_position([0.0, 2.4, 0.0]).with_shape(board)).unwrap();
    let mover = person();
    let up =
        mover.move_by(&world, Pose::at([0.0, 0.81, 0.0]), [0.0, 3.0, 0.0], QueryFilter::default());
    assert!((up.unwrap().pose.position.y - 3.81).abs() < 1e-5);
    let down =
        mover.move_by(&world, Pose::at([0.0, 3.81, 0.0]), [0.0, -3.0, 0.0], QueryFilter::default());
    assert!((down.unwrap().pose.position.y - 3.31).abs() < 1e-3);
    let inside =
        mover.move_by(&world, Pose::at([0.0, 2.5, 0.0]), [0.0, -1.0, 0.0], QueryFilter::default());
    assert!((inside.unwrap().pose.position.y - 1.5).abs() < 1e-5);
}

/// A random number from 0 to 1.
fn draw(seed: &mut u32) -> f32 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*seed >> 8) as f32 / 16_777_216.0
}

#[test]
fn among_boxes_in_any_pose_it_never_gets_into_one() {
    let mut seed = 7;
    let mut met = 0;
    for shape in [Shape::capsule(0.5, 0.3), Shape::sphere(0.4), Shape::box_half([0.3, 0.6, 0.2])] {
        for _ in 0..20 {
            let mut world = floor();
            for _ in 0..60 {
                let [x, y, z] = [0; 3].map(|_| draw(&mut seed));
                let at = vec3(10.0 * x - 5.0, 4.0 * y - 0.5, 10.0 * z - 5.0);
                let turn = vec3(draw(&mut seed), draw(&mut seed), draw(&mut seed)) * 3.0;
                let half = [0; 3].map(|_| 0.1 + 0.7 * draw(&mut seed));
                // Keeps space for the start.
                if vec3(at.x, 0.0, at.z).length() < 2.0 {
                    continue;
                }
                let body = BodyDef::fixed().with_position(at);
                let body = body.with_rotation(Quat::from_rotation_vector(turn));
                world.add_body(body.with_shape(ShapeDef::box_half(half))).unwrap();
            }
            let mover = Mover::new(shape.clone());
            let (mut pose, mut moved) = (Pose::at([0.0, 2.0, 0.0]), Moved::default());
            let mut step = Vec3::ZERO;
            for frame in 0..300_u16 {
                if frame % 30 == 0 {
                    let [x, y, z] = [0; 3].map(|_| draw(&mut seed) - 0.5);
                    step = vec3(0.2 * x, 0.3 * y - 0.05, 0.2 * z);
                }
                mover.move_into(&world, pose, step, QueryFilter::default(), &mut moved).unwrap();
                let way = moved.pose.position - pose.position;
                pose = moved.pose;
                met += u32::from(!moved.hits.is_empty());
                let near = gap(&world, &mover, pose);
                assert!(near > 0.0, "{}: {near} at {:?} by {step:?}", shape.kind(), pose.position);
                // Allows for a step, a snap and the exits from the skin.
                assert!(way.length() < step.length() + 0.3 + 0.3 + 3.0 * SKIN, "{way:?}");
            }
        }
    }
    assert!(met > 5000, "{met}");
}

#[test]
fn a_body_that_follows_rides_and_pushes_and_other_bodies_are_refused() {
    let mut world = floor();
    let hero = BodyDef::kinematic().with_position([0.0, 0.81, 0.0]);
    let hero = world.add_body(hero.with_shape(ShapeDef::capsule(0.5, 0.3))).unwrap();
    let load = BodyDef::dynamic().with_position([1.0, 0.4, 0.0]).with_mass(40.0);
    let load = world.add_body(load.with_shape(ShapeDef::box_half([0.4; 3]))).unwrap();
    let (mover, dt) = (person(), 1.0 / 60.0);
    let level = QueryFilter::default().with_kinds(BodyKinds::STATIC | BodyKinds::KINEMATIC);
    for _ in 0..60 {
        mover.move_body(&mut world, hero, [1.5, -0.1, 0.0], dt, level).unwrap();
        world.step(dt);
    }
    let [hero_x, load_x] = [hero, load].map(|id| world.body(id).unwrap().position().x);
    assert!((load_x - hero_x - 0.7).abs() < 0.02, "{hero_x} {load_x}");
    // A crate that the filter includes blocks it.
    let before = world.body(hero).unwrap().position().x;
    let moved =
        mover.move_body(&mut world, hero, [6.0, 0.0, 0.0], dt, QueryFilter::default()).unwrap();
    assert!(moved.pose.position.x - before < 0.02 && moved.hits.iter().any(|hit| hit.body == load));
    let refused = mover.move_body(&mut world, load, Vec3::X, dt, level).unwrap_err();
    assert_eq!(refused.field(), "body");
    assert_eq!(mover.move_body(&mut world, hero, Vec3::X, 0.0, level).unwrap_err().field(), "dt");
    world.remove_body(hero);
    assert_eq!(mover.move_body(&mut world, hero, Vec3::X, dt, level).unwrap_err().field(), "body");
}

#[test]
fn what_cannot_be_is_refused_and_nothing_panics() {
    let world = floor();
    let from = Pose::at([0.0, 0.81, 0.0]);
    let go = |mover: Mover, pose: Pose, delta: Vec3| {
        mover.move_by(&world, pose, delta, QueryFilter::default())
    };
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        assert_eq!(go(person().with_step(bad), from, Vec3::X).unwrap_err().field(), "step");
        assert_eq!(go(person().with_snap(bad), from, Vec3::X).unwrap_err().field(), "snap");
        assert_eq!(go(person().with_skin(bad), from, Vec3::X).unwrap_err().field(), "skin");
        assert_eq!(
            go(person().with_max_slope(bad), from, Vec3::X).unwrap_err().field(),
            "max_slope"
        );
    }
    assert_eq!(go(person().with_up(Vec3::ZERO), from, Vec3::X).unwrap_err().field(), "up");
    assert_eq!(go(person(), from, Vec3::X * f32::NAN).unwrap_err().field(), "delta");
    assert_eq!(go(person(), from, Vec3::X * 1e9).unwrap_err().field(), "delta");
    assert!(go(person(), Pose::at([f32::NAN; 3]), Vec3::X).is_err());
    assert!(go(Mover::new(Shape::sphere(-1.0)), from, Vec3::X).is_err());
    assert!(go(Mover::new(Shape::half_space(Vec3::Y, 0.0)), from, Vec3::X).is_err());
    // Numbers at the limits of their ranges.
    for slope in [0.0, core::f32::consts::FRAC_PI_2] {
        for size in [1e-6, 1e3] {
            let mover =
                person().with_skin(size).with_step(1e3).with_snap(1e3).with_max_slope(slope);
            for way in [Vec3::X, -Vec3::Y, Vec3::Y, vec3(1e6, -1e6, 1.0)] {
                assert!(go(mover.clone(), from, way).unwrap().pose.is_finite());
            }
        }
    }
}
