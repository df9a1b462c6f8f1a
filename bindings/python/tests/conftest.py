"""What the tests share: gravity, a step, and worlds with a floor."""

import drystone as ds
import pytest

G = 9.81
DT = 1.0 / 60.0


@pytest.fixture
def floor() -> ds.World:
    """A world with a floor at y = 0."""
    world = ds.World()
    world.add_body("static", name="floor", shapes=ds.Shape.half_space())
    return world
