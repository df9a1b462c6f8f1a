//! Per-frame calls, settings and rules in every state; none of them may move a resting body.

use std::sync::Arc;

use drystone::breakage::{BondStrength, Fracture};
use drystone::contact::SurfaceRule;
use drystone::events::{ContactReports, Senses};
use drystone::threads::{SimdLevel, Team};
use drystone::{
    AxisLocks, BodyId, BodyKind, Material, Pose, Quat, ShapeId, Vec3, World, WorldConfig, vec3,
};

use super::{FLOORS, Stack, each_in_all_states, shape_of};

/// A call without a result.
type Told = fn(&mut World, BodyId, ShapeId);

fn told_in_all_states(calls: &[(&str, Told)]) {
    for (name, call) in calls {
        let call = |w: &mut World, b: BodyId, s: ShapeId| {
            call(w, b, s);
            Ok(())
        };
        each_in_all_states(name, &[&call]);
    }
}

#[test]
fn bodies_are_pushed_and_moved_in_any_state() {
    told_in_all_states(&[
        ("put", |w, b, _| {
            let pose = w.body(b).unwrap().pose();
            let turn = Quat::from_axis_angle(Vec3::Y, 0.2) * pose.rotation;
            let pose = Pose::new(pose.position + vec3(0.1, 0.5, 0.0), turn);
            w.body_mut(b).unwrap().set_pose(pose);
        }),
        ("far", |w, b, _| w.body_mut(b).unwrap().set_pose(Pose::at([50.0, 20.0, 0.0]))),
        ("moved to", |w, b, _| {
            let pose = w.body(b).unwrap().pose();
            let pose = Pose { position: pose.position + vec3(0.0, 0.02, 0.01), ..pose };
            w.body_mut(b).unwrap().move_to(pose, super::DT);
        }),
        ("velocity", |w, b, _| w.body_mut(b).unwrap().set_linear_velocity([1.0, 2.0, 0.0])),
        ("spin", |w, b, _| w.body_mut(b).unwrap().set_angular_velocity([0.0, 3.0, 1.0])),
        ("impulse", |w, b, _| w.body_mut(b).unwrap().apply_impulse([2000.0, 0.0, 0.0])),
        ("impulse at", |w, b, _| {
            let at = w.body(b).unwrap().position() + vec3(0.0, 0.4, 0.2);
            w.body_mut(b).unwrap().apply_impulse_at([2000.0, 0.0, 0.0], at);
        }),
        ("twist", |w, b, _| w.body_mut(b).unwrap().apply_angular_impulse([0.0, 500.0, 0.0])),
        ("force", |w, b, _| w.body_mut(b).unwrap().add_step_force([0.0, 3.0e4, 0.0])),
        ("force at", |w, b, _| {
            let at = w.body(b).unwrap().position() + vec3(0.4, 0.0, 0.0);
            w.body_mut(b).unwrap().add_step_force_at([0.0, 3.0e4, 0.0], at);
        }),
        ("torque", |w, b, _| w.body_mut(b).unwrap().add_step_torque([0.0, 2.0e3, 0.0])),
        ("lasting force", |w, b, _| w.body_mut(b).unwrap().set_lasting_force([5.0e3, 0.0, 0.0])),
        ("lasting torque", |w, b, _| w.body_mut(b).unwrap().set_lasting_torque([0.0, 900.0, 0.0])),
        ("no weight", |w, b, _| w.body_mut(b).unwrap().set_gravity_scale(0.0)),
        ("locked", |w, b, _| w.body_mut(b).unwrap().set_locks(AxisLocks::ROTATION)),
        ("never sleeps", |w, b, _| w.body_mut(b).unwrap().set_can_sleep(false)),
        ("woken", |w, b, _| w.body_mut(b).unwrap().wake()),
    ]);
}

#[test]
fn what_bodies_bear_changes_in_any_state() {
    super::in_all_states(&[
        (
            "weak bonds",
            &[|w, b, _| w.body_mut(b).unwrap().set_bond_strength(BondStrength::both(1.0e3))],
        ),
        (
            "strong bonds",
            &[|w, b, _| w.body_mut(b).unwrap().set_bond_strength(BondStrength::both(1.0e9))],
        ),
        (
            "brittle",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_fracture(Some(Fracture::by_impulse(50.0).with_pieces(3)))
            }],
        ),
        ("not brittle", &[|w, b, _| w.body_mut(b).unwrap().set_fracture(None)]),
    ]);
}

#[test]
fn surfaces_and_reports_change_in_any_state() {
    super::in_all_states(&[
        (
            "ice",
            &[|w, _, s| {
                w.shape_mut(s)
                    .unwrap()
                    .set_material(Material { friction: 0.0, ..Material::default() })
            }],
        ),
        (
            "rubber",
            &[|w, _, s| {
                let rubber = Material { friction: 2.0, restitution: 0.8, ..Material::default() };
                w.shape_mut(s).unwrap().set_material(rubber)
            }],
        ),
        ("one way", &[|w, _, s| w.shape_mut(s).unwrap().set_one_way(Some(Vec3::Y))]),
        (
            "one way and both",
            &[
                |w, _, s| w.shape_mut(s).unwrap().set_one_way(Some(-Vec3::Y)),
                |w, _, s| w.shape_mut(s).unwrap().set_one_way(None),
            ],
        ),
        (
            "forces told",
            &[|w, _, s| {
                let reports = ContactReports { forces: true, ..ContactReports::default() };
                w.shape_mut(s).unwrap().set_reports(reports)
            }],
        ),
    ]);
    told_in_all_states(&[
        ("belt", |w, _, s| w.shape_mut(s).unwrap().set_surface_velocity([0.5, 0.0, 0.0])),
        ("turntable", |w, _, s| w.shape_mut(s).unwrap().set_surface_spin([0.0, 1.0, 0.0])),
        ("hooks", |w, _, s| w.shape_mut(s).unwrap().set_hooks(true)),
        ("senses", |w, _, s| {
            w.shape_mut(s).unwrap().set_senses(Senses { statics: true, sensors: true });
        }),
    ]);
}

#[test]
fn worlds_change_in_any_state() {
    let ice = SurfaceRule { friction: Some(0.0), ..SurfaceRule::ANY };
    super::in_all_states(&[
        (
            "another configuration",
            &[|w, _, _| {
                let config = w.config().clone();
                w.set_config(WorldConfig { substeps: 5, ..config })
            }],
        ),
        ("origin", &[|w, _, _| w.shift_origin([64.0, 0.0, -32.0])]),
    ]);
    let rules = move |w: &mut World, _: BodyId, _: ShapeId| w.set_surface_rules(vec![ice]);
    each_in_all_states("slick", &[&rules]);
    let between = move |w: &mut World, b: BodyId, _: ShapeId| {
        let other = w.bodies().map(|body| body.id()).find(|id| *id != b).unwrap();
        w.set_surface_between(b, other, Some(ice))
    };
    each_in_all_states("slick between two", &[&between]);
    told_in_all_states(&[
        ("up", |w, _, _| w.set_gravity([0.0, 3.0, 0.0])),
        ("all woken", |w, _, _| w.wake_all()),
        ("strangers", |w, b, _| {
            let all: Vec<BodyId> = w.bodies().map(|body| body.id()).collect();
            assert!(
                all.iter().filter(|id| **id != b).all(|id| w.set_bodies_collide(b, *id, false))
            );
        }),
        ("lowest SIMD level", |w, _, _| w.set_simd_level(SimdLevel::available()[0])),
        ("threads", |w, _, _| w.set_executor(Arc::new(Team::with_threads(2)))),
        ("ledger", |w, _, _| w.begin_ledger()),
    ]);
}

/// Changes that affect no force and no pose must not move a resting body: awake or asleep, on any
/// floor, at the bottom or in the middle.
#[test]
fn settings_move_nothing_that_stands() {
    let calls: &[(&str, Told)] = &[
        ("the pose it has", |w, b, _| {
            let pose = w.body(b).unwrap().pose();
            w.body_mut(b).unwrap().set_pose(pose);
        }),
        ("no velocity", |w, b, _| w.body_mut(b).unwrap().set_linear_velocity([0.0; 3])),
        ("no impulse", |w, b, _| w.body_mut(b).unwrap().apply_impulse([0.0; 3])),
        ("damping", |w, b, _| w.body_mut(b).unwrap().set_damping(0.5, 0.5)),
        ("locks", |w, b, _| w.body_mut(b).unwrap().set_locks(AxisLocks::ROTATION)),
        ("never sleeps", |w, b, _| w.body_mut(b).unwrap().set_can_sleep(false)),
        ("brittle", |w, b, _| {
            let vase = Fracture::by_impulse(1.0e6);
            w.body_mut(b).unwrap().set_fracture(Some(vase)).unwrap();
        }),
        ("friction", |w, _, s| {
            let rough = Material { friction: 1.0, ..Material::default() };
            w.shape_mut(s).unwrap().set_material(rough).unwrap();
        }),
        ("bounces", |w, _, s| {
            let ball = Material { restitution: 0.9, ..Material::default() };
            w.shape_mut(s).unwrap().set_material(ball).unwrap();
        }),
        ("reports", |w, _, s| {
            let reports = ContactReports { forces: true, ..ContactReports::default() };
            w.shape_mut(s).unwrap().set_reports(reports).unwrap();
        }),
        ("hooks", |w, _, s| w.shape_mut(s).unwrap().set_hooks(true)),
        ("user data", |w, b, _| w.body_mut(b).unwrap().set_user_data(7)),
        ("all woken", |w, _, _| w.wake_all()),
        ("rules that are none", |w, _, _| w.set_surface_rules(vec![SurfaceRule::ANY]).unwrap()),
        ("the configuration it has", |w, _, _| {
            let config = w.config().clone();
            w.set_config(config).unwrap();
        }),
        ("origin", |w, _, _| w.shift_origin([0.0; 3]).unwrap()),
    ];
    for (name, call) in calls {
        for under in FLOORS {
            for cube in [0, 2] {
                for asleep in [false, true] {
                    let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
                    if asleep {
                        stack = stack.asleep();
                    }
                    let body = stack.cubes[cube];
                    let shape = shape_of(&stack.world, body);
                    call(&mut stack.world, body, shape);
                    // Cubes that are not yet at rest sag by solver error.
                    stack.stands(&format!("{name}: cube {cube} on {under:?}, {asleep}"), 40, 0.02);
                }
            }
        }
    }
}
