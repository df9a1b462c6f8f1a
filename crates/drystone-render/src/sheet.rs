//! Cloths as surfaces: every square of four threads is filled.

use std::sync::Arc;

use drystone::particle::{LinkKind, ParticleId};
use drystone::{Vec3, World};

use crate::form::Vertex;
use crate::groups::Groups;

/// A surface that changes with every picture.
#[derive(Debug)]
pub(crate) struct Sheet {
    /// Vertices [m, relative to the drawing's origin].
    pub(crate) vertices: Vec<Vertex>,
    /// Triangles. The same list is shared while no thread is added or removed.
    pub(crate) indices: Arc<[u32]>,
}

/// The surfaces among the particles of a world. A square with a torn thread is a hole. The squares
/// are kept between pictures, and found again only after a thread was added or removed.
#[derive(Debug, Default)]
pub(crate) struct Sheets {
    /// All threads in the world's order: slots of their ends.
    threads: Vec<[u32; 2]>,
    /// The threads of the current picture; a field so that its memory is reused.
    looked: Vec<[u32; 2]>,
    /// Positions of particles by slot [m, relative to the drawing's origin]; `None` for empty
    /// slots.
    places: Vec<Option<Vec3>>,
    /// Some square was left out because one of its corners does not exist.
    incomplete: bool,
    pieces: Vec<Piece>,
    /// Whether each particle is the corner of a square, by slot.
    covered: Vec<bool>,
    /// Whether each particle is an end of a thread, by slot.
    threaded: Vec<bool>,
    /// Threads that are sides of squares, sorted: slots, the lower one first.
    sides: Vec<[u32; 2]>,
}

/// A piece of cloth.
#[derive(Debug, Default)]
struct Piece {
    /// Slot of its first particle.
    first: u32,
    /// Slots of its vertices.
    slots: Vec<u32>,
    /// Corners of its squares, as vertex numbers.
    squares: Vec<[u32; 4]>,
    /// Two triangles per square.
    indices: Arc<[u32]>,
}

/// The corners of a square, in order around it.
type Square = [u32; 4];

impl Sheets {
    /// Reads the particles of a world, which may differ from the previous one. Positions are
    /// relative to `origin` [m, world].
    pub(crate) fn look(&mut self, world: &World, origin: Vec3) {
        self.looked.clear();
        for link in world.links().filter(|link| !matches!(link.kind(), LinkKind::Spring(_))) {
            self.looked.push(link.particles().map(ParticleId::index));
        }
        self.places.clear();
        for particle in world.particles().filter(|p| p.position().is_finite()) {
            let slot = particle.id().index() as usize;
            if slot >= self.places.len() {
                self.places.resize(slot + 1, None);
            }
            self.places[slot] = Some(particle.position() - origin);
        }
        let there = |slot: &u32| self.places.get(*slot as usize).is_some_and(Option::is_some);
        let all_there = self.pieces.iter().all(|piece| piece.slots.iter().all(there));
        if self.looked != self.threads || self.incomplete || !all_there {
            std::mem::swap(&mut self.looked, &mut self.threads);
            self.find();
        }
    }

    /// One surface for each piece of cloth, with the slot of its first particle.
    pub(crate) fn surfaces(&self) -> impl Iterator<Item = (u32, Sheet)> {
        self.pieces.iter().map(|piece| {
            let place = |slot: &u32| {
                let place = self.places.get(*slot as usize).copied().flatten();
                place.unwrap_or(Vec3::ZERO)
            };
            let mut normals = vec![Vec3::ZERO; piece.slots.len()];
            let places: Vec<Vec3> = piece.slots.iter().map(place).collect();
            for square in &piece.squares {
                let [a, b, c, d] = square.map(|vertex| places[vertex as usize]);
                // The normal of a square that need not be flat: the cross product of its diagonals.
                // Larger squares have more weight.
                let across = (c - a).cross(d - b);
                for vertex in square {
                    normals[*vertex as usize] += across;
                }
            }
            let vertex = |(p, n): (&Vec3, &Vec3)| Vertex::new(*p, n.normalize_or(Vec3::Y));
            let vertices = places.iter().zip(&normals).map(vertex).collect();
            (piece.first, Sheet { vertices, indices: Arc::clone(&piece.indices) })
        })
    }

    /// Whether a square contains this particle.
    pub(crate) fn cover(&self, particle: ParticleId) -> bool {
        self.covered.get(particle.index() as usize).copied().unwrap_or(false)
    }

    /// Whether a thread ends at this particle.
    pub(crate) fn is_threaded(&self, particle: ParticleId) -> bool {
        self.threaded.get(particle.index() as usize).copied().unwrap_or(false)
    }

    /// Whether this thread is the side of a square.
    pub(crate) fn cover_thread(&self, ends: [ParticleId; 2]) -> bool {
        self.sides.binary_search(&in_order(ends.map(ParticleId::index))).is_ok()
    }

    /// Finds the squares among the threads, and the pieces of cloth that they form.
    fn find(&mut self) {
        let mut threads: Vec<[u32; 2]> =
            self.threads.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
        threads.sort_unstable();
        threads.dedup();
        let count = threads.last().map_or(0, |[highest, _]| *highest as usize + 1);
        self.threaded.clear();
        self.threaded.resize(count, false);
        for [slot, _] in &threads {
            self.threaded[*slot as usize] = true;
        }
        let mut squares = squares(&threads);
        let all = squares.len();
        let there = |slot: &u32| self.places.get(*slot as usize).is_some_and(Option::is_some);
        squares.retain(|square| square.iter().all(there));
        self.incomplete = squares.len() < all;
        self.covered.clear();
        self.covered.resize(count, false);
        self.sides.clear();
        self.pieces.clear();
        // Piece of each particle: squares connect their corners.
        let mut groups = Groups::new(count);
        for square in &squares {
            for &corner in &square[1..] {
                groups.join(square[0] as usize, corner as usize);
            }
        }
        let mut piece_of: Vec<Option<usize>> = vec![None; count];
        let mut vertex_of: Vec<Option<u32>> = vec![None; count];
        for square in &squares {
            let first = groups.leader(square[0] as usize);
            let number = *piece_of[first].get_or_insert_with(|| {
                // Slots are stored as u32.
                let first = u32::try_from(first).unwrap_or(0);
                self.pieces.push(Piece { first, ..Piece::default() });
                self.pieces.len() - 1
            });
            let piece = &mut self.pieces[number];
            piece.squares.push(square.map(|slot| {
                *vertex_of[slot as usize].get_or_insert_with(|| {
                    piece.slots.push(slot);
                    u32::try_from(piece.slots.len() - 1).unwrap_or(u32::MAX)
                })
            }));
            for i in 0..4 {
                self.covered[square[i] as usize] = true;
                self.sides.push(in_order([square[i], square[(i + 1) % 4]]));
            }
        }
        self.sides.sort_unstable();
        self.sides.dedup();
        for piece in &mut self.pieces {
            let triangles = |[a, b, c, d]: &[u32; 4]| [*a, *b, *c, *a, *c, *d];
            piece.indices = piece.squares.iter().flat_map(triangles).collect();
        }
    }
}

/// Finds all rings of four threads. `threads` is sorted and has each thread in both directions. A
/// ring begins at its lowest slot and continues to the lower of its two neighbors. The rings of a
/// cloth therefore all have the same winding, because a cloth's particles are in row order.
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

#[cfg(test)]
mod tests {
    use drystone::particle::{ClothDef, RopeDef};
    use drystone::{Vec3, World, vec3};

    use super::{Sheet, Sheets};
    use crate::form::Vertex;

    fn look(sheets: &mut Sheets, world: &World) -> Vec<Sheet> {
        sheets.look(world, Vec3::ZERO);
        sheets.surfaces().map(|(_, sheet)| sheet).collect()
    }

    #[test]
    fn a_cloth_is_one_surface_that_faces_one_way_and_a_rope_is_none() {
        let mut world = World::default();
        let sides = [vec3(3.0, 0.0, 0.0), vec3(0.0, 0.0, 2.0)];
        let cloth = world.add_cloth(ClothDef::new(Vec3::ZERO, sides, [3, 2])).unwrap();
        let rope = RopeDef::between(vec3(0.0, 5.0, 0.0), vec3(1.0, 5.0, 0.0), 4);
        let rope = world.add_rope(rope).unwrap();
        let mut sheets = Sheets::default();
        let list = look(&mut sheets, &world);
        assert_eq!(list.len(), 1);
        let sheet = &list[0];
        assert_eq!((sheet.vertices.len(), sheet.indices.len()), (4 * 3, 3 * 2 * 6));
        // Winding from x toward z: the normal points down.
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
        let cloth = world.add_cloth(ClothDef::new(Vec3::ZERO, sides, [3, 1])).unwrap();
        let mut sheets = Sheets::default();
        assert_eq!(look(&mut sheets, &world).len(), 1);
        // The threads along the first side come first, three in each of two rows, then the threads
        // along the second.
        world.remove_link(cloth.links[1]);
        let list = look(&mut sheets, &world);
        let indices: Vec<usize> = list.iter().map(|s| s.indices.len()).collect();
        assert_eq!(indices, [6, 6], "the square between has lost a side");
        let below = cloth.links[4];
        let ends = world.link(below).unwrap().particles();
        assert!(!sheets.cover_thread(ends), "what is left of the torn square is a thread");
    }

    #[test]
    fn a_cloth_that_moves_keeps_its_triangles_and_another_world_has_its_own() {
        let mut world = World::default();
        let sides = [vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0)];
        world.add_cloth(ClothDef::new(Vec3::ZERO, sides, [4, 4])).unwrap();
        let mut sheets = Sheets::default();
        let before = look(&mut sheets, &world).remove(0);
        world.step(1.0 / 60.0);
        let after = look(&mut sheets, &world).remove(0);
        assert!(std::sync::Arc::ptr_eq(&before.indices, &after.indices));
        let bytes = |sheet: &Sheet| bytemuck::cast_slice::<Vertex, u8>(&sheet.vertices).to_vec();
        assert_ne!(bytes(&before), bytes(&after));
        let anew = look(&mut Sheets::default(), &world).remove(0);
        assert_eq!(bytes(&anew), bytes(&after));
        assert!(look(&mut sheets, &World::default()).is_empty());
    }
}
