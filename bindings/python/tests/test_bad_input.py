"""Whatever is passed, the answer is a Python exception and never a crash."""

import contextlib
import math
import pickle
from typing import Any

import drystone as ds
import numpy as np
import pytest
from conftest import DT
from hypothesis import given, settings
from hypothesis import strategies as st

EXPECTED = (ValueError, TypeError, OverflowError)

numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(2**70), 2**70),
    st.sampled_from([0, -1, 1, 1e-30, 1e38, 1e300, math.nan, math.inf, True]),
)
strange = st.one_of(
    st.none(), st.text(max_size=3), st.binary(max_size=3), st.just(object()), st.complex_numbers()
)
values = st.one_of(
    numbers,
    strange,
    st.lists(numbers, max_size=5),
    st.lists(st.lists(numbers, max_size=4), max_size=4),
    st.dictionaries(st.sampled_from(["hertz", "pieces", "limits", "x"]), numbers, max_size=2),
    st.tuples(numbers, st.dictionaries(st.just("hertz"), numbers, max_size=1)),
    st.sampled_from(
        [
            np.zeros((3, 3)),
            np.full((2, 3), np.nan),
            np.zeros((0, 3)),
            np.array(1.0),
            np.zeros(3, complex),
            np.array(["a"]),
            np.array([None]),
            np.zeros((2, 2, 2), np.int8),
            np.array([1, 0, 0], np.float16),
        ]
    ),
)

SHAPES = ["sphere", "capsule", "box_half", "box_full", "cylinder", "cone", "half_space", "hull", "mesh"]
OPTIONS = [
    "position", "rotation", "density", "friction", "restitution", "layers", "sensor", "one_way",
    "hit_speed", "user_data", "friction_combine", "nonsense",
]  # fmt: skip
BODY = [
    "position", "rotation", "linear_velocity", "angular_velocity", "mass", "inertia", "center_of_mass",
    "density", "friction", "shapes", "glue", "glue_gap", "fracture", "lock_linear", "name", "nonsense",
    "gravity_scale", "linear_damping", "sleep_speed",
]  # fmt: skip
KINDS = [
    "ball", "hinge", "slider", "fixed", "distance", "rope", "spring", "cone_twist", "universal",
    "cylindrical", "planar", "six_dof", "pulley", "servo", "wheel", "nonsense",
]  # fmt: skip
JOINT = [
    "at", "between", "anchors", "axis", "axes", "rotation", "limits", "motor", "servo", "friction",
    "length", "min", "max", "rest_length", "hertz", "spring", "swing", "twist", "x", "points",
    "break_force", "fatigue", "suspension", "cone", "nonsense",
]  # fmt: skip
METHODS = [
    "step", "add_body", "add_joint", "add_coupling", "add_particle", "add_rope", "add_cloth",
    "add_cloud", "add_link", "remove_body", "remove_particle", "remove_link", "attach_particle",
    "pin_particle", "push_particle", "ray", "rays", "shape_cast", "shape_casts", "overlap",
    "overlap_point", "nearest", "set_config", "set_surface_rules", "set_surface_between",
    "set_bodies_collide", "restore", "body",
]  # fmt: skip
BODY_METHODS = [
    "apply_impulse", "apply_angular_impulse", "add_step_force", "add_step_torque", "move_to",
    "set_lasting_force", "set_lasting_torque", "set_damping", "velocity_at", "break_at",
]  # fmt: skip
JOINT_METHODS = [
    "position", "speed", "set_motor", "set_servo", "set_limits", "set_lengths", "clear_drive",
    "set_target_rotation",
]  # fmt: skip
SETTERS = {
    "world": ["positions", "rotations", "linear_velocities", "angular_velocities", "gravity",
              "particle_positions", "particle_velocities"],
    "body": ["position", "rotation", "linear_velocity", "angular_velocity", "mass", "kind",
             "gravity_scale", "enabled", "user_data"],
}  # fmt: skip


def world() -> tuple[ds.World, ds.Body, ds.Joint]:
    made = ds.World()
    made.add_body("static", name="floor", shapes=ds.Shape.half_space())
    body = made.add_body(position=[0, 1, 0], shapes=ds.Shape.box_half([0.5] * 3))
    joint = made.add_joint("hinge", "floor", body, at=[0, 1, 0])
    made.add_particle([0, 3, 0])
    return made, body, joint


def attempt(call: Any, *args: Any, **options: Any) -> None:
    with contextlib.suppress(*EXPECTED):
        call(*args, **options)


@settings(max_examples=2000, deadline=None)
@given(st.data())
def test_definitions_of_shapes_and_bodies_never_crash(data: st.DataObject) -> None:
    made, _, _ = world()
    name = data.draw(st.sampled_from(SHAPES))
    args = data.draw(st.lists(values, max_size=3))
    options = data.draw(st.dictionaries(st.sampled_from(OPTIONS), values, max_size=2))
    attempt(getattr(ds.Shape, name), *args, **options)
    options = data.draw(st.dictionaries(st.sampled_from(BODY), values, max_size=3))
    options.setdefault("shapes", ds.Shape.sphere(0.5))
    attempt(made.add_body, **options)
    made.step(DT)
    assert made.positions.shape[1] == 3


@settings(max_examples=2000, deadline=None)
@given(st.data())
def test_joints_never_crash(data: st.DataObject) -> None:
    made, body, joint = world()
    options = data.draw(st.dictionaries(st.sampled_from(JOINT), values, max_size=4))
    attempt(made.add_joint, data.draw(st.sampled_from(KINDS)), "floor", body, **options)
    args = data.draw(st.lists(values, max_size=3))
    attempt(getattr(joint, data.draw(st.sampled_from(JOINT_METHODS))), *args)
    made.step(DT)


@settings(max_examples=4000, deadline=None)
@given(st.data())
def test_methods_of_worlds_and_bodies_never_crash(data: st.DataObject) -> None:
    made, body, joint = world()
    things = st.one_of(values, st.sampled_from([body, joint, ds.Shape.sphere(0.1), "floor", made]))
    args = data.draw(st.lists(things, max_size=4))
    method = data.draw(st.sampled_from(METHODS))
    if method == "step":
        # Years of steps are right, but long.
        args = [arg for arg in args if not isinstance(arg, int)][:1]
    if method in ("add_rope", "add_cloth"):
        # Up to a million links are right, but long.
        args = [arg for arg in args if not (isinstance(arg, int) and 100 < arg)]
    attempt(getattr(made, method), *args)
    args = data.draw(st.lists(things, max_size=2))
    attempt(getattr(body, data.draw(st.sampled_from(BODY_METHODS))), *args)
    of = data.draw(st.sampled_from(["world", "body"]))
    name = data.draw(st.sampled_from(SETTERS[of]))
    attempt(setattr, made if of == "world" else body, name, data.draw(values))
    made.step(DT)
    # Only good values came through: the state is finite. A refused call is a fault of the step too.
    assert np.isfinite(made.positions).all() and len(made.events.faults) <= 3


@settings(max_examples=500, deadline=None)
@given(st.data())
def test_batches_never_crash(data: st.DataObject) -> None:
    batch = ds.Batch("jenga:layers=2", 2, threads=1)
    for name in ("positions", "rotations", "linear_velocities", "angular_velocities"):
        attempt(setattr, batch, name, data.draw(values))
    for name in ("reset", "snapshot", "world", "set_forces", "set_state"):
        attempt(getattr(batch, name), data.draw(values))
    attempt(batch.restore, data.draw(values), data.draw(values))
    attempt(batch.copy, data.draw(values), data.draw(values))
    attempt(batch.step, mask=data.draw(values))
    batch.step(DT)


@settings(max_examples=1500, deadline=None)
@given(st.data())
def test_damaged_bytes_of_a_snapshot_never_crash(data: st.DataObject) -> None:
    good = bytearray(SNAPSHOT)
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(good) - 1))
        good[place] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(good)))
    for damaged in (bytes(good), bytes(good[:cut])):
        try:
            made = ds.Snapshot.from_bytes(damaged).world()
        except ds.SnapshotError:
            continue
        made.step(DT)


SNAPSHOT = ds.World("jenga:layers=2").snapshot().to_bytes()


@settings(max_examples=500, deadline=None)
@given(st.text(max_size=200), st.sampled_from(["{", "<mujoco>", "<robot>", ""]))
def test_texts_of_scenes_never_crash(text: str, start: str) -> None:
    with pytest.raises(ds.SceneError):
        ds.Scene.from_string(start + text)


def test_attributes_of_errors_survive_a_pickle() -> None:
    with pytest.raises(ds.DefError) as refused:
        ds.Shape.sphere(-1)
    again = pickle.loads(pickle.dumps(refused.value))
    assert (again.field, again.value, again.allowed, again.kind) == (
        "radius",
        "-1",
        refused.value.allowed,
        "value",
    )


def test_classes_cannot_be_made_without_a_constructor_or_subclassed() -> None:
    for kind in (ds.Shape, ds.Body, ds.Joint, ds.Events, ds.Hit, ds.Snapshot, ds.Scene):
        with pytest.raises(TypeError):
            kind()
    with pytest.raises(TypeError):
        type("Mine", (ds.World,), {})
    with pytest.raises(AttributeError):
        ds.World().colour = 3  # type: ignore[attr-defined]
