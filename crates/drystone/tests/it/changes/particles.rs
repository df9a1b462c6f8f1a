//! Changes to existing particles and links.

use drystone::particle::{ClothDef, LinkId, ParticleId, RopeDef};
use drystone::{BodyDef, BodyId, DefError, ShapeDef, Vec3, World};

use super::{DT, Floor, floor, goes_on};

/// A cube on a rope under a ceiling, and a cloth draped over a ball.
struct Rigging {
    world: World,
    cube: BodyId,
    rope: Vec<ParticleId>,
    links: Vec<LinkId>,
    cloth: Vec<ParticleId>,
}

impl Rigging {
    fn new() -> Self {
        let mut world = World::default();
        floor(&mut world, Floor::Box, 1.0);
        let ceiling = world.add_body(BodyDef::fixed().with_position([0.0, 5.0, 0.0])).unwrap();
        let cube = BodyDef::dynamic().with_position([0.0, 1.8, 0.0]).with_mass(5.0);
        let cube = world.add_body(cube.with_shape(ShapeDef::box_half([0.2; 3]))).unwrap();
        let rope = world.add_rope(RopeDef::between([0.0, 5.0, 0.0], [0.0, 2.0, 0.0], 6)).unwrap();
        world.particle_mut(rope.particles[0]).unwrap().attach(ceiling, [0.0; 3]).unwrap();
        world.particle_mut(rope.particles[6]).unwrap().attach(cube, [0.0, 0.2, 0.0]).unwrap();
        let ball = BodyDef::fixed().with_position([4.0, 1.0, 0.0]);
        world.add_body(ball.with_shape(ShapeDef::sphere(0.8))).unwrap();
        let cloth = ClothDef::new([3.0, 2.0, -1.0], [Vec3::X * 2.0, Vec3::Z * 2.0], [4, 4]);
        let cloth = world.add_cloth(cloth).unwrap().particles;
        Self { world, cube, rope: rope.particles, links: rope.links, cloth }
    }
}

#[test]
fn particles_and_links_change_in_any_state() {
    type Change = fn(&mut Rigging) -> Result<(), DefError>;
    let changes: &[(&str, Change)] = &[
        ("heavy", |r| r.world.particle_mut(r.rope[3]).unwrap().set_mass(2.0)),
        ("let go", |r| {
            assert!(r.world.particle_mut(r.rope[6]).unwrap().detach());
            Ok(())
        }),
        ("tied on", |r| r.world.particle_mut(r.cloth[0]).unwrap().attach(r.cube, [0.2, 0.0, 0.0])),
        ("pinned", |r| {
            r.world.particle_mut(r.rope[3]).unwrap().set_pinned(true);
            Ok(())
        }),
        ("pinned and let go", |r| {
            r.world.particle_mut(r.cloth[12]).unwrap().set_pinned(true);
            r.world.step(DT);
            r.world.particle_mut(r.cloth[12]).unwrap().set_pinned(false);
            Ok(())
        }),
        ("put", |r| {
            r.world.particle_mut(r.rope[3]).unwrap().set_position([0.3, 3.5, 0.1]);
            Ok(())
        }),
        ("velocity", |r| {
            r.world.particle_mut(r.cloth[12]).unwrap().set_velocity([0.0, 3.0, 1.0]);
            Ok(())
        }),
        ("impulse", |r| {
            r.world.particle_mut(r.rope[2]).unwrap().apply_impulse([0.5, 0.0, 0.0]);
            Ok(())
        }),
        ("short", |r| {
            r.world.link_mut(r.links[1]).unwrap().set_length(0.2);
            Ok(())
        }),
        ("cut", |r| {
            assert!(r.world.remove_link(r.links[2]));
            Ok(())
        }),
        ("a bead gone", |r| {
            assert!(r.world.remove_particle(r.rope[2]));
            Ok(())
        }),
        ("its cube gone", |r| {
            assert!(r.world.remove_body(r.cube));
            Ok(())
        }),
    ];
    for (name, change) in changes {
        for rests in [20, 900] {
            let mut rigging = Rigging::new();
            (0..rests).for_each(|_| rigging.world.step(DT));
            change(&mut rigging).unwrap_or_else(|e| panic!("{name}: {e}"));
            let of = format!("{name} after {rests} steps");
            goes_on(&of, &mut rigging.world, |_| ());
            for id in rigging.rope.iter().chain(&rigging.cloth) {
                let is_gone = name == &"a bead gone" && *id == rigging.rope[2];
                let particle = rigging.world.particle(*id);
                assert_eq!(particle.is_none(), is_gone, "{of}");
                assert!(particle.is_none_or(|p| p.position().length() < 20.0), "{of}");
            }
        }
    }
}
