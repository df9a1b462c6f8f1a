"""A lidar of 10,000 rays in a field of balls, checked against geometry."""

import time

import drystone as ds
import numpy as np

random = np.random.default_rng(7)
world = ds.World(threads=0)
world.add_body("static", shapes=ds.Shape.half_space())
centers = random.uniform([-20, 0.5, -20], [20, 3, 20], (200, 3)).astype(np.float32)
ball = ds.Shape.sphere(0.5)
for center in centers:
    world.add_body("static", position=center, shapes=ball)

n = 10_000
angles = random.uniform(0, 2 * np.pi, n)
slopes = random.uniform(-0.2, 0.3, n)
ways = 40 * np.stack([np.cos(angles), slopes, np.sin(angles)], axis=1).astype(np.float32)
origins = np.full((n, 3), [0, 1.5, 0], np.float32)

start = time.perf_counter()
hits = world.rays(origins, ways)
print(f"{n} rays in {1000 * (time.perf_counter() - start):.1f} ms, {hits['hit'].sum()} hits")

# Each point that was hit lies on the floor or on a ball, within the roundings of f32 over 50 m.
points = hits["point"][hits["hit"]]
to_balls = np.linalg.norm(points[:, None] - centers, axis=2) - 0.5
distance = np.minimum(np.abs(to_balls).min(axis=1), np.abs(points[:, 1]))
assert distance.max() < 1e-4, distance.max()
# And no ray that hit nothing passes through a ball.
missed = ways[~hits["hit"]]
along = np.clip(
    np.einsum("rk,rbk->rb", missed, (centers - origins[0])[None].repeat(len(missed), 0))
    / (missed**2).sum(axis=1)[:, None],
    0,
    1,
)
nearest = np.linalg.norm(origins[0] + along[..., None] * missed[:, None] - centers, axis=2)
assert nearest.min() > 0.5 - 1e-4
