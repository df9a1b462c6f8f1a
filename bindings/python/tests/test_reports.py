"""Events, contacts and queries."""

import math

import drystone as ds
import numpy as np
import pytest
from conftest import DT, G


def test_a_landing_is_reported_once_with_its_speed(floor: ds.World) -> None:
    ball = floor.add_body(position=[0, 2.5, 0], shapes=ds.Shape.sphere(0.5))
    hits, begins = [], 0
    for _ in range(60):
        floor.step(DT)
        events = floor.events
        hits += list(events.hits)
        begins += len(events.contact_begin)
    assert len(hits) == 1 and begins == 1
    assert ball.id in (hits[0]["body_a"], hits[0]["body_b"])
    # It fell 2 m; contact is found within a step.
    assert hits[0]["speed"] == pytest.approx(math.sqrt(2 * G * 2), abs=2 * G * DT)
    np.testing.assert_allclose(hits[0]["point"][[0, 2]], 0, atol=1e-5)


def test_contact_forces_carry_the_weight(floor: ds.World) -> None:
    scale = ds.Shape.box_half([0.5, 0.5, 0.5], report_forces=True)
    box = floor.add_body(position=[0, 0.5, 0], shapes=scale, mass=3, can_sleep=False)
    floor.step(DT, 120)
    events = floor.events
    assert events.contact_force_on(box.id)[1] == pytest.approx(3 * G, rel=1e-3)
    forces = events.contact_forces
    assert len(forces) == 1 and forces["point_count"][0] == len(events.force_points) == 4
    assert events.force_points["impulse"].sum() == pytest.approx(3 * G * DT, rel=1e-3)
    contacts = floor.contacts()
    assert len(contacts) == 4 and contacts.dtype["normal"].shape == (3,)
    np.testing.assert_allclose(np.abs(contacts["normal"][:, 1]), 1, atol=1e-6)


def test_events_stay_when_the_world_goes_on(floor: ds.World) -> None:
    floor.add_body(position=[0, 0.6, 0], shapes=ds.Shape.sphere(0.5))
    while len((events := floor.events).contact_begin) == 0:
        floor.step(DT)
    floor.step(DT, 10)
    assert len(events.contact_begin) == 1 and len(floor.events.contact_begin) == 0


def test_a_sensor_reports_who_comes_and_goes() -> None:
    world = ds.World()
    gate = world.add_body("static", shapes=ds.Shape.box_half([1, 0.5, 1], sensor=True))
    ball = world.add_body(position=[0, 3, 0], shapes=ds.Shape.sphere(0.25))
    entered, left = [], []
    for _ in range(90):
        world.step(DT)
        entered += list(world.events.sensor_enter)
        left += list(world.events.sensor_exit)
    assert [(e["sensor_body"], e["visitor_body"]) for e in entered] == [(gate.id, ball.id)]
    assert [(e["sensor_body"], e["visitor_body"]) for e in left] == [(gate.id, ball.id)]


def test_sleep_and_wake_are_reported(floor: ds.World) -> None:
    box = floor.add_body(position=[0, 0.5, 0], shapes=ds.Shape.box_half([0.5] * 3))
    slept = []
    for _ in range(120):
        floor.step(DT)
        slept += list(floor.events.sleep)
    assert slept == [box.id] and box.asleep
    box.wake()
    floor.step(DT)
    assert list(floor.events.wake) == [box.id]


def test_a_refused_step_length_is_an_error_not_a_fault(floor: ds.World) -> None:
    for dt in (0, -1, float("nan"), float("inf"), 11):
        with pytest.raises(ds.DefError) as refused:
            floor.step(dt)
        assert refused.value.field == "dt"
    assert floor.step_count == 0 and len(floor.events.faults) == 0


def test_a_ray_hits_a_ball_where_geometry_says() -> None:
    world = ds.World()
    ball = world.add_body("static", position=[5, 0, 0], shapes=ds.Shape.sphere(1))
    hit = world.ray([0, 0.6, 0], [10, 0, 0])
    assert hit is not None and hit.body == ball.id
    # At height 0.6 the unit circle is 0.8 from its middle.
    np.testing.assert_allclose(hit.point, [4.2, 0.6, 0], atol=1e-5)
    np.testing.assert_allclose(hit.normal, [-0.8, 0.6, 0], atol=1e-5)
    assert hit.fraction == pytest.approx(0.42, abs=1e-6) and not hit.inside
    assert world.ray([0, 1.1, 0], [10, 0, 0]) is None


@pytest.mark.parametrize("threads", [1, 2])
def test_many_rays_are_the_same_as_one_by_one(threads: int) -> None:
    world = ds.World(threads=threads)
    random = np.random.default_rng(1)
    for place in random.uniform(-5, 5, (40, 3)):
        world.add_body("static", position=place, shapes=ds.Shape.sphere(0.5))
    origins = random.uniform(-8, 8, (300, 3)).astype(np.float32)
    deltas = random.uniform(-20, 20, (300, 3)).astype(np.float32)
    hits = world.rays(origins, deltas)
    assert hits.shape == (300,) and 0 < hits["hit"].sum() < 300
    for origin, delta, row in zip(origins, deltas, hits, strict=True):
        one = world.ray(origin, delta)
        assert row["hit"] == (one is not None)
        if one is None:
            assert row["fraction"] == np.inf and row["body"] == 0 and np.isnan(row["point"]).all()
        else:
            assert (row["body"], row["shape"]) == (one.body, one.shape)
            np.testing.assert_array_equal(row["point"], one.point)
    points = origins[hits["hit"]] + deltas[hits["hit"]] * hits["fraction"][hits["hit"], None]
    np.testing.assert_allclose(points, hits["point"][hits["hit"]], atol=1e-4)


def test_rays_need_pairs() -> None:
    world = ds.World()
    with pytest.raises(ds.DefError):
        world.rays(np.zeros((3, 3)), np.zeros((2, 3)))
    with pytest.raises(ds.DefError):
        world.rays(np.zeros((3, 2)), np.zeros((3, 2)))
    with pytest.raises(ds.DefError):
        world.rays([[0, 0, np.nan]], [[0, 1, 0]])
    assert len(world.rays(np.zeros((0, 3)), np.zeros((0, 3)))) == 0


def test_shape_casts_overlaps_and_the_nearest(floor: ds.World) -> None:
    ball = ds.Shape.sphere(1)
    hit = floor.shape_cast(ball, [0, 3, 0], [0, -4, 0])
    assert hit is not None and hit.fraction == pytest.approx(0.5, abs=1e-5)
    starts = np.array([[0, 3, 0], [0, 9, 0]], float)
    casts = floor.shape_casts(ball, starts, np.array([[0, -4, 0]] * 2, float))
    assert casts["hit"].tolist() == [True, False]
    assert casts["fraction"][0] == hit.fraction
    box = floor.add_body(position=[5, 1, 0], shapes=ds.Shape.box_half([0.5] * 3))
    found = floor.overlap(ball, [4, 1.2, 0])
    assert found["body"].tolist() == [box.id]
    assert floor.overlap_point([5, 1, 0])["body"].tolist() == [box.id]
    near = floor.nearest(ball, [2.5, 2.2, 0], 3)
    # To the floor 2.2 - 1; to the box from (2.5, 2.2) to its edge (4.5, 1.5), less the radius.
    distances = dict(zip(near["body"], near["distance"], strict=True))
    assert distances[box.id] == pytest.approx(math.hypot(2, 0.7) - 1, abs=1e-4)
    assert distances[floor.body("floor").id] == pytest.approx(1.2, abs=1e-4)
    assert list(near["distance"]) == sorted(near["distance"])
    with pytest.raises(ds.DefError):
        floor.overlap(ds.Shape.half_space(), [0, 0, 0])


def test_filters_choose_what_a_query_sees(floor: ds.World) -> None:
    ghost = floor.add_body(
        "static", position=[0, 2, 0], shapes=ds.Shape.sphere(0.5, sensor=True)
    )
    red = floor.add_body("static", position=[0, 4, 0], shapes=ds.Shape.sphere(0.5, layers=2))
    ray = ([0, 9, 0], [0, -20, 0])

    def seen(**options: object) -> int:
        hit = floor.ray(*ray, **options)  # type: ignore[arg-type]
        return 0 if hit is None else hit.body

    ground = floor.body("floor")
    assert seen() == red.id
    assert seen(exclude_bodies=[red]) == ground.id
    assert seen(exclude_bodies=[red.id], sensors=True) == ghost.id
    assert seen(mask=1) == ground.id and seen(mask=2) == red.id
    assert seen(exclude=2) == ground.id
    assert seen(kinds="dynamic") == 0 and seen(kinds=["static", "dynamic"]) == red.id
    with pytest.raises(ds.DefError):
        seen(kinds="animal")
    with pytest.raises(TypeError):
        seen(colour="red")


def test_rules_of_surfaces_and_pairs_act(floor: ds.World) -> None:
    cube = ds.Shape.box_half([0.5] * 3)
    through = floor.add_body(position=[0, 0.5, 0], shapes=cube)
    slides = floor.add_body(position=[5, 0.5, 0], shapes=cube, linear_velocity=[3, 0, 0])
    floor.set_bodies_collide("floor", through, False)
    floor.set_surface_between("floor", slides, {"friction": 0})
    floor.step(DT, 60)
    assert through.position[1] < -3
    assert slides.linear_velocity[0] == pytest.approx(3, rel=1e-3)
    floor.set_surface_between("floor", slides, None)
    floor.set_surface_rules([{"friction": 1.0}])
    floor.step(DT, 60)
    assert slides.linear_velocity[0] == pytest.approx(0, abs=1e-3)
