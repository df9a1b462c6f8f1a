//! A tree that is ready to compute with: its structure, and its numbers in lanes.

use core::ops::Range;

use super::check;
use super::def::{self, RowSoftness, TreeDef, TreeError, TreeJointKind, TreeLoop, TreeTendon};
use super::number::Number;
use super::spatial::{Rotation, Vector};
use super::work::TreeWork;

/// Smallest part of a diagonal entry of the mass matrix that a pivot may be, in double precision.
const MIN_PIVOT: f64 = 1.0e-13;

/// A link.
#[derive(Clone, Debug)]
pub(super) struct Link<N> {
    pub(super) parent: Option<usize>,
    pub(super) position: Vector<N>,
    pub(super) rotation: Rotation<N>,
    pub(super) joints: Range<usize>,
    pub(super) groups: Range<usize>,
    pub(super) dofs: Range<usize>,
    pub(super) mass: N,
    pub(super) center: Vector<N>,
    /// Columns g: the inertia about the center of mass is the sum of `g gᵀ` [link].
    pub(super) columns: [Vector<N>; 3],
}

/// A joint.
#[derive(Clone, Debug)]
pub(super) struct Joint<N> {
    pub(super) kind: TreeJointKind,
    pub(super) q: usize,
    pub(super) dof: usize,
    pub(super) anchor: Vector<N>,
    pub(super) axis: Vector<N>,
    pub(super) reference: N,
    pub(super) limited: bool,
    pub(super) range: [N; 2],
    pub(super) rest: N,
    pub(super) has_spring: bool,
}

/// A degree of freedom.
#[derive(Clone, Debug)]
pub(super) struct Dof<N> {
    pub(super) link: usize,
    pub(super) armature: N,
    pub(super) damping: N,
    pub(super) stiffness: N,
    pub(super) friction: N,
    pub(super) has_friction: bool,
}

/// A coupling of two coordinates.
#[derive(Clone, Debug)]
pub(super) struct Coupling<N> {
    pub(super) follower: usize,
    pub(super) leader: Option<usize>,
    pub(super) polynomial: [N; 5],
    pub(super) softness: RowSoftness,
}

/// A tree of links with its numbers as `N`: one tree in `f64` or `f32`, or the same tree in
/// several worlds side by side, whose masses and other numbers may differ.
///
/// `q` and `v` are sized and ordered as in MuJoCo: joint after joint in the order of the links.
#[derive(Clone, Debug)]
pub(crate) struct Tree<N> {
    pub(super) links: Vec<Link<N>>,
    pub(super) joints: Vec<Joint<N>>,
    /// Ranges of degrees of freedom whose axes move together: one each for hinge and slide, three
    /// for a ball, three and three for a free joint.
    pub(super) groups: Vec<Range<usize>>,
    pub(super) dofs: Vec<Dof<N>>,
    /// For each degree of freedom the start of its row in `path` and in the mass matrix; one more.
    pub(super) rows: Vec<usize>,
    /// Each row: the degree of freedom itself, then its ancestors upward.
    pub(super) path: Vec<usize>,
    pub(super) couplings: Vec<Coupling<N>>,
    pub(super) tendons: Vec<TreeTendon>,
    pub(super) loops: Vec<TreeLoop>,
    pub(super) q_count: usize,
    /// Coordinates at which the links have their defined poses.
    pub(super) q_reference: Vec<N>,
    pub(super) gravity: Vector<N>,
}

impl Tree<f64> {
    /// Checks the definition and makes the tree, with the gravity \[m/s², world\].
    ///
    /// # Errors
    /// A number that is not finite or out of range, a cycle, an impossible inertia, or a joint that
    /// moves no inertia and has no armature.
    pub(crate) fn new(def: &TreeDef, gravity: [f64; 3]) -> Result<Self, TreeError> {
        check::check(def)?;
        if !gravity.iter().all(|g| g.abs() <= 1.0e6) {
            return Err(TreeError::new("gravity", format!("{gravity:?}"), "-1e6 to 1e6"));
        }
        let mut tree = Self {
            links: Vec::new(),
            joints: Vec::new(),
            groups: Vec::new(),
            dofs: Vec::new(),
            rows: vec![0],
            path: Vec::new(),
            couplings: Vec::new(),
            tendons: def.tendons.clone(),
            loops: def.loops.clone(),
            q_count: 0,
            q_reference: Vec::new(),
            gravity: Vector(gravity),
        };
        for link in &def.links {
            tree.add_link(link);
        }
        let at = |(link, joint): (usize, usize)| tree.links[link].joints.start + joint;
        tree.couplings = def
            .couplings
            .iter()
            .map(|c| Coupling {
                follower: at(c.follower),
                leader: c.leader.map(at),
                polynomial: c.polynomial,
                softness: c.softness,
            })
            .collect();
        tree.check_inertia()?;
        Ok(tree)
    }

    fn add_link(&mut self, def: &def::LinkDef) {
        let index = self.links.len();
        let (joints, groups, dofs) = (self.joints.len(), self.groups.len(), self.dofs.len());
        let rotation = Rotation(def.rotation).normalized();
        // The last degree of freedom of the nearest ancestor that has one.
        let mut above = def.parent;
        let mut parent_dof = None;
        while let Some(link) = above {
            let range = &self.links[link].dofs;
            if !range.is_empty() {
                parent_dof = Some(range.end - 1);
                break;
            }
            above = self.links[link].parent;
        }
        for joint in &def.joints {
            self.add_joint(index, joint, &mut parent_dof, def.position, rotation);
        }
        let columns = check::factor(def.inertia).unwrap_or_default().map(Vector);
        self.links.push(Link {
            parent: def.parent,
            position: Vector(def.position),
            rotation,
            joints: joints..self.joints.len(),
            groups: groups..self.groups.len(),
            dofs: dofs..self.dofs.len(),
            mass: def.mass,
            center: Vector(def.center),
            columns,
        });
    }

    fn add_joint(
        &mut self,
        link: usize,
        def: &def::TreeJoint,
        parent_dof: &mut Option<usize>,
        position: [f64; 3],
        rotation: Rotation<f64>,
    ) {
        let dof = self.dofs.len();
        let q = self.q_count;
        let (dof_count, identity) = match def.kind {
            TreeJointKind::Hinge | TreeJointKind::Slide => (1, vec![def.reference]),
            TreeJointKind::Ball => (3, vec![1.0, 0.0, 0.0, 0.0]),
            TreeJointKind::Free => (6, [&position[..], &rotation.0[..]].concat()),
        };
        let group = if dof_count == 6 { 3 } else { dof_count };
        for start in (dof..dof + dof_count).step_by(group) {
            self.groups.push(start..start + group);
        }
        self.q_count += identity.len();
        self.q_reference.extend(identity);
        let axis = Vector(def.axis);
        let axis = axis * (1.0 / axis.length().max(f64::MIN_POSITIVE));
        self.joints.push(Joint {
            kind: def.kind,
            q,
            dof,
            anchor: Vector(def.anchor),
            axis,
            reference: def.reference,
            limited: def.range.is_some(),
            range: def.range.unwrap_or_default(),
            rest: def.rest,
            has_spring: def.stiffness > 0.0,
        });
        for index in dof..dof + dof_count {
            self.dofs.push(Dof {
                link,
                armature: def.armature,
                damping: def.damping,
                stiffness: def.stiffness,
                friction: def.friction,
                has_friction: def.friction > 0.0,
            });
            self.path.push(index);
            if let Some(parent) = *parent_dof {
                let above = self.rows[parent]..self.rows[parent + 1];
                self.path.extend_from_within(above);
            }
            self.rows.push(self.path.len());
            *parent_dof = Some(index);
        }
    }

    /// Checks that every joint moves an inertia, at the reference coordinates.
    fn check_inertia(&self) -> Result<(), TreeError> {
        let mut work = TreeWork::new(self);
        self.place(&self.q_reference, &mut work);
        self.fill_mass_matrix(&mut work);
        let diagonal: Vec<f64> =
            (0..self.dofs.len()).map(|dof| work.matrix[self.rows[dof]]).collect();
        self.factor(&mut work, 0.0);
        for (dof, whole) in diagonal.into_iter().enumerate() {
            let pivot = work.pivots[dof];
            if !(pivot > 1.0e-30) || pivot <= 2.0 * MIN_PIVOT * whole {
                let joint = self.joints.partition_point(|joint| joint.dof <= dof) - 1;
                let link = self.dofs[dof].link;
                let index = joint - self.links[link].joints.start;
                let allowed = "an inertia about the joint above 0, or armature";
                let place = format!("links[{link}].joints[{index}]");
                return Err(TreeError::new(place, format!("inertia {pivot:e}"), allowed));
            }
        }
        Ok(())
    }

    /// The same tree in another precision, or in every lane.
    #[cfg_attr(not(test), expect(dead_code, reason = "the solver will take worlds in lanes"))]
    #[must_use]
    pub(crate) fn spread<N: Number>(&self) -> Tree<N> {
        let vector = |v: Vector<f64>| Vector::splat(v.0);
        let links = self.links.iter().map(|l| Link {
            parent: l.parent,
            position: vector(l.position),
            rotation: Rotation::splat(l.rotation.0),
            joints: l.joints.clone(),
            groups: l.groups.clone(),
            dofs: l.dofs.clone(),
            mass: N::splat(l.mass),
            center: vector(l.center),
            columns: l.columns.map(vector),
        });
        let joints = self.joints.iter().map(|j| Joint {
            kind: j.kind,
            q: j.q,
            dof: j.dof,
            anchor: vector(j.anchor),
            axis: vector(j.axis),
            reference: N::splat(j.reference),
            limited: j.limited,
            range: j.range.map(N::splat),
            rest: N::splat(j.rest),
            has_spring: j.has_spring,
        });
        let dofs = self.dofs.iter().map(|d| Dof {
            link: d.link,
            armature: N::splat(d.armature),
            damping: N::splat(d.damping),
            stiffness: N::splat(d.stiffness),
            friction: N::splat(d.friction),
            has_friction: d.has_friction,
        });
        let couplings = self.couplings.iter().map(|c| Coupling {
            follower: c.follower,
            leader: c.leader,
            polynomial: c.polynomial.map(N::splat),
            softness: c.softness,
        });
        Tree {
            links: links.collect(),
            joints: joints.collect(),
            groups: self.groups.clone(),
            dofs: dofs.collect(),
            rows: self.rows.clone(),
            path: self.path.clone(),
            couplings: couplings.collect(),
            tendons: self.tendons.clone(),
            loops: self.loops.clone(),
            q_count: self.q_count,
            q_reference: self.q_reference.iter().map(|&q| N::splat(q)).collect(),
            gravity: vector(self.gravity),
        }
    }
}

impl<N: Number> Tree<N> {
    /// Number of velocities `v`, the degrees of freedom.
    #[must_use]
    pub(crate) const fn v_count(&self) -> usize {
        self.dofs.len()
    }

    /// Number of links.
    #[must_use]
    pub(crate) const fn link_count(&self) -> usize {
        self.links.len()
    }

    /// Coordinates at which the links have their defined poses.
    #[must_use]
    pub(crate) fn reference(&self) -> &[N] {
        &self.q_reference
    }

    /// Where the coordinates and velocities of a joint begin in `q` and `v`, if the link has it.
    #[must_use]
    pub(crate) fn joint_start(&self, link: usize, joint: usize) -> Option<(usize, usize)> {
        let range = self.links.get(link)?.joints.clone();
        let joint = &self.joints[range].get(joint)?;
        Some((joint.q, joint.dof))
    }

    /// Whether the first link floats.
    pub(crate) fn floats(&self) -> bool {
        self.joints.first().is_some_and(|joint| joint.kind == TreeJointKind::Free)
    }

    /// Smallest part of a diagonal entry that a pivot may be, in this precision.
    pub(super) fn least_pivot() -> N {
        N::splat(MIN_PIVOT * (N::EPSILON / f64::EPSILON))
    }
}
