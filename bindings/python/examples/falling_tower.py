"""A tower of boxes stands; a ball topples it. It never has more energy than at the throw."""

import drystone as ds
import numpy as np

GRAVITY = 9.81
DT = 1 / 60

world = ds.World(gravity=[0, -GRAVITY, 0], threads=0)
world.add_body("static", name="floor", shapes=ds.Shape.half_space())
box = ds.Shape.box_full([1, 1, 1], density=500)
boxes = [world.add_body(position=[0, 0.5 + k, 0], shapes=box) for k in range(10)]

world.step(DT, 300)
sunk = max(0.5 + k - float(body.position[1]) for k, body in enumerate(boxes))
print(f"after 5 s the tower stands, its top is {1000 * sunk:.2f} mm low")
# Each of ten contacts is compressed by a fraction of a millimeter at most.
assert sunk < 10 * 1e-3

# A ball of 4 t at 15 m/s hits it at half its height.
ball = world.add_body(
    position=[-12, 7, 0], linear_velocity=[15, 0, 0], shapes=ds.Shape.sphere(1, density=1000)
)
start = world.audit()["energy"]["total"]
landings = 0
for _ in range(360):
    world.step(DT)
    landings += len(world.events.hits)
    # Contacts and friction take energy; a step of free fall is exact to 1e-4 of it.
    energy = world.audit()["energy"]["total"]
    assert energy < start * 1.0001, (energy, start)

heights = np.array([float(body.position[1]) for body in boxes])
print(f"{landings} landings; the boxes lie at {np.round(np.sort(heights), 2)}")
assert heights.max() < 9 and heights.min() > 0.4
