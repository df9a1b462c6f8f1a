"""Worlds built by hand: bodies, arrays, and physics with a known result."""

import copy
import math
import pickle

import drystone as ds
import numpy as np
import pytest
from conftest import DT, G


def test_a_ball_falls_as_far_as_galileo_says() -> None:
    world = ds.World()
    ball = world.add_body(position=[0, 10, 0], shapes=ds.Shape.sphere(0.5))
    world.step(DT, 60)
    # A first-order method with steps of DT is off by at most g t DT / 2.
    assert ball.position[1] == pytest.approx(10 - G / 2, abs=G * DT / 2)
    assert ball.linear_velocity[1] == pytest.approx(-G, rel=1e-5)


def test_a_box_slides_exactly_when_the_slope_exceeds_friction() -> None:
    friction = 0.5
    for slope, slides in [(0.95 * friction, False), (1.05 * friction, True)]:
        angle = math.atan(slope)
        gravity = [G * math.sin(angle), -G * math.cos(angle), 0]
        world = ds.World(gravity=gravity)
        world.add_body("static", shapes=ds.Shape.half_space(friction=friction))
        box = ds.Shape.box_half([0.5, 0.1, 0.5], friction=friction)
        body = world.add_body(position=[0, 0.1, 0], shapes=box)
        world.step(DT, 120)
        # Above the limit it is accelerated by g (sin - friction cos) for 2 s: some 0.4 m.
        pull = G * (math.sin(angle) - friction * math.cos(angle))
        if slides:
            assert body.position[0] == pytest.approx(pull * 2**2 / 2, rel=0.05)
        else:
            assert abs(body.position[0]) < 1e-3


def test_a_collision_keeps_momentum_and_swaps_velocities_of_equal_balls() -> None:
    world = ds.World(gravity=[0, 0, 0])
    shape = ds.Shape.sphere(0.5, restitution=1, friction=0)
    world.add_body(position=[-2, 0, 0], linear_velocity=[3, 0, 0], shapes=shape)
    world.add_body(position=[2, 0, 0], linear_velocity=[-1, 0, 0], shapes=shape)
    before = world.audit()["momentum"]["linear"]
    world.step(DT, 120)
    after = world.audit()["momentum"]["linear"]
    # Rounding of f32: a few parts in 10 million of 500 kg times 4 m/s.
    np.testing.assert_allclose(after, before, atol=1e-3 * 2000 * 1e-2)
    np.testing.assert_allclose(world.linear_velocities[:, 0], [-1, 3], atol=0.02)


def test_mass_comes_from_density_and_can_be_given(floor: ds.World) -> None:
    cube = ds.Shape.box_full([1, 2, 3], density=500)
    body = floor.add_body(position=[0, 5, 0], shapes=cube)
    assert body.mass == pytest.approx(3000, rel=1e-6)
    inertia = body.inertia
    assert inertia[0, 0] == pytest.approx(3000 * (2**2 + 3**2) / 12, rel=1e-5)
    given = floor.add_body(position=[5, 5, 0], shapes=cube, mass=2.0)
    assert given.mass == 2.0
    exact = floor.add_body(
        position=[9, 5, 0], shapes=cube, mass=2.0, inertia=np.eye(3), center_of_mass=[0, 0.1, 0]
    )
    np.testing.assert_allclose(exact.center_of_mass, [9, 5.1, 0], atol=1e-6)
    dense = floor.add_body(position=[15, 5, 0], shapes=[cube], density=1000)
    assert dense.mass == pytest.approx(6000, rel=1e-6)
    np.testing.assert_array_equal(floor.masses, [0, body.mass, 2, 2, dense.mass])


def test_rotations_are_w_first() -> None:
    world = ds.World(gravity=[0, 0, 0])
    half = math.sqrt(0.5)
    # A quarter turn about z takes the x axis of the box to y.
    body = world.add_body(
        rotation=[half, 0, 0, half], shapes=ds.Shape.box_half([2, 0.1, 0.1]), position=[0, 0, 0]
    )
    np.testing.assert_allclose(body.rotation, [half, 0, 0, half], atol=1e-6)
    hit = world.ray([0, 5, 0], [0, -10, 0])
    assert hit is not None and hit.point[1] == pytest.approx(2, abs=1e-5)
    np.testing.assert_allclose(world.rotations, [[half, 0, 0, half]], atol=1e-6)


def test_arrays_have_a_row_for_each_body_and_the_types_they_say(floor: ds.World) -> None:
    for x in range(3):
        floor.add_body(position=[x, 1, 0], shapes=ds.Shape.sphere(0.25), name=f"ball {x}")
    assert floor.body_count == 4
    for array, columns in [
        (floor.positions, 3),
        (floor.rotations, 4),
        (floor.linear_velocities, 3),
        (floor.angular_velocities, 3),
        (floor.centers_of_mass, 3),
    ]:
        assert array.shape == (4, columns) and array.dtype == np.float32
    assert floor.body_ids.dtype == np.uint64
    assert floor.body_names == ["floor", "ball 0", "ball 1", "ball 2"]
    assert [body.id for body in floor.bodies] == list(floor.body_ids)
    np.testing.assert_array_equal(floor.dynamic, [False, True, True, True])
    for row, body in zip(floor.positions, floor.bodies, strict=True):
        np.testing.assert_array_equal(row, body.position)


def test_assigning_an_array_moves_the_rows_that_differ_and_no_others(floor: ds.World) -> None:
    for x in range(3):
        floor.add_body(position=[3 * x, 0.25, 0], shapes=ds.Shape.box_half([0.25] * 3))
    floor.step(DT, 120)
    assert floor.asleep[1:].all()
    # The same numbers change nothing and wake nobody.
    before = floor.state_hash()
    floor.positions = floor.positions
    floor.rotations = floor.rotations
    floor.linear_velocities = floor.linear_velocities
    floor.angular_velocities = floor.angular_velocities
    assert floor.asleep[1:].all() and floor.state_hash() == before
    moved = floor.positions
    moved[2] += [0, 1, 0]
    floor.positions = moved
    np.testing.assert_array_equal(floor.positions, moved)
    np.testing.assert_array_equal(floor.asleep, [False, True, False, True])


def test_an_assignment_is_made_as_a_whole_or_not_at_all(floor: ds.World) -> None:
    for x in range(3):
        floor.add_body(position=[3 * x, 1, 0], shapes=ds.Shape.sphere(0.25))
    before = floor.positions
    bad = before + 1
    bad[3, 1] = np.nan
    with pytest.raises(ds.DefError) as refused:
        floor.positions = bad
    assert refused.value.field == "positions[3]"
    np.testing.assert_array_equal(floor.positions, before)
    with pytest.raises(ds.DefError):
        floor.rotations = np.zeros((4, 4))
    with pytest.raises(ds.DefError):
        floor.positions = before[:2]
    with pytest.raises(TypeError):
        floor.positions = [["a", "b", "c"]] * 4


def test_names_find_bodies_and_are_unique(floor: ds.World) -> None:
    ball = floor.add_body(position=[0, 1, 0], shapes=ds.Shape.sphere(0.5), name="ball")
    assert floor.body("ball") == ball and ball.name == "ball"
    assert floor.body(ball.id) == ball and floor.body(np.uint64(ball.id)) == ball
    with pytest.raises(ds.DefError) as refused:
        floor.add_body(name="ball", shapes=ds.Shape.sphere(0.5))
    assert refused.value.field == "name"
    with pytest.raises(ds.DefError) as absent:
        floor.body("bell")
    assert absent.value.kind == "missing"
    floor.remove_body("ball")
    # The name is free again.
    again = floor.add_body(position=[0, 1, 0], name="ball", shapes=ds.Shape.sphere(0.5))
    assert again.name == "ball" and again != ball


def test_a_removed_body_is_an_error_and_its_id_is_never_used_again(floor: ds.World) -> None:
    ball = floor.add_body(position=[0, 1, 0], shapes=ds.Shape.sphere(0.5))
    assert ball.exists
    ball.remove()
    assert not ball.exists
    for use in [
        lambda: ball.position,
        lambda: ball.apply_impulse([0, 1, 0]),
        ball.remove,
        ball.wake,
        lambda: floor.body(ball.id),
        lambda: floor.add_joint("ball", "floor", ball, at=[0, 0, 0]),
    ]:
        with pytest.raises(ds.DefError) as stale:
            use()
        assert stale.value.kind == "missing"
    assert floor.add_body("static").id != ball.id


def test_a_body_of_another_world_is_refused(floor: ds.World) -> None:
    other = ds.World()
    stranger = other.add_body(shapes=ds.Shape.sphere(0.5))
    with pytest.raises(ds.DefError) as refused:
        floor.remove_body(stranger)
    assert refused.value.kind == "missing" and stranger.exists


def test_impulses_and_forces_do_what_newton_says() -> None:
    world = ds.World(gravity=[0, 0, 0])
    shape = ds.Shape.box_half([0.5, 0.5, 0.5])
    bodies = [world.add_body(position=[3 * x, 0, 0], shapes=shape, mass=2) for x in range(4)]
    bodies[0].apply_impulse([2, 0, 0])
    bodies[1].add_step_force([2, 0, 0])
    bodies[2].set_lasting_force([2, 0, 0])
    bodies[3].apply_impulse([0, 2, 0], at=[9.5, 0, 0])
    world.step(DT, 60)
    v = world.linear_velocities
    assert v[0, 0] == pytest.approx(1, rel=1e-5)
    assert v[1, 0] == pytest.approx(DT, rel=1e-4)
    assert v[2, 0] == pytest.approx(1, rel=1e-4)
    assert v[3, 1] == pytest.approx(1, rel=1e-5)
    # Angular impulse r p = 0.5 · 2 about z, moment m (a² + b²) / 12 = 1/3.
    assert world.angular_velocities[3, 2] == pytest.approx(1 / (2 * 2 / 12), rel=1e-3)


def test_a_kinematic_body_moves_to_where_it_is_sent_and_pushes(floor: ds.World) -> None:
    pusher = floor.add_body("kinematic", position=[-2, 0.5, 0], shapes=ds.Shape.box_half([0.5] * 3))
    cube = floor.add_body(position=[-0.9, 0.5, 0], shapes=ds.Shape.box_half([0.5] * 3, friction=0))
    for step in range(1, 61):
        pusher.move_to([-2 + step / 60, 0.5, 0], DT)
        floor.step(DT)
    assert pusher.position[0] == pytest.approx(-1, abs=1e-4)
    assert cube.position[0] > pusher.position[0] + 1 - 0.01


def test_hull_and_mesh_come_from_arrays(floor: ds.World) -> None:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    hull = ds.Shape.hull(corners)
    assert hull.kind == "hull"
    vertices = hull.vertices
    assert vertices is not None and vertices.shape == (8, 3)
    body = floor.add_body(position=[0, 2, 0], shapes=hull)
    assert body.mass == pytest.approx(1000, rel=1e-4)
    ground = np.array([[-9, 0, -9], [-9, 0, 9], [9, 0, 9], [9, 0, -9]], np.float64)
    mesh = ds.Shape.mesh(ground, [[0, 1, 2], [0, 2, 3]])
    world = ds.World()
    world.add_body("static", shapes=mesh)
    ball = world.add_body(position=[0.3, 1, 0.2], shapes=ds.Shape.sphere(0.5))
    world.step(DT, 120)
    # It rests on the mesh; contacts keep to a fraction of a millimeter.
    assert ball.position[1] == pytest.approx(0.5, abs=1e-3)
    for points, triangles in [(ground, [[0, 1, 9]]), (ground, [[0, 1, -1]]), (ground, [])]:
        with pytest.raises(ds.DefError):
            ds.Shape.mesh(points, triangles)
    with pytest.raises(ds.DefError):
        ds.Shape.hull(ground)
    with pytest.raises(TypeError):
        ds.Shape.mesh(ground, [[0.5, 1, 2]])
    with pytest.raises(ds.DefError):
        world.add_body("dynamic", shapes=mesh)


def test_shapes_keep_their_options_and_replace_some() -> None:
    shape = ds.Shape.sphere(0.5, friction=0.3, density=10)
    other = shape.replace(restitution=0.5)
    assert other.friction == pytest.approx(0.3)
    assert (other.density, other.restitution) == (10, 0.5)
    assert shape.restitution == 0 and shape.kind == "sphere"
    kinds = [
        ds.Shape.capsule(0.5, 0.2),
        ds.Shape.cylinder(0.5, 0.2),
        ds.Shape.cone(0.5, 0.2),
        ds.Shape.cone(0.5, 0.2, 0.1),
        ds.Shape.box_full([1, 1, 1]),
        ds.Shape.half_space([0, 1, 0], 2),
    ]
    names = ["capsule", "cylinder", "cone", "cone", "box", "half_space"]
    assert [shape.kind for shape in kinds] == names


def test_config_is_set_by_path_and_refused_by_name() -> None:
    world = ds.World(config={"contact.hertz": 60, "sleep.enabled": False, "gravity": [0, -1, 0]})
    np.testing.assert_array_equal(world.gravity, [0, -1, 0])
    world.set_config("substeps", 4)
    world.gravity = [0, 0, -3]
    np.testing.assert_array_equal(world.gravity, [0, 0, -3])
    assert "contact.hertz" in ds.World.config_paths()
    for path, value in [("contact.hertz", -1), ("no.such", 1), ("method", "magic")]:
        with pytest.raises(ds.DefError):
            ds.World(config={path: value})
    assert ds.World(method="sequential-impulses").step_count == 0


def test_a_snapshot_goes_on_with_the_same_bits_also_after_pickling() -> None:
    world = ds.World("tower")
    world.step(n=30)
    saved = world.snapshot()
    world.step(n=90)
    end = world.state_hash()
    again = pickle.loads(pickle.dumps(saved))
    assert again.state_hash() == saved.state_hash() and again.step_count == 30
    for start in (saved, again, ds.Snapshot.from_bytes(saved.to_bytes())):
        later = start.world()
        later.step(n=90)
        assert later.state_hash() == end
    world.restore(saved)
    assert world.step_count == 30
    world.step(n=90)
    assert world.state_hash() == end


def test_copies_go_on_on_their_own() -> None:
    world = ds.World("tower")
    world.step(n=10)
    others = [world.copy(), copy.deepcopy(world), copy.copy(world), pickle.loads(pickle.dumps(world))]
    world.step(n=20)
    for other in others:
        assert other.step_count == 10
        other.step(n=20)
        assert other.state_hash() == world.state_hash()


def test_a_snapshot_keeps_bodies_added_by_hand_with_their_names(floor: ds.World) -> None:
    ball = floor.add_body(position=[0, 3, 0], shapes=ds.Shape.sphere(0.5), name="ball")
    floor.step(DT, 10)
    saved = pickle.loads(pickle.dumps(floor.snapshot()))
    other = saved.world()
    assert other.body("ball").id == ball.id
    np.testing.assert_array_equal(other.positions, floor.positions)
    height = ball.position[1]
    floor.step(DT, 10)
    floor.restore(saved)
    assert ball.position[1] == height


def test_damaged_snapshots_are_refused() -> None:
    data = ds.World("tower").snapshot().to_bytes()
    for broken in [b"", b"nonsense", data[:-1], data[: len(data) // 2], data + b"x", data[1:]]:
        with pytest.raises(ds.SnapshotError) as refused:
            ds.Snapshot.from_bytes(broken)
        assert refused.value.problem
    flipped = bytearray(data)
    flipped[len(data) // 2] ^= 0x55
    try:
        ds.Snapshot.from_bytes(bytes(flipped)).world().step(DT)
    except ds.SnapshotError:
        pass


def test_threads_change_no_bit() -> None:
    hashes = set()
    for threads in (1, 2, 3):
        world = ds.World("large_pyramid", threads=threads)
        world.step(n=20)
        hashes.add(world.state_hash())
    assert len(hashes) == 1


def test_the_audit_balances_energy(floor: ds.World) -> None:
    floor.add_body(position=[0, 2.5, 0], shapes=ds.Shape.sphere(0.5), mass=2)
    floor.begin_ledger()
    floor.step(DT, 240)
    ledger = floor.audit()["ledger"]
    assert ledger is not None and ledger["steps"] == 240
    # It comes to rest 2 m lower: all of m g h is dissipated.
    assert ledger["dissipated"] == pytest.approx(2 * G * 2, rel=1e-3)
    assert floor.audit()["energy"]["kinetic"] == pytest.approx(0, abs=1e-6)
    ended = floor.end_ledger()
    assert ended is not None and ended["dissipated"] == ledger["dissipated"]
    assert floor.audit()["ledger"] is None
    assert floor.counts()["dynamic"] == 1
