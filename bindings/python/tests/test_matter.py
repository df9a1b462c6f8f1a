"""Particles, glue and fracture."""

import math

import drystone as ds
import numpy as np
import pytest
from conftest import DT, G


def test_a_pinned_rope_hangs_at_its_length() -> None:
    world = ds.World(config={"sleep.enabled": False})
    rope = world.add_rope([0, 0, 0], [1, 0, 0], 10, mass=1, pinned=(True, False), damping=2)
    assert rope.particles.shape == (11,) and rope.links.shape == (10,)
    world.step(DT, 1200)
    tip = world.particle_positions[-1]
    # After 20 s of damping it hangs straight down. A link is a spring of 1 / substep time, and bears
    # up to ten particles: together they give way by less than 10 · 10 g / (2 π f)².
    give = 10 * 10 * G / (2 * math.pi * 480) ** 2
    np.testing.assert_allclose(tip, [0, -1, 0], atol=give)
    links = world.links()
    assert links["length"].sum() == pytest.approx(1, rel=1e-5)


def test_a_falling_cloud_falls_and_can_be_assigned() -> None:
    world = ds.World()
    strand = world.add_cloud(np.array([[0, 5, 0], [1, 5, 0], [2, 5, 0]], float), mass=0.1)
    np.testing.assert_array_equal(world.particle_ids, strand.particles)
    world.step(DT, 30)
    heights = world.particle_positions[:, 1]
    np.testing.assert_allclose(heights, 5 - G * 0.5**2 / 2, atol=G * 0.5 * DT / 2)
    v = world.particle_velocities
    v[:] = 0
    world.particle_velocities = v
    places = world.particle_positions
    places[1] = [7, 7, 7]
    world.particle_positions = places
    np.testing.assert_array_equal(world.particle_positions, places)
    with pytest.raises(ds.DefError):
        world.particle_positions = places * np.nan


def test_a_cloth_lies_on_a_ball(floor: ds.World) -> None:
    floor.add_body("static", position=[0, 1, 0], shapes=ds.Shape.sphere(0.8))
    cloth = floor.add_cloth([-0.5, 2.2, -0.5], [1, 0, 0], [0, 0, 1], (8, 8), mass=0.5)
    assert len(cloth.particles) == 81
    floor.step(DT, 120)
    middle = floor.particle_positions[40]
    assert np.linalg.norm(middle - [0, 1, 0]) == pytest.approx(0.8, abs=0.05)


def test_particles_hold_bodies_and_let_them_go() -> None:
    world = ds.World()
    box = world.add_body(position=[0, -1, 0], shapes=ds.Shape.box_half([0.1] * 3), mass=1)
    rope = world.add_rope([0, 0, 0], [0, -0.9, 0], 9, mass=0.5, pinned=(True, False))
    tip = int(rope.particles[-1])
    world.attach_particle(tip, box, [0, 0.1, 0])
    world.step(DT, 120)
    assert box.position[1] == pytest.approx(-1, abs=0.03)
    world.detach_particle(tip)
    world.step(DT, 60)
    assert box.position[1] < -1 - G / 2 * 0.9
    world.pin_particle(tip)
    place = world.particle_positions[-1].copy()
    world.step(DT, 10)
    np.testing.assert_array_equal(world.particle_positions[-1], place)
    world.remove_particle(tip)
    with pytest.raises(ds.DefError) as gone:
        world.pin_particle(tip)
    assert gone.value.kind == "missing"


def test_a_link_tears_under_load() -> None:
    world = ds.World()
    a = world.add_particle([0, 0, 0], pinned=True)
    b = world.add_particle([0, -1, 0], mass=1)
    link = world.add_link(a, b, "equal", tear_force=G / 2)
    torn: list[int] = []
    for _ in range(30):
        world.step(DT)
        torn += list(world.events.link_tear["link"])
    assert torn == [link]


def test_a_pane_breaks_when_it_is_hit_and_keeps_its_mass(floor: ds.World) -> None:
    pane = floor.add_body(
        position=[0, 1, 0],
        shapes=ds.Shape.box_half([1, 1, 0.05]),
        fracture={"impulse": 1.0, "pieces": 8, "seed": 3},
    )
    floor.add_body(position=[0, 1, -3], shapes=ds.Shape.sphere(0.2), linear_velocity=[0, 0, 20])
    mass, fractures, pieces = pane.mass, [], []
    for _ in range(30):
        floor.step(DT)
        fractures += list(floor.events.fractures)
        pieces += list(floor.events.pieces)
    assert len(fractures) == 1 and fractures[0]["body"] == pane.id
    assert fractures[0]["cause"] in ("impulse", "energy") and not pane.exists
    assert fractures[0]["piece_count"] == len(pieces) > 1
    assert sum(floor.body(piece).mass for piece in pieces) == pytest.approx(mass, rel=1e-3)


def test_a_body_can_be_broken_by_hand(floor: ds.World) -> None:
    cube = floor.add_body(position=[0, 3, 0], shapes=ds.Shape.box_half([0.5] * 3))
    pieces = cube.break_at([0, 3, 0], pieces=6)
    assert 2 <= len(pieces) <= 6 and not cube.exists
    assert sum(piece.mass for piece in pieces) == pytest.approx(1000, rel=1e-3)
    with pytest.raises(ds.DefError):
        pieces[0].break_at([0, 3, 0], pieces=1)


def test_glue_holds_its_own_weight_and_breaks_under_a_load() -> None:
    def bridge(load: float) -> tuple[int, ds.World]:
        world = ds.World()
        for x in (-1.9, 1.9):
            world.add_body("static", position=[x, -0.5, 0], shapes=ds.Shape.box_half([0.2, 0.3, 0.5]))
        planks = [
            ds.Shape.box_half([0.5, 0.2, 0.5], position=[x, 0, 0]) for x in (-1.5, -0.5, 0.5, 1.5)
        ]
        world.add_body(shapes=planks, glue=4e5, density=500)
        if load > 0:
            world.add_body(
                position=[0, 0.75, 0], shapes=ds.Shape.box_half([0.4, 0.5, 0.4]), mass=load
            )
        broken = 0
        for _ in range(120):
            world.step(DT)
            broken += len(world.events.bond_break)
        return broken, world

    # Bending by a load P in the middle of a beam of span L and section b h: 3 P L / (2 b h²). Its own
    # weight of 800 kg counts half. With L = 3.4 m, b = 1 m, h = 0.4 m: 125 kPa.
    def stress(load: float) -> float:
        return 3 * load * G * 3.4 / (2 * 1 * 0.4**2)

    # The glue holds 400 kPa. A load that falls by 5 cm presses more than it weighs.
    assert 3 * stress(800 / 2) < 4e5 < stress(4000 + 800 / 2) / 3
    assert bridge(0)[0] == 0
    assert bridge(4000)[0] > 0
