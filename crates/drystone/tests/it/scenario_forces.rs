//! Contacts report the totals of the whole step: impulses, forces, hits of every landing, and only
//! on request.

use std::sync::Arc;

use drystone::events::{ContactReports, HitEvent};
use drystone::{BodyDef, BodyId, Mesh, Quat, Shape, ShapeDef, Vec3, World, WorldConfig, vec3};

const G: f32 = 9.81;

fn floor(kind: &str, scale: f32) -> ShapeDef {
    match kind {
        "plane" => ShapeDef::half_space(Vec3::Y, 0.0),
        "box" => ShapeDef::box_half(vec3(5.0, 1.0, 5.0) * scale)
            .with_position(vec3(0.0, -1.0, 0.0) * scale),
        _ => {
            // Four triangles meet under the middle, so a body there has several manifolds.
            let corner = |x: f32, z: f32| vec3(x, 0.0, z) * (5.0 * scale);
            let corners = vec![
                corner(-1.0, -1.0),
                corner(-1.0, 1.0),
                corner(1.0, 1.0),
                corner(1.0, -1.0),
                Vec3::ZERO,
            ];
            let triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
            ShapeDef::new(Shape::Mesh(Arc::new(Mesh::new(corners, triangles).unwrap())))
        }
    }
}

fn world(kind: &str, scale: f32) -> World {
    let gravity = vec3(0.0, -G, 0.0) * scale;
    let mut config = WorldConfig { gravity, ..WorldConfig::default() };
    config.contact.hit_speed = scale;
    let mut world = World::new(config).unwrap();
    world.add_body(BodyDef::fixed().with_shape(floor(kind, scale))).unwrap();
    world
}

fn crate_at(height: f32, scale: f32) -> BodyDef {
    let shape = ShapeDef::box_half(Vec3::splat(0.25 * scale));
    BodyDef::dynamic()
        .with_position(vec3(0.0, height, 0.0) * scale)
        .with_shape(shape.with_reports(ContactReports::with_forces()))
}

#[test]
fn the_forces_on_a_body_at_rest_are_its_weight() {
    for (kind, scale, rate) in ["plane", "box", "mesh"]
        .into_iter()
        .flat_map(|k| [0.1, 1.0, 100.0].map(|s| (k, s)))
        .flat_map(|(k, s)| [30.0_f32, 60.0, 120.0].map(|r| (k, s, r)))
    {
        let mut world = world(kind, scale);
        let ids: Vec<BodyId> = (0..3)
            .map(|i| world.add_body(crate_at(0.25 + 0.5 * i as f32, scale)).unwrap())
            .collect();
        ids.iter().for_each(|id| world.body_mut(*id).unwrap().set_can_sleep(false));
        for _ in 0..300 {
            world.step(1.0 / rate);
        }
        let what = format!("{kind}, x{scale}, {rate} Hz");
        let events = world.events();
        for id in &ids {
            let weight = world.body(*id).unwrap().mass() * G * scale;
            let off = events.contact_force_on(*id) - vec3(0.0, weight, 0.0);
            assert!(off.length() < 1.0e-3 * weight, "{what}: {off:?} of {weight} N");
        }
        assert_eq!(events.contact_forces.len(), 3, "{what}");
        for pair in &events.contact_forces {
            let points = events.points_of(pair);
            let sum: f32 = points.iter().map(|p| p.impulse).sum();
            assert!((sum - pair.normal_impulse).abs() <= 1.0e-6 * sum, "{what}");
            let mean = pair.normal_impulse * rate;
            assert!((pair.force.length() - mean).abs() < 1.0e-3 * mean, "{what}");
            // The load is constant: no substep differs from the mean.
            let most = pair.greatest_force;
            assert!((most - mean).abs() < 1.0e-2 * mean, "{what}: {most} of {mean} N");
            assert!(points.iter().all(|p| p.position.is_finite() && p.normal.y.abs() > 0.99));
        }
    }
}

#[test]
fn the_impulses_of_a_fall_are_the_momentum_that_it_loses() {
    for (kind, scale, bounce) in ["plane", "box", "mesh"]
        .into_iter()
        .flat_map(|k| [0.1, 1.0, 100.0].map(|s| (k, s)))
        .flat_map(|(k, s)| [0.0_f32, 0.6].map(|e| (k, s, e)))
    {
        let mut world = world(kind, scale);
        let mut def = crate_at(1.0, scale).with_linear_velocity(vec3(0.7, -3.0, 0.2) * scale);
        def.shapes[0].material.restitution = bounce;
        def.rotation = Quat::from_axis_angle(vec3(1.0, 2.0, 3.0), 0.4);
        def.can_sleep = false;
        let id = world.add_body(def).unwrap();
        let mass = world.body(id).unwrap().mass();
        let (dt, gravity) = (1.0 / 60.0, vec3(0.0, -G, 0.0) * scale);
        let before = world.body(id).unwrap().linear_velocity();
        let mut given = Vec3::ZERO;
        let steps = 120_u8;
        for _ in 0..steps {
            let v = world.body(id).unwrap().linear_velocity();
            world.step(dt);
            let impulse = world.events().contact_forces.iter().fold(Vec3::ZERO, |sum, pair| {
                sum + pair.impulse * if pair.body_b == id { 1.0 } else { -1.0 }
            });
            // The sum over each step, to a few roundings of its momentum.
            let change = (world.body(id).unwrap().linear_velocity() - v - gravity * dt) * mass;
            let off = (change - impulse).length();
            let size = mass * (v.length() + impulse.length() / mass + G * scale * dt);
            assert!(off < 1.0e-4 * size, "{kind} x{scale}: {impulse:?} for {change:?}");
            given += impulse;
        }
        let after = world.body(id).unwrap().linear_velocity();
        let change = (after - before - gravity * (dt * f32::from(steps))) * mass;
        let off = (change - given).length();
        assert!(off < 1.0e-4 * mass * 10.0 * scale, "{kind} x{scale}: {given:?} for {change:?}");
    }
}

#[test]
fn a_hit_tells_the_impulse_that_stops_the_fall() {
    for (kind, scale) in
        ["plane", "box", "mesh"].into_iter().flat_map(|k| [0.1, 1.0, 100.0].map(|s| (k, s)))
    {
        for (height, bounce) in [(0.5, 0.0), (2.0, 0.0), (2.0, 0.5)] {
            let mut world = world(kind, scale);
            let mut def = crate_at(height + 0.25, scale);
            def.shapes[0].material.restitution = bounce;
            let id = world.add_body(def).unwrap();
            let mass = world.body(id).unwrap().mass();
            let mut hits: Vec<HitEvent> = Vec::new();
            for _ in 0..60 {
                world.step(1.0 / 60.0);
                hits.extend(&world.events().hits);
                if !hits.is_empty() {
                    break;
                }
            }
            let what = format!("{kind} x{scale} from {height} m, {bounce}: {hits:?}");
            assert_eq!(hits.len(), 1, "{what}");
            let wanted = mass * (1.0 + bounce) * hits[0].speed;
            // Gravity still acts in the step.
            let weight = mass * G * scale / 60.0;
            assert!((hits[0].impulse - wanted).abs() <= weight + 0.02 * wanted, "{what} {wanted}");
        }
    }
}

/// A plank on its edge falls over: its far edge lands although the pair touches all the time.
#[test]
fn what_falls_over_lands_with_its_other_end() {
    for kind in ["plane", "box", "mesh"] {
        for turn in [0.0_f32, 0.5, 1.0] {
            let mut world = world(kind, 1.0);
            let shape = ShapeDef::box_half([0.05, 0.6, 0.2]);
            let mut def = BodyDef::dynamic().with_shape(shape).with_position([0.0, 0.6, 0.0]);
            def.rotation = Quat::from_axis_angle([0.0, 1.0, 0.0], turn);
            let along = def.rotation.rotate(vec3(0.0, 0.0, -1.0));
            // It rotates about the edge that it stands on.
            def.angular_velocity = along;
            def.linear_velocity = along.cross(vec3(0.0, 0.6, 0.0));
            world.add_body(def).unwrap();
            let mut hits: Vec<HitEvent> = Vec::new();
            for _ in 0..180 {
                world.step(1.0 / 60.0);
                hits.extend(&world.events().hits);
            }
            // The end lands at √(3 g l), where l is the length that rotates about the edge.
            let speed = (3.0 * G * 1.2_f32).sqrt();
            let far: Vec<_> = hits.iter().filter(|hit| hit.speed > 0.6 * speed).collect();
            assert_eq!(far.len(), 1, "{kind}: {hits:?}");
            assert!(far[0].point.length() > 0.9, "{kind}: {hits:?}");
            assert!(far[0].impulse > 0.0, "{kind}: {hits:?}");
        }
    }
}

fn hits_of(a: ContactReports, b: ContactReports, height: f32) -> [usize; 4] {
    let mut world = World::default();
    let floor = ShapeDef::half_space(Vec3::Y, 0.0).with_reports(a);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let ball = ShapeDef::sphere(0.25).with_reports(b);
    let ball = BodyDef::dynamic().with_position([0.0, 0.25 + height, 0.0]).with_shape(ball);
    let id = world.add_body(ball).unwrap();
    let mut counts = [0; 4];
    for step in 0..120 {
        if step == 100 {
            world.body_mut(id).unwrap().set_linear_velocity([0.0, 5.0, 0.0]);
        }
        world.step(1.0 / 60.0);
        let e = world.events();
        let forces = usize::from(!e.contact_forces.is_empty());
        let now = [e.contact_begin.len(), e.contact_end.len(), e.hits.len(), forces];
        counts.iter_mut().zip(now).for_each(|(sum, n)| *sum += n);
    }
    counts
}

#[test]
fn shapes_report_what_they_are_asked_for() {
    let all = ContactReports::default();
    let at = |speed: f32| ContactReports { hit_speed: Some(speed), ..all };
    // From 0.2 m it lands at 2 m/s; the world's threshold is 1 m/s.
    let few = hits_of(all, all, 0.2);
    assert_eq!(few[..3], [1, 1, 1]);
    assert_eq!(few[3], 0, "nobody asked for forces");
    for (a, b) in [(ContactReports::NONE, all), (all, ContactReports::NONE)] {
        assert_eq!(hits_of(a, b, 0.2), [0; 4]);
        let a = ContactReports { forces: true, ..a };
        assert!(hits_of(a, b, 0.2)[3] > 30, "one that asks is enough");
    }
    let silent = ContactReports { hits: false, ..all };
    assert_eq!(hits_of(all, silent, 0.2)[..3], [1, 1, 0]);
    assert_eq!(hits_of(all, at(3.0), 0.2)[2], 0);
    assert_eq!(hits_of(at(3.0), all, 0.2)[2], 0);
    assert_eq!(hits_of(at(1.5), at(3.0), 0.2)[2], 1, "the lower counts");
    // 0.5 m/s, below the world's threshold.
    assert_eq!(hits_of(all, all, 0.0125)[2], 0);
    assert_eq!(hits_of(all, at(0.2), 0.0125)[2], 1);
    let error = at(f32::NAN).validate().unwrap_err().to_string();
    assert!(error.contains("hit_speed"), "{error}");
}

#[test]
fn reports_can_change_and_live_in_snapshots() {
    let mut world = world("box", 1.0);
    let id = world.add_body(crate_at(0.25, 1.0)).unwrap();
    world.body_mut(id).unwrap().set_can_sleep(false);
    let shape = world.body(id).unwrap().shapes().next().unwrap();
    world.step(1.0 / 60.0);
    world.step(1.0 / 60.0);
    assert_eq!(world.events().contact_forces.len(), 1);
    let mut again = World::restore(&world.snapshot()).unwrap();
    assert_eq!(again.events(), world.events());
    for world in [&mut world, &mut again] {
        world.step(1.0 / 60.0);
    }
    assert_eq!(again.events(), world.events());
    let reports = ContactReports { hit_speed: Some(0.25), ..ContactReports::default() };
    world.shape_mut(shape).unwrap().set_reports(reports).unwrap();
    assert_eq!(world.shape(shape).unwrap().reports(), reports);
    world.step(1.0 / 60.0);
    assert_eq!(world.events().contact_forces.len(), 0);
    assert!(World::restore(&world.snapshot()).is_ok());
    let bad = ContactReports { hit_speed: Some(-1.0), ..reports };
    assert!(world.shape_mut(shape).unwrap().set_reports(bad).is_err());
    assert_eq!(world.shape(shape).unwrap().reports(), reports);
    world.remove_shape(shape);
    assert!(World::restore(&world.snapshot()).is_ok());
}

/// Every method reports the impulse of a fall.
#[test]
fn classic_methods_tell_forces_too() {
    for method in drystone::method::Method::NAMES {
        let mut world = world("box", 1.0);
        let config = WorldConfig {
            method: drystone::method::Method::named(method).unwrap(),
            ..world.config().clone()
        };
        world.set_config(config).unwrap();
        let id = world.add_body(crate_at(0.25, 1.0)).unwrap();
        world.body_mut(id).unwrap().set_can_sleep(false);
        let mut sum = Vec3::ZERO;
        let steps = 240_u8;
        for _ in 0..steps {
            world.step(1.0 / 60.0);
            sum += world.events().contact_force_on(id);
        }
        let mean = sum / f32::from(steps);
        let weight = world.body(id).unwrap().mass() * G;
        let off = (mean - vec3(0.0, weight, 0.0)).length();
        assert!(off < 0.05 * weight, "{method}: {mean:?} of {weight} N");
    }
}
