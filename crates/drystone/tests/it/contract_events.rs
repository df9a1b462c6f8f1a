//! Every list of events has the order promised by the manual, for any number of threads.

use std::sync::Arc;

use drystone::breakage::JointStrength;
use drystone::events::{ContactReports, Events, FaultKind};
use drystone::joint::Fixed;
use drystone::particle::{LinkDef, LinkKind, LinkSpring, ParticleDef};
use drystone::threads::Team;
use drystone::{BodyDef, BodyId, JointDef, ShapeDef, Vec3, World, vec3};

const DT: f32 = 1.0 / 60.0;

/// Balls that fall on each other and on a floor, through a sensor. Every third ball was removed and
/// added again in reverse order, so that ids follow neither positions nor the order of adding.
fn heap() -> (World, Vec<BodyId>) {
    let mut world = World::default();
    let plane = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0).with_friction(1.0);
    world.add_body(BodyDef::fixed().with_shape(plane)).unwrap();
    let sensor = ShapeDef::box_half([4.0, 0.3, 4.0]).as_sensor();
    world.add_body(BodyDef::fixed().with_position([0.0, 1.5, 0.0]).with_shape(sensor)).unwrap();
    let reports = ContactReports { forces: true, ..ContactReports::default() };
    let add = |world: &mut World, i: u8| {
        let [x, y, z] = [i % 4, i / 16, i / 4 % 4].map(|k| 1.05 * f32::from(k));
        let shape = ShapeDef::sphere(0.5).with_reports(reports);
        let at = vec3(x - 1.6, 2.5 + y, z - 1.6);
        world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
    };
    let mut bodies: Vec<BodyId> = (0..64).map(|i| add(&mut world, i)).collect();
    for i in (0..64).step_by(3) {
        world.remove_body(bodies[i]);
    }
    for i in (0..64).rev().filter(|i| i % 3 == 0) {
        bodies[usize::from(i)] = add(&mut world, i);
    }
    (world, bodies)
}

/// Checks that every list is in order, and counts the events of each.
fn look(events: &Events, step: u64, counts: &mut [usize; 13]) {
    let e = events;
    assert!(e.contact_begin.is_sorted_by_key(|e| (e.shape_a, e.shape_b)), "{step}");
    assert!(e.contact_end.is_sorted_by_key(|e| (e.shape_a, e.shape_b)), "{step}");
    assert!(e.hits.is_sorted_by_key(|e| (e.shape_a, e.shape_b)), "{step}");
    assert!(e.contact_forces.is_sorted_by_key(|e| (e.shape_a, e.shape_b)), "{step}");
    assert!(e.sensor_enter.is_sorted_by_key(|e| (e.sensor, e.visitor)), "{step}");
    assert!(e.sensor_exit.is_sorted_by_key(|e| (e.sensor, e.visitor)), "{step}");
    assert!(e.sleep.is_sorted_by(|a, b| a < b), "{step}: {:?}", e.sleep);
    assert!(e.wake.is_sorted_by(|a, b| a < b), "{step}: {:?}", e.wake);
    assert!(e.joint_break.is_sorted_by_key(|e| e.joint), "{step}");
    assert!(e.link_tear.is_sorted_by_key(|e| e.link), "{step}");
    assert!(e.detached.is_sorted(), "{step}");
    // Refused calls, then bodies, then particles.
    let rank = |kind: &FaultKind, is_body: bool| match kind {
        FaultKind::NotFinite => 2 - u8::from(is_body),
        _ => 0,
    };
    let place = |f: &drystone::events::Fault| (rank(&f.kind, f.body.is_some()), f.body, f.particle);
    let aside: Vec<_> = e.faults.iter().map(place).filter(|place| place.0 > 0).collect();
    assert!(aside.is_sorted(), "{step}: {:?}", e.faults);
    assert!(e.faults.is_sorted_by_key(|f| rank(&f.kind, f.body.is_some())), "{step}");
    let lengths = [
        e.contact_begin.len(),
        e.contact_end.len(),
        e.hits.len(),
        e.contact_forces.len(),
        e.sensor_enter.len(),
        e.sensor_exit.len(),
        e.sleep.len(),
        e.wake.len(),
        e.joint_break.len(),
        e.link_tear.len(),
        e.detached.len(),
        e.faults.len(),
        e.force_points.len(),
    ];
    counts.iter_mut().zip(lengths).for_each(|(count, n)| *count += n);
}

/// Causes broken joints and links, particles on removed bodies, and bodies and particles that leave
/// the range of computation.
fn trouble(world: &mut World, bodies: &[BodyId]) {
    let ends: Vec<_> = (0..8_u8)
        .map(|i| {
            let at = vec3(20.0 + 3.0 * f32::from(i), 5.0, 0.0);
            let end = BodyDef::fixed().with_position(at);
            let end = world.add_body(end.with_shape(ShapeDef::sphere(0.1))).unwrap();
            let body = BodyDef::dynamic().with_position(at + Vec3::X);
            let body = world.add_body(body.with_shape(ShapeDef::sphere(0.2))).unwrap();
            (end, body)
        })
        .collect();
    for (end, body) in ends.iter().rev() {
        let strength = JointStrength { force: 1.0, ..JointStrength::default() };
        let joint = JointDef::new(*end, *body, Fixed::new()).with_anchors(Vec3::ZERO, -Vec3::X);
        world.add_joint(JointDef { strength: Some(strength), ..joint }).unwrap();
    }
    let points: Vec<_> = (0..16_u8)
        .map(|i| {
            let at = [60.0 + f32::from(i), 5.0, 0.0];
            world.add_particle(ParticleDef::at(at)).unwrap()
        })
        .collect();
    for pair in points[..8].chunks(2).rev() {
        let spring = LinkSpring::Rate { stiffness: 1.0e-3, damping: 0.0 };
        let link = LinkDef::new(pair[0], pair[1], LinkKind::Spring(spring));
        let link = LinkDef { length: Some(0.1), tear_strain: Some(0.5), ..link };
        world.add_link(link).unwrap();
    }
    for (point, body) in points[8..].iter().rev().zip(bodies) {
        let at = world.body(*body).unwrap().position();
        let mut point = world.particle_mut(*point).unwrap();
        point.set_position(at);
        point.attach(*body, Vec3::ZERO).unwrap();
    }
}

fn run(threads: usize) -> (Vec<Events>, [usize; 13]) {
    let (world, bodies) = heap();
    let mut world = world.with_executor(Arc::new(Team::with_threads(threads)));
    trouble(&mut world, &bodies);
    let (mut all, mut counts) = (Vec::new(), [0; 13]);
    for step in 0..420_u64 {
        match step {
            // 1e9 m/s² within a step disables them.
            200 => {
                for body in [bodies[40], bodies[3], bodies[21]] {
                    world.body_mut(body).unwrap().set_gravity_scale(1.0e3);
                }
                world.set_gravity([0.0, 1.0e6, 0.0]);
                world.body_mut(bodies[1]).unwrap().set_linear_velocity([f32::NAN, 0.0, 0.0]);
                world.step(0.2);
                world.set_gravity([0.0, -9.81, 0.0]);
            }
            210 => bodies[..8].iter().for_each(|body| {
                world.remove_body(*body);
            }),
            _ => world.step(DT),
        }
        look(world.events(), step, &mut counts);
        all.push(world.events().clone());
        // A disabled body did not fall asleep.
        let aside = |f: &drystone::events::Fault| f.body;
        let events = world.events();
        let faulted = events.faults.iter().filter(|f| f.kind == FaultKind::NotFinite);
        assert!(faulted.filter_map(aside).all(|body| !events.sleep.contains(&body)));
    }
    (all, counts)
}

#[test]
fn lists_of_events_are_in_the_order_of_the_manual_for_any_threads() {
    let (one, counts) = run(1);
    assert!(counts.iter().all(|count| *count > 1), "{counts:?}");
    for threads in [2, 4] {
        let (other, _) = run(threads);
        let first = one.iter().zip(&other).position(|(a, b)| a != b);
        assert_eq!(first, None, "{threads} threads");
    }
}
