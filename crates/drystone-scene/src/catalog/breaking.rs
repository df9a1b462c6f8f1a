//! Bodies that fracture, and walls of glued or joined bricks.

use drystone::breakage::{BondStrength, Fracture, Glue, JointStrength};
use drystone::joint::Fixed;
use drystone::{BodyDef, Quat, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{Lcg, add_ground, hull, real};
use crate::scene::{Scene, SceneJoint};

pub(super) fn fracture(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    add_ground(&mut scene, 0.6);
    scene.seconds = 6.0;
    let pieces = u32::try_from(values.whole("pieces")).unwrap_or(u32::MAX);
    let generations = u32::try_from(values.whole("generations")).unwrap_or(u32::MAX);
    let seed = values.whole("seed") as u64;
    let how = |energy: f32, number: u64| Fracture {
        pieces,
        generations,
        min_size: 0.04,
        seed: seed.wrapping_add(number),
        ..Fracture::by_energy(energy)
    };
    // Dropped from 4 m: 40 kJ a ton.
    let block = ShapeDef::box_full([0.8, 1.0, 0.8]).with_density(2400.0);
    let block = BodyDef::dynamic()
        .with_position([-3.0, 4.5, 0.0])
        .with_rotation(Quat::from_axis_angle(vec3(1.0, 0.0, 2.0), 0.5))
        .with_shape(block);
    scene.add("block", block.with_fracture(how(15_000.0, 1)));
    let mut random = Lcg::new(11);
    let points: Vec<Vec3> =
        (0..40).map(|_| random.direction().mul_each(vec3(0.7, 0.5, 0.6))).collect();
    let rock = ShapeDef::new(hull(&points)?).with_density(2600.0);
    let rock = BodyDef::dynamic().with_position([0.0, 6.0, -0.5]).with_shape(rock);
    scene.add("rock", rock.with_fracture(how(20_000.0, 2)));
    // A pane that stands on the ground, hit by a ball at 15 m/s.
    let pane = ShapeDef::box_full([2.4, 1.6, 0.06]).with_density(2500.0);
    let pane = BodyDef::dynamic().with_position([3.0, 0.8, 0.0]).with_shape(pane);
    let thin = Fracture { focus: 2, pieces: 3 * pieces.min(300), generations: 1, ..how(500.0, 3) };
    scene.add("pane", pane.with_fracture(thin));
    let ball = BodyDef::dynamic()
        .with_position([3.2, 1.1, 12.0])
        .with_linear_velocity([0.0, 3.0, -15.0])
        .with_shape(ShapeDef::sphere(0.15).with_density(7800.0));
    scene.add("ball", ball);
    Ok(scene)
}

/// Half extents of a brick of the walls that break [m].
const BRICK: Vec3 = vec3(0.25, 0.15, 0.125);

/// Strength of mortar [Pa].
const MORTAR: f32 = 2.5e5;

/// How the bricks of a wall hold together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Held {
    /// They are glued: one body.
    Glue,
    /// Fixed joints, one for each face that two of them share.
    Joints,
}

/// Adds a wall of `width` × `height` bricks that touch, each second row moved by half a brick.
pub(super) fn add_bonded_wall(
    scene: &mut Scene,
    (width, height): (usize, usize),
    held: Held,
) -> Result<(), CatalogError> {
    let mut bricks = Vec::with_capacity(width * height);
    for row in 0..height {
        let shift = if row % 2 == 1 { 0.5 } else { -0.5 };
        for i in 0..width {
            let x = (2.0 * (real(i) - 0.5 * real(width - 1)) + shift) * BRICK.x;
            let at = vec3(x, (2.0 * real(row) + 1.0) * BRICK.y, 0.0);
            bricks.push(ShapeDef::box_half(BRICK).with_position(at).with_density(2000.0));
        }
    }
    let glue = Glue::touching(&bricks, 1.0e-3, BondStrength::both(MORTAR))?;
    if held == Held::Glue {
        scene.add("wall", BodyDef { shapes: bricks, glue: Some(glue), ..BodyDef::default() });
        return Ok(());
    }
    let first = scene.bodies.len();
    for (i, brick) in bricks.iter().enumerate() {
        let at = brick.pose.position;
        let shape = brick.clone().with_position(Vec3::ZERO);
        let name = format!("brick {}/{}", i / width, i % width);
        scene.add(name, BodyDef::dynamic().with_position(at).with_shape(shape));
    }
    for bond in &glue.bonds {
        // Strength of a square of the face's area.
        let force = MORTAR * bond.area;
        let torque = force * bond.area.sqrt() / 6.0;
        let [a, b] = bond.shapes;
        let end = |brick: usize| (first + brick, bond.point - bricks[brick].pose.position);
        scene.joints.push(SceneJoint {
            strength: Some(JointStrength { force, torque, ..JointStrength::default() }),
            ..SceneJoint::new(end(a), end(b), Fixed::new())
        });
    }
    Ok(())
}
