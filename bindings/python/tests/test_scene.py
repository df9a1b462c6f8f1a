"""Scenes: built in, from files and from texts; notes, and errors with places."""

import pickle
from pathlib import Path

import drystone as ds
import numpy as np
import pytest

TEXT = """{
  "drystone": 1,
  "bodies": [
    {"name": "ground", "kind": "static", "shapes": [{"half_space": {}}]},
    {"name": "ball", "position": [0, 4, 0], "shapes": [{"sphere": {"radius": 0.5}}]}
  ]
}"""


def test_built_in_scenes_have_names_and_parameters() -> None:
    assert "tower" in ds.Scene.names()
    scene = ds.Scene.load("wall:ball=1")
    assert scene.name == "wall" and scene.notes == () and scene.dt == pytest.approx(1 / 60)
    assert len(scene.body_names) == ds.World(scene).body_count
    with pytest.raises(ds.SceneError, match="there is no scene 'towr'"):
        ds.Scene.load("towr")
    with pytest.raises(ds.SceneError):
        ds.World("wall:colour=1")


def test_a_text_and_a_file_are_the_same_scene(tmp_path: Path) -> None:
    scene = ds.Scene.from_string(TEXT)
    path = tmp_path / "ball.json"
    path.write_text(TEXT)
    worlds = [ds.World(scene), ds.World(path), ds.World(str(path)), ds.World(ds.Scene.load(path))]
    for world in worlds:
        world.step(n=60)
    assert len({world.state_hash() for world in worlds}) == 1
    assert worlds[0].body("ball").position[1] == worlds[0].positions[1, 1]
    assert scene.body_names == ("ground", "ball")


def test_a_scene_is_written_and_pickled_bit_by_bit(tmp_path: Path) -> None:
    scene = ds.Scene.load("tower")
    scene.save(tmp_path / "tower.json")
    again = [
        ds.Scene.load(tmp_path / "tower.json"),
        ds.Scene.from_string(scene.to_json()),
        pickle.loads(pickle.dumps(scene)),
    ]
    hashes = set()
    for one in [scene, *again]:
        world = ds.World(one)
        world.step(n=30)
        hashes.add(world.state_hash())
    assert len(hashes) == 1


def test_errors_name_the_file_the_line_and_what_is_allowed(tmp_path: Path) -> None:
    path = tmp_path / "bad.json"
    path.write_text(TEXT.replace('"radius": 0.5', '"radius": -1'))
    with pytest.raises(ds.SceneError) as refused:
        ds.Scene.load(path)
    error = refused.value
    assert error.file == str(path) and error.line == 5 and "radius" in error.place
    assert error.problem and error.allowed and isinstance(error, ValueError)
    with pytest.raises(ds.SceneError) as unknown:
        ds.Scene.from_string(TEXT.replace('"position"', '"positoin"'))
    assert unknown.value.line == 5
    for text in ("", "{", "[]", "<robot", "<mujoco/><x/>", "null"):
        with pytest.raises(ds.SceneError):
            ds.Scene.from_string(text)
    for source in ("no/such.json", "thing.stl", tmp_path):
        with pytest.raises(ds.SceneError):
            ds.Scene.load(source)
    with pytest.raises(ds.DefError):
        ds.Scene.load("tower", base="fixed")


MJCF = """<mujoco>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body name="ball" pos="0 0 1"><freejoint/><geom type="sphere" size="0.1"/></body>
  </worldbody>
  {more}
</mujoco>"""


def test_notes_say_what_was_not_read_and_strict_refuses_it() -> None:
    clean = ds.Scene.from_string(MJCF.format(more=""), strict=True)
    assert clean.notes == ()
    sensors = '<sensor><framepos objtype="body" objname="ball"/></sensor>'
    scene = ds.Scene.from_string(MJCF.format(more=sensors))
    assert len(scene.notes) >= 1 and "sensor" in " ".join(scene.notes)
    with pytest.raises(ds.SceneError, match="strict"):
        ds.Scene.from_string(MJCF.format(more=sensors), strict=True)


def test_a_scene_with_a_script_plays_it_and_its_snapshots_too() -> None:
    # Bodies drop one after the other.
    name = next(n for n in ("rain", "convex_pile", "washer") if n in ds.Scene.names())
    world = ds.World(name)
    world.step(n=30)
    saved = pickle.loads(pickle.dumps(world.snapshot()))
    other = saved.world()
    world.step(n=60)
    other.step(n=60)
    assert world.state_hash() == other.state_hash() and world.body_count == other.body_count


def test_settings_of_the_scene_hold_unless_others_are_given() -> None:
    scene = ds.Scene.from_string(MJCF.format(more=""))
    np.testing.assert_allclose(ds.World(scene).gravity, [0, 0, -9.81], atol=1e-6)
    np.testing.assert_allclose(ds.World(scene, gravity=[0, 0, -1]).gravity, [0, 0, -1])
    moon = ds.World(scene, gravity=[0, 0, -1])
    moon.step(n=10)
    later = pickle.loads(pickle.dumps(moon.snapshot())).world()
    np.testing.assert_allclose(later.gravity, [0, 0, -1])
