//! Floors with the same surface but different construction; all have their top at y = 0.

use drystone::{BodyDef, BodyKind, Material, Shape, ShapeDef, Vec3, vec3};

use crate::op::{BodyPlan, Form, Label, Op, Program, ShapePlan};

/// Construction of a floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Floor {
    /// One plane.
    HalfSpace,
    /// One box.
    Box,
    /// A grid of triangles.
    Mesh,
    /// Two mesh bodies with a common edge at x = 0.
    Pieces,
    /// One mesh whose halves meet at x = 0 with different corners: a rounding error apart, and
    /// T-junctions.
    Cracked,
    /// Static boxes side by side.
    Tiles,
    /// Static hulls side by side.
    Hulls,
    /// A kinematic box that does not move.
    Kinematic,
    /// A large dynamic box that lies on a plane.
    Raft,
    /// Dynamic boxes side by side on a plane.
    Crates,
    /// Kinematic boxes side by side that do not move.
    Row,
}

impl Floor {
    /// Constructions that act as one floor for bodies on it.
    pub(super) const WHOLE: [Self; 9] = [
        Self::HalfSpace,
        Self::Box,
        Self::Mesh,
        Self::Pieces,
        Self::Cracked,
        Self::Tiles,
        Self::Hulls,
        Self::Kinematic,
        Self::Raft,
    ];

    /// Constructions of bodies that could move.
    pub(super) const ROWS: [Self; 2] = [Self::Crates, Self::Row];
}

/// Bodies of a floor have labels below this.
pub(super) const FIRST_BODY: Label = 100;

/// Number of parts of a floor along x; even, so that there is a seam at x = 0.
const PARTS: u16 = 6;

/// The bodies of a floor store its half length, in micrometers.
const MICRO: f32 = 1.0e-6;

/// Half length of the floor of a program [m]; `None` if it has none.
pub(super) fn half_of(program: &Program) -> Option<f32> {
    let plan = program.ops.iter().find_map(|op| match op {
        Op::AddBody(plan) if plan.label < FIRST_BODY && plan.def.user_data > 0 => Some(plan),
        _ => None,
    })?;
    #[expect(clippy::cast_precision_loss, reason = "a length")]
    Some(plan.def.user_data as f32 * MICRO)
}

/// The program with another floor.
pub(super) fn with_floor(program: &Program, floor: Floor) -> Option<Program> {
    let half = half_of(program)?;
    let is_floor = |op: &Op| matches!(op, Op::AddBody(plan) if plan.label < FIRST_BODY);
    let material = program.ops.iter().find_map(|op| match op {
        Op::AddBody(plan) if plan.label < FIRST_BODY => Some(plan.shapes.last()?.def.material),
        _ => None,
    })?;
    let mut ops = floor_ops(floor, half, material);
    ops.extend(program.ops.iter().filter(|op| !is_floor(op)).cloned());
    Some(Program { ops, ..program.clone() })
}

/// Operations for a floor with this half length along x and z [m].
pub(super) fn floor_ops(floor: Floor, half: f32, material: Material) -> Vec<Op> {
    // About as thick as a part is wide: no thinner than the bodies on it.
    let thick = 0.25 * half;
    let mut bodies = Bodies { half, material, ops: Vec::new() };
    let plane = |offset: f32| Form::Plain(Shape::half_space(Vec3::Y, offset));
    match floor {
        Floor::HalfSpace => bodies.add(BodyKind::Static, Vec3::ZERO, plane(0.0)),
        Floor::Box | Floor::Kinematic => {
            let kind = if floor == Floor::Box { BodyKind::Static } else { BodyKind::Kinematic };
            let shape = Form::Plain(Shape::box_half(vec3(half, thick, half)));
            bodies.add(kind, vec3(0.0, -thick, 0.0), shape);
        }
        Floor::Mesh => {
            let xs: Vec<f32> = (0..=PARTS).map(|i| at(half, i)).collect();
            bodies.add(BodyKind::Static, Vec3::ZERO, grid(&[xs], half, 2));
        }
        Floor::Pieces => {
            let sides = [vec![-half, -0.5 * half, 0.0], vec![0.0, 0.5 * half, half]];
            for xs in sides {
                bodies.add(BodyKind::Static, Vec3::ZERO, grid(&[xs], half, 2));
            }
        }
        Floor::Cracked => {
            // The distance between adjacent f32 values at the size of the floor.
            let gap = half * f32::EPSILON;
            let left = vec![-half, -0.5 * half, 0.0];
            let right = vec![gap, half];
            bodies.add(BodyKind::Static, Vec3::ZERO, grid(&[left, right], half, 4));
        }
        Floor::Tiles | Floor::Hulls | Floor::Row | Floor::Crates => {
            let wide = half / f32::from(PARTS);
            let deep = if floor == Floor::Crates { wide } else { thick };
            let h = vec3(wide, deep, half);
            let corner = |i: u8| {
                let side = |bit: u8| if i & bit == 0 { -1.0 } else { 1.0 };
                h.mul_each(vec3(side(1), side(2), side(4)))
            };
            if floor == Floor::Crates {
                bodies.add(BodyKind::Static, Vec3::ZERO, plane(-2.0 * deep));
            }
            for i in 0..PARTS {
                let form = if floor == Floor::Hulls {
                    Form::Hull((0..8).map(corner).collect())
                } else {
                    Form::Plain(Shape::box_half(h))
                };
                let kind = match floor {
                    Floor::Row => BodyKind::Kinematic,
                    Floor::Crates => BodyKind::Dynamic,
                    _ => BodyKind::Static,
                };
                bodies.add(kind, vec3(at(half, i) + wide, -deep, 0.0), form);
            }
        }
        Floor::Raft => {
            let deep = 0.5 * thick;
            bodies.add(BodyKind::Static, Vec3::ZERO, plane(-2.0 * deep));
            let shape = Form::Plain(Shape::box_half(vec3(half, deep, half)));
            bodies.add(BodyKind::Dynamic, vec3(0.0, -deep, 0.0), shape);
        }
    }
    bodies.ops
}

/// Position where a part begins.
fn at(half: f32, i: u16) -> f32 {
    half * (2.0 * f32::from(i) / f32::from(PARTS) - 1.0)
}

struct Bodies {
    half: f32,
    material: Material,
    ops: Vec<Op>,
}

impl Bodies {
    fn add(&mut self, kind: BodyKind, position: Vec3, form: Form) {
        let label = 1 + 2 * Label::try_from(self.ops.len()).unwrap_or(0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length")]
        let user_data = (self.half / MICRO) as u64;
        let def = BodyDef { kind, position, user_data, ..BodyDef::default() };
        let shape = ShapeDef { material: self.material, ..ShapeDef::sphere(1.0) };
        let shapes = vec![ShapePlan { label: label + 1, form, def: shape }];
        self.ops.push(Op::AddBody(Box::new(BodyPlan { label, def, shapes, glue: None })));
    }
}

/// Flat triangles over strips with these x coordinates. The first strip has this number of cells
/// along z, the others one.
fn grid(strips: &[Vec<f32>], half: f32, cells: u16) -> Form {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for (number, xs) in strips.iter().enumerate() {
        let cells = if number == 0 { cells } else { 1 };
        let first = points.len();
        for x in xs {
            for k in 0..=cells {
                points.push(vec3(*x, 0.0, half * (2.0 * f32::from(k) / f32::from(cells) - 1.0)));
            }
        }
        let row = usize::from(cells) + 1;
        for i in 0..xs.len() - 1 {
            for k in 0..usize::from(cells) {
                let corner = |i: usize, k: usize| u32::try_from(first + i * row + k).unwrap_or(0);
                let [a, b, c, d] =
                    [corner(i, k), corner(i, k + 1), corner(i + 1, k), corner(i + 1, k + 1)];
                triangles.extend([[a, b, c], [c, b, d]]);
            }
        }
    }
    Form::Mesh(points, triangles)
}

#[cfg(test)]
mod tests {
    use drystone::{Material, World};

    use super::{Floor, floor_ops, half_of, with_floor};
    use crate::apply::{Done, Ids, apply};
    use crate::finding::Findings;
    use crate::op::{Program, Style};

    #[test]
    fn every_floor_is_taken_and_can_be_put_in_place_of_another() {
        let ops = floor_ops(Floor::Box, 3.0, Material::default());
        let config = drystone::WorldConfig::default();
        let program = Program { style: Style::Ordinary, config, ops };
        for floor in Floor::WHOLE.into_iter().chain(Floor::ROWS) {
            let other = with_floor(&program, floor).unwrap();
            assert!((half_of(&other).unwrap() - 3.0).abs() < 1.0e-5);
            let (mut world, mut ids) = (World::default(), Ids::default());
            for op in &other.ops {
                let done = apply(&mut world, &mut ids, op, &mut Findings::default(), 0);
                assert_eq!(done, Done::Yes, "{floor:?}");
            }
        }
    }
}
