"""Batches: world i is a single world, bit for bit."""

import pickle
from collections.abc import Callable

import drystone as ds
import numpy as np
import pytest
from conftest import DT
from hypothesis import given, settings
from hypothesis import strategies as st

ARM = """{
  "drystone": 1,
  "bodies": [
    {"name": "ground", "kind": "static", "shapes": [{"half_space": {}}]},
    {"name": "foot", "position": [0, 0.3, 0], "shapes": [{"box": {"half_extents": [0.3, 0.3, 0.3]}}]},
    {"name": "arm", "position": [0, 1.1, 0], "shapes": [{"capsule": {"half_height": 0.4, "radius": 0.1}}]},
    {"name": "ball", "position": [1, 2, 0], "shapes": [{"sphere": {"radius": 0.25}}]}
  ],
  "joints": [
    {"hinge": {}, "body_a": "foot", "body_b": "arm", "at": [0, 0.6, 0], "axis": [0, 0, 1]}
  ]
}"""


def arm() -> ds.Scene:
    return ds.Scene.from_string(ARM)


@settings(max_examples=25, deadline=None)
@given(
    n=st.integers(1, 9),
    threads=st.integers(1, 3),
    seed=st.integers(0, 2**32 - 1),
    scene=st.sampled_from(["arm", "arm", "jenga:layers=3"]),
)
def test_world_i_of_a_batch_is_a_single_world_bit_for_bit(
    n: int, threads: int, seed: int, scene: str
) -> None:
    """Forces, new velocities, masks, resets and snapshots at random, the same for both."""
    random = np.random.default_rng(seed)
    source = arm() if scene == "arm" else ds.Scene.load(scene)
    batch = ds.Batch(source, n, threads=threads)
    singles = [ds.World(source) for _ in range(n)]
    bodies = batch.body_count
    movable = singles[0].dynamic
    kept = batch.snapshot(0), singles[0].snapshot()
    for _ in range(5):
        mask = random.random(n) < 0.7
        act = random.integers(5)
        if act == 0:
            forces = random.normal(0, 50, (n, bodies, 3)) * movable[:, None]
            batch.set_forces(forces, mask=mask)
            for i in np.flatnonzero(mask):
                for body, force in zip(singles[i].bodies, forces[i], strict=True):
                    if body.kind == "dynamic":
                        body.set_lasting_force(force)
        elif act == 1:
            speeds = random.normal(0, 1, (n, bodies, 3)) * movable[:, None]
            batch.set_state(linear_velocities=speeds, mask=mask)
            for i in np.flatnonzero(mask):
                singles[i].linear_velocities = speeds[i]
        elif act == 2:
            batch.reset(mask)
            for i in np.flatnonzero(mask):
                singles[i] = ds.World(source)
        elif act == 3:
            one = int(random.integers(n))
            kept = batch.snapshot(one), singles[one].snapshot()
        else:
            one = int(random.integers(n))
            batch.restore(one, kept[0])
            singles[one].restore(kept[1])
        steps = int(random.integers(1, 12))
        batch.step(n=steps, mask=mask)
        for i in np.flatnonzero(mask):
            singles[i].step(n=steps)
        hashes = [world.state_hash() for world in singles]
        assert batch.state_hash().tolist() == hashes
    np.testing.assert_array_equal(batch.positions, [world.positions for world in singles])
    np.testing.assert_array_equal(batch.rotations, [world.rotations for world in singles])
    for name in ("linear_velocities", "angular_velocities"):
        together, single = getattr(batch, name), [getattr(world, name) for world in singles]
        np.testing.assert_array_equal(together, single)


def test_shapes_and_types_are_as_said() -> None:
    batch = ds.Batch(arm(), 5)
    assert len(batch) == 5 and batch.body_count == 4
    assert batch.body_names == ["ground", "foot", "arm", "ball"]
    assert batch.positions.shape == (5, 4, 3) and batch.positions.dtype == np.float32
    assert batch.rotations.shape == (5, 4, 4)
    assert batch.state_hash().dtype == np.uint64 and batch.state_hash().shape == (5,)
    assert batch.alive.all() and not batch.asleep.any()
    batch.step(n=3, mask=[1, 4])
    assert batch.step_count.tolist() == [0, 3, 0, 0, 3]


def test_the_number_of_threads_changes_no_bit() -> None:
    hashes = []
    for threads in (1, 2, 0):
        batch = ds.Batch("tower", 7, threads=threads)
        velocities = np.zeros((7, batch.body_count, 3))
        velocities[:, -1, 0] = np.arange(7)
        batch.linear_velocities = velocities
        batch.step(DT, 40)
        hashes.append(batch.state_hash().tolist())
    assert hashes[0] == hashes[1] == hashes[2]
    assert len(set(hashes[0])) == 7


def test_a_reset_world_is_as_at_the_start_whatever_it_did() -> None:
    batch = ds.Batch("wall:ball=1", 3)
    start = batch.state_hash()
    batch.step(n=50)
    batch.reset([0, 2])
    assert batch.step_count.tolist() == [0, 50, 0]
    np.testing.assert_array_equal(batch.state_hash()[[0, 2]], start[[0, 2]])
    # And it goes on as a new one does.
    fresh = ds.World("wall:ball=1")
    fresh.step(n=50)
    batch.step(n=50, mask=[0])
    assert batch.state_hash()[0] == fresh.state_hash()


def test_worlds_are_copied_within_a_batch_and_taken_out_of_it() -> None:
    batch = ds.Batch(arm(), 6)
    speeds = batch.linear_velocities
    speeds[2, 3] = [1, 2, 3]
    batch.linear_velocities = speeds
    batch.step(n=7)
    batch.copy(2, [0, 5])
    batch.copy(2, 1)
    hashes = batch.state_hash()
    assert hashes[0] == hashes[1] == hashes[2] == hashes[5] != hashes[3]
    alone = batch.world(2)
    batch.step(n=20)
    alone.step(n=20)
    assert alone.state_hash() == batch.state_hash()[5]
    assert alone.body("ball").name == "ball"


def test_snapshots_pass_between_batches_worlds_and_pickles() -> None:
    batch = ds.Batch(arm(), 2)
    batch.step(n=11)
    saved = pickle.loads(pickle.dumps(batch.snapshot(1)))
    world = saved.world()
    other = ds.Batch(arm(), 3, threads=1)
    other.restore(2, saved)
    for one in (batch, other):
        one.step(n=13)
    world.step(n=13)
    assert batch.state_hash()[1] == other.state_hash()[2] == world.state_hash()
    with pytest.raises(ds.DefError) as refused:
        other.restore(0, ds.World("tower").snapshot())
    assert refused.value.field == "snapshot"


def test_bodies_that_break_are_no_longer_alive_and_come_back_with_a_reset() -> None:
    world = ds.World()
    world.add_body("static", shapes=ds.Shape.half_space())
    text = """{"drystone": 1, "bodies": [
      {"name": "ground", "kind": "static", "shapes": [{"half_space": {}}]},
      {"name": "pot", "position": [0, 5, 0], "shapes": [{"box": {"half_extents": [0.3, 0.3, 0.3]}}],
       "fracture": {"impulse": 1}}
    ]}"""
    batch = ds.Batch(ds.Scene.from_string(text), 2)
    batch.step(n=120, mask=[1])
    assert batch.alive.tolist() == [[True, True], [True, False]]
    assert np.isnan(batch.positions[1, 1]).all() and np.isfinite(batch.positions[0]).all()
    assert batch.world(1).body_count > 2
    batch.reset()
    assert batch.alive.all()


def test_bad_arguments_are_refused_and_change_nothing() -> None:
    batch = ds.Batch(arm(), 3)
    before = batch.state_hash().tolist()
    good = batch.positions
    nan = good.copy()
    nan[2, 3, 1] = np.nan
    force = np.zeros((3, 4, 3))
    force[1, 0] = 1
    calls: list[tuple[Callable[[], object], type[Exception]]] = [
        (lambda: ds.Batch(arm(), 0), ds.DefError),
        (lambda: ds.Batch(arm(), -1), ds.DefError),
        (lambda: ds.Batch(arm(), 2**40), ds.DefError),
        (lambda: ds.Batch("no such scene", 1), ds.SceneError),
        (lambda: ds.Batch(3, 1), TypeError),  # type: ignore[arg-type]
        (lambda: batch.step(0), ds.DefError),
        (lambda: batch.step(n=-1), ds.DefError),
        (lambda: batch.step(n=1.5), TypeError),  # type: ignore[arg-type]
        (lambda: batch.step(mask=[True, False]), ds.DefError),
        (lambda: batch.step(mask=[3]), ds.DefError),
        (lambda: batch.step(mask=[-1]), ds.DefError),
        (lambda: batch.step(mask=[0.5]), TypeError),  # type: ignore[list-item]
        (lambda: batch.set_state(nan), ds.DefError),
        (lambda: batch.set_state(good[:2]), ds.DefError),
        (lambda: batch.set_forces(force), ds.DefError),
        (lambda: batch.set_forces(force * np.nan), ds.DefError),
        (lambda: batch.world(3), ds.DefError),
        (lambda: batch.copy(0, [9]), ds.DefError),
        (lambda: pickle.dumps(batch), TypeError),
    ]
    for call, error in calls:
        with pytest.raises(error):
            call()
    assert batch.state_hash().tolist() == before
