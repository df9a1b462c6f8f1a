"""Joints: each kind holds what it should, and drives reach their targets."""

import math
from collections.abc import Callable

import drystone as ds
import numpy as np
import pytest
from conftest import DT, G
from drystone.typing import SpringOptions


@pytest.fixture
def hung() -> ds.World:
    """A world with a fixed hook at the origin."""
    world = ds.World()
    world.add_body("static", name="hook")
    return world


def weight(world: ds.World, position: list[float], **options: object) -> ds.Body:
    shape = ds.Shape.sphere(0.1)
    return world.add_body(position=position, shapes=shape, mass=1, can_sleep=False, **options)  # type: ignore[arg-type]


# A joint is a spring of 0.15 / substep time: a weight stretches it by g / (2π f)².
SAG = G / (2 * math.pi * 0.15 / (DT / 8)) ** 2


def test_a_pendulum_swings_with_its_period(hung: ds.World) -> None:
    angle = 0.05
    bob = weight(hung, [math.sin(angle), -math.cos(angle), 0])
    hinge = hung.add_joint("hinge", "hook", bob, at=[0, 0, 0], axis=[0, 0, 1])
    crossings = []
    last = bob.position[0]
    for step in range(600):
        hung.step(DT)
        x = bob.position[0]
        if last > 0 >= x:
            crossings.append((step + float(last / (last - x))) * DT)
        last = x
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    # A small ball: moment 1 + 2/5 r² of a point mass; the amplitude adds angle² / 16.
    expected = 2 * math.pi * math.sqrt((1 + 0.4 * 0.1**2) / G) * (1 + angle**2 / 16)
    # The phase of a symplectic method with substeps h is off by (ω h)² / 24, and by interpolation.
    assert period == pytest.approx(expected, rel=2e-3)
    assert hinge.position() == pytest.approx(math.asin(bob.position[0]) - angle, abs=1e-3)


def test_a_rope_holds_at_its_length_and_is_slack_before(hung: ds.World) -> None:
    bob = weight(hung, [0, -0.5, 0])
    rope = hung.add_joint("rope", "hook", bob, length=1.0)
    hung.step(DT, 6)
    assert rope.force[1] == 0
    hung.step(DT, 600)
    assert rope.length == pytest.approx(1, abs=2 * SAG)
    assert rope.force[1] == pytest.approx(G, rel=1e-2)


def test_a_spring_is_stretched_by_the_weight_on_it(hung: ds.World) -> None:
    bob = weight(hung, [0, -1, 0])
    hung.add_joint("spring", "hook", bob, rest_length=1, hertz=2, damping_ratio=1)
    hung.step(DT, 600)
    assert -bob.position[1] - 1 == pytest.approx(G / (2 * math.pi * 2) ** 2, rel=1e-2)


def test_distance_and_fixed_joints_keep_their_bodies(hung: ds.World) -> None:
    bob = weight(hung, [1, 0, 0])
    rod = hung.add_joint("distance", "hook", bob, length=1)
    arm = weight(hung, [0, 0, 3])
    fixed = hung.add_joint("fixed", "hook", arm, at=[0, 0, 3])
    hung.step(DT, 300)
    # A swing adds up to twice the weight as centripetal force.
    assert rod.length == pytest.approx(1, abs=4 * SAG)
    np.testing.assert_allclose(arm.position, [0, 0, 3], atol=4 * SAG)
    assert fixed.force[1] == pytest.approx(G, rel=1e-2)


def test_a_slider_moves_along_its_axis_alone_and_its_motor_keeps_its_speed(hung: ds.World) -> None:
    bob = weight(hung, [0, 0, 0])
    slider = hung.add_joint(
        "slider", "hook", bob, at=[0, 0, 0], axis=[1, 0, 0], motor=(0.5, 50), limits=(-1, 1)
    )
    hung.step(DT, 60)
    assert slider.speed() == pytest.approx(0.5, rel=1e-3)
    np.testing.assert_allclose(bob.position[1:], 0, atol=4 * SAG)
    hung.step(DT, 240)
    # The motor pushes against the stop, which gives way like a joint under five times the weight.
    assert slider.position() == pytest.approx(1, abs=2 * (50 / G) * SAG)
    slider.set_motor(-0.5, 50)
    hung.step(DT, 60)
    assert slider.speed() == pytest.approx(-0.5, rel=1e-3)


def test_a_servo_reaches_its_angle(hung: ds.World) -> None:
    hung.gravity = [0, 0, 0]
    bar = hung.add_body(shapes=ds.Shape.box_half([1, 0.1, 0.1]), can_sleep=False)
    hinge = hung.add_joint("hinge", "hook", bar, at=[0, 0, 0], axis=[0, 0, 1])
    hinge.set_servo(0.7, {"hertz": 2, "damping_ratio": 1}, 1e6)
    hung.step(DT, 300)
    assert hinge.position() == pytest.approx(0.7, abs=1e-3)
    hinge.clear_drive()
    hinge.set_limits(-0.1, 0.1)
    hung.step(DT, 300)
    # Without friction it swings from stop to stop.
    angle = hinge.position()
    assert angle is not None and abs(angle) < 0.1 + 1e-2


def test_every_kind_can_be_added(hung: ds.World) -> None:
    spring = {"hertz": 3, "damping_ratio": 0.7}
    kinds: dict[str, dict[str, object]] = {
        "ball": {"friction": 0.1},
        "hinge": {"limits": (-1, 1), "limit_spring": spring, "servo": (0.2, spring, 9)},
        "slider": {"friction": 1, "axis": [0, 1, 0]},
        "fixed": {"linear_spring": spring, "angular_spring": {"stiffness": 9, "damping": 1}},
        "distance": {"min": 0.5, "max": 2, "spring": {"rest_length": 1, "hertz": 1}},
        "rope": {"length": 3},
        "spring": {"rest_length": 1, "hertz": 1},
        "cone_twist": {"swing": 0.5, "twist": {"limits": (-1, 1)}, "axis": [0, 1, 0]},
        "universal": {"x": {"limits": (-1, 1)}, "y": "free"},
        "cylindrical": {"along": {"motor": (1, 2)}, "about": "free"},
        "planar": {"y": {"limits": (-1, 1)}, "turn": "locked"},
        "six_dof": {"x": "free", "turn_y": {"limits": (-1, 1)}},
        "pulley": {"points": ([0, 3, 0], [1, 3, 0]), "length": 9, "ratio": 2},
        "servo": {"spring": spring, "drive_force": 99, "hold_rotation": False},
        "wheel": {"suspension": {"servo": (0, spring)}, "steering": {"limits": (-1, 1)}},
    }
    for number, (kind, options) in enumerate(kinds.items()):
        body = weight(hung, [3.0 * number, -1, 0])
        if kind not in ("distance", "rope", "spring", "pulley"):
            options = {"at": [3.0 * number, 0, 0], **options}
        joint = hung.add_joint(kind, "hook", body, **options)  # type: ignore[arg-type]
        assert joint.exists and joint.body_b == body and joint.body_a == hung.body("hook")
    assert len(hung.joints) == len(kinds)
    hung.step(DT, 10)
    assert np.isfinite(hung.positions).all()


def test_a_gear_couples_two_hinges(hung: ds.World) -> None:
    wheels = [
        hung.add_body(position=[x, 0, 0], shapes=ds.Shape.sphere(0.4), can_sleep=False)
        for x in (0, 3)
    ]
    hinges = [
        hung.add_joint("hinge", "hook", wheel, at=[x, 0, 0], axis=[0, 0, 1])
        for wheel, x in zip(wheels, (0, 3), strict=True)
    ]
    hung.add_coupling(hinges[0], hinges[1], 2.0)
    hinges[0].set_motor(1.0, 1e6)
    hung.step(DT, 60)
    a, b = hinges[0].position(), hinges[1].position()
    assert a is not None and b is not None
    assert a == pytest.approx(1, rel=0.02) and b == pytest.approx(2 * a, rel=0.01)


def test_a_weak_joint_breaks_and_says_so(hung: ds.World) -> None:
    for position, limit in [([0, -1, 0], 2 * G), ([3, -1, 0], G / 2)]:
        bob = weight(hung, position)  # type: ignore[arg-type]
        hung.add_joint("distance", "hook", bob, length=1, break_force=limit, anchors=([position[0], 0, 0], [0, 0, 0]))
    weak = hung.joints[1]
    broken = []
    for _ in range(30):
        hung.step(DT)
        broken += list(hung.events.joint_break["joint"])
    assert broken == [weak.id] and not weak.exists
    with pytest.raises(ds.DefError) as gone:
        weak.set_motor(1, 1)
    assert gone.value.kind == "missing"


def test_bad_joints_are_refused_with_the_field(hung: ds.World) -> None:
    bob = weight(hung, [0, -1, 0])
    add = hung.add_joint
    soft: SpringOptions = {"hertz": 1}
    calls: list[tuple[Callable[[], object], str]] = [
        (lambda: add("glue", "hook", bob), "kind"),  # type: ignore[arg-type]
        (lambda: add("rope", "hook", bob), "length"),
        (lambda: add("rope", "hook", bob, length=-1), "max"),
        (lambda: add("ball", bob, bob), "body_b"),
        (lambda: add("hinge", "hook", bob, at=[0, 0]), "at"),
        (lambda: add("hinge", "hook", bob, at=[0, 0, 0], between=([0, 0, 0], [0, 0, 0])), "anchors"),
        (lambda: add("hinge", "hook", bob, motor=(1, 1), servo=(0, soft)), "motor"),
    ]
    for call, field in calls:
        with pytest.raises(ds.DefError) as refused:
            call()
        assert refused.value.field == field, refused.value
    with pytest.raises(TypeError, match="has no option 'lenght'"):
        add("rope", "hook", bob, length=1, lenght=2)  # type: ignore[call-arg]
    assert hung.joints == []
