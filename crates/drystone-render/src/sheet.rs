//! Cloths as surfaces: wherever four threads make a square, it is filled.

use drystone::{LinkKind, ParticleId, Vec3, World};

use crate::form::Vertex;

/// A surface that is another one in every picture.
#[derive(Debug, Default)]
pub(crate) struct Sheet {
    /// Relative to the drawing's origin [m].
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) indices: Vec<u32>,
}

/// The surfaces among the particles of a world. A square with a torn thread is a hole.
#[derive(Debug, Default)]
pub(crate) struct Sheets {
    /// One for each piece of cloth, with the slot of its first particle.
    pub(crate) list: Vec<(u32, Sheet)>,
    /// Particles of squares, by their slots.
    covered: Vec<bool>,
    /// Threads that are a side of a square, in order: slots, the lower one first.
    sides: Vec<[u32; 2]>,
}

/// The corners of a square, one after the other around it.
type Square = [u32; 4];

impl Sheets {
    /// What the threads of a world make; places are relative to `origin` [m, world].
    pub(crate) fn of(world: &World, origin: Vec3) -> Self {
        let mut threads: Vec<[u32; 2]> = Vec::new();
        for link in world.links().filter(|link| !matches!(link.kind(), LinkKind::Spring(_))) {
            let [a, b] = link.particles().map(ParticleId::index);
            threads.extend([[a, b], [b, a]]);
        }
        threads.sort_unstable();
        threads.dedup();
        let mut places: Vec<Option<Vec3>> = Vec::new();
        for particle in world.particles().filter(|p| p.position().is_finite()) {
            let slot = particle.id().index() as usize;
            if slot >= places.len() {
                places.resize(slot + 1, None);
            }
            places[slot] = Some(particle.position() - origin);
        }
        let there = |slot: u32| places.get(slot as usize).is_some_and(Option::is_some);
        let squares: Vec<Square> =
            squares(&threads).into_iter().filter(|s| s.iter().all(|&slot| there(slot))).collect();
        Self::fill(&squares, &places)
    }

    /// Whether a square shows this particle.
    pub(crate) fn cover(&self, particle: ParticleId) -> bool {
        self.covered.get(particle.index() as usize).copied().unwrap_or(false)
    }

    /// Whether a square shows the thread between these particles.
    pub(crate) fn cover_thread(&self, ends: [ParticleId; 2]) -> bool {
        self.sides.binary_search(&in_order(ends.map(ParticleId::index))).is_ok()
    }

    fn fill(squares: &[Square], places: &[Option<Vec3>]) -> Self {
        let mut sheets = Self { covered: vec![false; places.len()], ..Self::default() };
        // The piece that a particle belongs to: squares join their corners.
        let mut root: Vec<usize> = (0..places.len()).collect();
        for square in squares {
            for &corner in &square[1..] {
                let (a, b) =
                    (find(&mut root, square[0] as usize), find(&mut root, corner as usize));
                root[a.max(b)] = a.min(b);
            }
        }
        let mut sheet_of: Vec<Option<usize>> = vec![None; places.len()];
        let mut vertex_of: Vec<Option<u32>> = vec![None; places.len()];
        let mut normals: Vec<Vec<Vec3>> = Vec::new();
        for square in squares {
            let piece = find(&mut root, square[0] as usize);
            let number = *sheet_of[piece].get_or_insert_with(|| {
                // Slots are below 2^32: they came as such.
                sheets.list.push((u32::try_from(piece).unwrap_or(0), Sheet::default()));
                normals.push(Vec::new());
                sheets.list.len() - 1
            });
            let (sheet, normals) = (&mut sheets.list[number].1, &mut normals[number]);
            let corners = square.map(|slot| places[slot as usize].unwrap_or(Vec3::ZERO));
            let vertices = std::array::from_fn::<u32, 4, _>(|i| {
                *vertex_of[square[i] as usize].get_or_insert_with(|| {
                    sheet.vertices.push(Vertex::new(corners[i], Vec3::ZERO));
                    normals.push(Vec3::ZERO);
                    u32::try_from(sheet.vertices.len() - 1).unwrap_or(u32::MAX)
                })
            });
            let [a, b, c, d] = vertices;
            sheet.indices.extend([a, b, c, a, c, d]);
            // Of a square that is not flat: across its diagonals; larger ones count more.
            let across = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
            for vertex in vertices {
                normals[vertex as usize] += across;
            }
            for i in 0..4 {
                sheets.covered[square[i] as usize] = true;
                sheets.sides.push(in_order([square[i], square[(i + 1) % 4]]));
            }
        }
        sheets.sides.sort_unstable();
        sheets.sides.dedup();
        for ((_, sheet), normals) in sheets.list.iter_mut().zip(&normals) {
            for (vertex, normal) in sheet.vertices.iter_mut().zip(normals) {
                vertex.set_normal(normal.normalize_or(Vec3::Y));
            }
        }
        sheets
    }
}

/// All rings of four threads; `threads` has each both ways, in order. A ring begins at its lowest slot and goes on to
/// the lower of that one's neighbors, so that those of a cloth, which has its particles row by row, all turn the same way.
fn squares(threads: &[[u32; 2]]) -> Vec<Square> {
    let around = |slot: u32| {
        let begin = threads.partition_point(|thread| thread[0] < slot);
        let end = threads.partition_point(|thread| thread[0] <= slot);
        threads[begin..end].iter().map(|thread| thread[1])
    };
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(&[a, _]) = threads.get(at) {
        let above: Vec<u32> = around(a).filter(|&other| other > a).collect();
        at = threads.partition_point(|thread| thread[0] <= a);
        for (i, &b) in above.iter().enumerate() {
            for &d in &above[i + 1..] {
                for c in around(b).filter(|&c| c > a && c != d) {
                    if threads.binary_search(&[d, c]).is_ok() {
                        out.push([a, b, c, d]);
                    }
                }
            }
        }
    }
    out
}

fn in_order([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn find(root: &mut [usize], mut at: usize) -> usize {
    while root[at] != at {
        root[at] = root[root[at]];
        at = root[at];
    }
    at
}

#[cfg(test)]
mod tests {
    use drystone::{ClothDef, RopeDef, Vec3, World, vec3};

    use super::Sheets;

    #[test]
    fn a_cloth_is_one_surface_that_faces_one_way_and_a_rope_is_none() {
        let mut world = World::default();
        let sides = [vec3(3.0, 0.0, 0.0), vec3(0.0, 0.0, 2.0)];
        let cloth = world.add_cloth(&ClothDef::new(Vec3::ZERO, sides, [3, 2])).unwrap();
        let rope = RopeDef::between(vec3(0.0, 5.0, 0.0), vec3(1.0, 5.0, 0.0), 4);
        let rope = world.add_rope(&rope).unwrap();
        let sheets = Sheets::of(&world, Vec3::ZERO);
        assert_eq!(sheets.list.len(), 1);
        let sheet = &sheets.list[0].1;
        assert_eq!((sheet.vertices.len(), sheet.indices.len()), (4 * 3, 3 * 2 * 6));
        // x toward z: down.
        assert!(
            sheet.vertices.iter().all(|v| (Vec3::from(v.normal()) + Vec3::Y).length() < 1.0e-6)
        );
        assert!(cloth.particles.iter().all(|p| sheets.cover(*p)));
        assert!(!rope.particles.iter().any(|p| sheets.cover(*p)));
    }

    #[test]
    fn a_torn_thread_leaves_a_hole_and_pieces_are_apart() {
        let mut world = World::default();
        let sides = [vec3(3.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0)];
        let cloth = world.add_cloth(&ClothDef::new(Vec3::ZERO, sides, [3, 1])).unwrap();
        // Threads along the first side come first, three in each of two rows; then those along the second.
        world.remove_link(cloth.links[1]);
        let sheets = Sheets::of(&world, Vec3::ZERO);
        let indices: Vec<usize> = sheets.list.iter().map(|(_, s)| s.indices.len()).collect();
        assert_eq!(indices, [6, 6], "the square between has lost a side");
        let below = cloth.links[4];
        let ends = world.link(below).unwrap().particles();
        assert!(!sheets.cover_thread(ends), "what is left of the torn square is a thread");
    }
}
