//! Numbers of MuJoCo for the same trees: `scripts/mujoco_reference.py` writes them.

use crate::reduced::spatial::{Spatial, Vector};
use crate::reduced::step::TreeState;
use crate::reduced::tree::Tree;
use crate::reduced::work::TreeWork;
use crate::reduced::{LinkDef, TreeDef, TreeJoint, TreeStepConfig};

use super::trees::GRAVITY;

/// A model with its numbers by name; a name occurs once for each state.
pub(super) struct Reference {
    pub(super) name: String,
    pub(super) def: TreeDef,
    fields: Vec<(String, Vec<f64>)>,
}

impl Reference {
    fn all(&self, name: &str) -> Vec<&[f64]> {
        self.fields.iter().filter(|(key, _)| key == name).map(|(_, v)| &v[..]).collect()
    }
}

/// The first numbers of a list, as an array.
fn take<const N: usize>(numbers: &mut impl Iterator<Item = f64>) -> [f64; N] {
    core::array::from_fn(|_| numbers.next().unwrap())
}

pub(super) fn references() -> Vec<Reference> {
    let mut models: Vec<Reference> = Vec::new();
    for line in include_str!("mujoco.txt").lines() {
        let (key, rest) = line.split_once(' ').unwrap();
        if key == "model" {
            models.push(Reference {
                name: rest.to_owned(),
                def: TreeDef::default(),
                fields: Vec::new(),
            });
            continue;
        }
        let model = models.last_mut().unwrap();
        match key {
            "link" => {
                let mut n = rest.split(' ').map(|x| x.parse::<f64>().unwrap());
                let parent = take::<1>(&mut n)[0];
                let parent = (0..model.def.links.len())
                    .find(|&i| (f64::from(u32::try_from(i).unwrap()) - parent).abs() < 0.5);
                model.def.links.push(LinkDef {
                    parent,
                    position: take(&mut n),
                    rotation: take(&mut n),
                    joints: Vec::new(),
                    mass: take::<1>(&mut n)[0],
                    center: take(&mut n),
                    inertia: take(&mut n),
                });
            }
            "joint" => {
                let (kind, rest) = rest.split_once(' ').unwrap();
                let mut n = rest.split(' ').map(|x| x.parse::<f64>().unwrap());
                let axis = take(&mut n);
                let joint = match kind {
                    "hinge" => TreeJoint::hinge(axis),
                    "slide" => TreeJoint::slide(axis),
                    "ball" => TreeJoint::ball(),
                    _ => TreeJoint::free(),
                };
                let joint = TreeJoint {
                    anchor: take(&mut n),
                    reference: take::<1>(&mut n)[0],
                    armature: take::<1>(&mut n)[0],
                    damping: take::<1>(&mut n)[0],
                    stiffness: take::<1>(&mut n)[0],
                    rest: take::<1>(&mut n)[0],
                    ..joint
                };
                model.def.links.last_mut().unwrap().joints.push(joint);
            }
            _ => {
                let numbers = rest.split(' ').map(|x| x.parse::<f64>().unwrap()).collect();
                model.fields.push((key.to_owned(), numbers));
            }
        }
    }
    models
}

/// Checks that two lists agree to a part of the largest number.
fn close(what: &str, ours: impl IntoIterator<Item = f64>, theirs: &[f64], part: f64) {
    let ours: Vec<f64> = ours.into_iter().collect();
    assert_eq!(ours.len(), theirs.len(), "{what}");
    let scale = theirs.iter().fold(1.0e-3_f64, |maximum, x| maximum.max(x.abs()));
    for (i, (a, b)) in ours.iter().zip(theirs).enumerate() {
        assert!((a - b).abs() <= part * scale, "{what}[{i}]: {a}, MuJoCo has {b} (of {scale})");
    }
}

/// The largest ratio of pivots: a bound of the digits that a solution loses is of its size.
fn spread(tree: &Tree<f64>, work: &mut TreeWork<f64>) -> f64 {
    tree.fill_mass_matrix(work);
    tree.factor(work, 0.0);
    let maximum = work.pivots.iter().fold(0.0_f64, |a, &b| a.max(b));
    maximum / work.pivots.iter().fold(f64::MAX, |a, &b| a.min(b))
}

#[test]
fn kinematics_dynamics_and_jacobians_are_those_of_mujoco() {
    // MuJoCo turns inertias into principal axes by iterations that stop at about 1e-12.
    let part = 1.0e-10;
    let mut states = 0;
    for model in references() {
        let tree = Tree::new(&model.def, GRAVITY).unwrap();
        let mut work = TreeWork::new(&tree);
        let nv = tree.v_count();
        for state in 0..model.all("q").len() {
            states += 1;
            let name = |field: &str| format!("{} {state} {field}", model.name);
            let get = |field: &str| model.all(field)[state];
            let (q, v, tau) = (get("q"), get("v"), get("tau"));
            tree.place(q, &mut work);
            tree.move_links(v, &mut work);
            let poses: Vec<_> =
                (0..tree.link_count()).map(|i| tree.pose(i, &work).unwrap()).collect();
            close(&name("position"), poses.iter().flat_map(|p| p.0.0), get("position"), part);
            let theirs = get("rotation").chunks(4);
            let turns = poses.iter().zip(theirs).flat_map(|(p, t)| {
                // q and -q are the same rotation.
                let dot: f64 = p.1.0.iter().zip(t).map(|(a, b)| a * b).sum();
                p.1.0.map(|x| x * dot.signum())
            });
            close(&name("rotation"), turns, get("rotation"), part);
            close(&name("mass"), tree.mass_matrix(&mut work), get("mass"), part);
            tree.bias(&mut work);
            close(&name("bias"), work.tau.clone(), get("bias"), part);
            let mut jacobian = vec![Spatial::zero(); nv];
            let last = tree.link_count() - 1;
            tree.jacobian(last, Vector([0.1, 0.2, 0.3]), &work, &mut jacobian);
            let column = |k: usize, linear: bool| {
                let part =
                    move |s: &Spatial<f64>| if linear { s.linear.0[k] } else { s.angular.0[k] };
                jacobian.iter().map(part).collect::<Vec<_>>()
            };
            close(&name("linear"), (0..3).flat_map(|k| column(k, true)), get("linear"), part);
            close(&name("angular"), (0..3).flat_map(|k| column(k, false)), get("angular"), part);
            close(&name("center"), tree.center_of_mass(&work).1.0, get("center"), part);
            let h = tree.momentum(&work);
            let both = h.angular.0.into_iter().chain(h.linear.0);
            close(&name("momentum"), both, get("momentum"), part);
            let potential = tree.gravity_energy(&work) + tree.spring_energy(q);
            let energy = [potential, tree.kinetic_energy(v, &work)];
            close(&name("energy"), energy, get("energy"), part);
            let inverse = tree.inverse_dynamics(q, v, get("a"), &mut work).to_vec();
            close(&name("inverse"), inverse, get("inverse"), part);
            let mut acceleration = vec![0.0; nv];
            tree.forward_dynamics(q, v, tau, &mut work, &mut acceleration);
            let lost = spread(&tree, &mut work);
            close(&name("acceleration"), acceleration, get("acceleration"), part + 1.0e-14 * lost);
        }
    }
    assert_eq!(states, 16);
}

/// The largest angle by which links differ after half a second from MuJoCo at 0.1 ms, and from
/// their start [°].
/// Also the change of energy, as a part of the largest kinetic energy.
fn swing(model: &Reference, h: f64) -> (f64, f64, f64) {
    let &[passive, drive, ref last @ ..] = model.all("swing")[0] else { panic!("no swing") };
    let mut def = model.def.clone();
    if passive < 0.5 {
        for joint in def.links.iter_mut().flat_map(|link| &mut link.joints) {
            joint.damping = 0.0;
            joint.stiffness = 0.0;
            joint.armature = 0.0;
        }
    }
    let tree = Tree::new(&def, GRAVITY).unwrap();
    let mut work = TreeWork::new(&tree);
    let mut state = TreeState::new(&tree);
    let tau: Vec<f64> =
        (0..tree.v_count()).map(|i| if i % 2 == 0 { drive } else { -drive }).collect();
    let energies = |state: &TreeState<f64>, work: &mut TreeWork<f64>| {
        tree.place(&state.q, work);
        tree.move_links(&state.v, work);
        (tree.kinetic_energy(&state.v, work), tree.gravity_energy(work))
    };
    let start_energy = energies(&state, &mut work).1;
    let (mut steps, mut most_kinetic) = (0.5 / h, 0.0_f64);
    while steps > 0.5 {
        tree.step(&mut state, &tau, h, &TreeStepConfig::default(), &mut work);
        most_kinetic = most_kinetic.max(energies(&state, &mut work).0);
        steps -= 1.0;
    }
    let (kinetic, potential) = energies(&state, &mut work);
    let gained = (kinetic + potential - start_energy) / most_kinetic;
    let turned = |q: &[f64], work: &mut TreeWork<f64>| {
        tree.place(q, work);
        (0..tree.link_count()).map(|i| tree.pose(i, work).unwrap().1).collect::<Vec<_>>()
    };
    let ours = turned(&state.q, &mut work);
    let theirs = turned(last, &mut work);
    let start = turned(tree.reference(), &mut work);
    let maximum = |a: &[crate::reduced::spatial::Rotation<f64>]| {
        let angles = a.iter().zip(&theirs).map(|(a, b)| a.times(b.inverse()).vector().length());
        angles.fold(0.0, f64::max)
    };
    (maximum(&ours).to_degrees(), maximum(&start).to_degrees(), gained)
}

/// Errors are about those of a second-order step, the square of rate times step; chains of balls
/// are chaotic. MuJoCo's own Euler has 7° for the humanoid, 35° for balls, both at 2 ms.
#[test]
fn swings_end_where_mujoco_ends_with_steps_of_a_tenth_of_a_millisecond() {
    let mut swings = 0;
    for model in references().iter().filter(|model| !model.all("swing").is_empty()) {
        swings += 1;
        let name = &model.name;
        let (coarse, turned, _) = swing(model, 0.01);
        let (error, _, gained) = swing(model, 0.002);
        let (fine, _, _) = swing(model, 0.001);
        assert!(turned > 1.0, "{name} {turned}");
        let maximum = if name.starts_with("balls") { 0.5 } else { 0.1 };
        assert!(error < maximum, "{name} is off by {error}° of {turned}° at 2 ms");
        let ratio = error / fine;
        // Dampers that stop a light link within a step are not yet in the range of the order.
        let minimum = if name.ends_with("free") { 3.0 } else { 2.0 };
        assert!(fine < 1.0e-3 || (minimum..5.0).contains(&ratio), "{name}: {error}° {fine}°");
        if ["ant", "cheetah", "hopper", "walker"].iter().any(|start| name.starts_with(start))
            || name == "humanoid-damped"
        {
            assert!(coarse < 0.5, "{name} is off by {coarse}° at 10 ms");
        }
        if name.ends_with("free") {
            assert!(gained.abs() < 1.0e-9, "{name} changes its energy by {gained:e}");
        }
    }
    assert_eq!(swings, 22);
}
