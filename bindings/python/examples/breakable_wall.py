"""A wall of glued bricks: a slow ball bounces off, a fast one breaks through."""

import drystone as ds

DT = 1 / 60


def throw(speed: float) -> tuple[int, int, float]:
    """Throws a ball at a wall: broken bonds, pieces, and how fast the ball is in the end [m/s]."""
    world = ds.World()
    world.add_body("static", shapes=ds.Shape.half_space())
    bricks = [
        ds.Shape.box_half([0.25, 0.125, 0.125], position=[0.5 * x, 0.125 + 0.25 * y, 0], density=2000)
        for y in range(8)
        for x in range(-4, 5)
    ]
    wall = world.add_body(name="wall", shapes=bricks, glue=1e6)
    mass = wall.mass
    ball = world.add_body(
        position=[0, 1, -0.6], linear_velocity=[0, 0, speed], shapes=ds.Shape.sphere(0.25), mass=100
    )
    broken, pieces = 0, [wall]
    for _ in range(90):
        world.step(DT)
        events = world.events
        broken += len(events.bond_break)
        pieces += [world.body(piece) for piece in events.pieces]
    # Whatever breaks, nothing is lost.
    assert abs(sum(piece.mass for piece in pieces) - mass) < 1e-3 * mass
    return broken, len(pieces), float(ball.linear_velocity[2])


slow, fast = throw(1.0), throw(40.0)
print(f"at  1 m/s: {slow[0]} bonds break, {slow[1]} piece(s), the ball ends at {slow[2]:+.1f} m/s")
print(f"at 40 m/s: {fast[0]} bonds break, {fast[1]} piece(s), the ball ends at {fast[2]:+.1f} m/s")
# The impulse of the slow ball is some 100 N s in a step: 6 kN. Over a face of 0.03 m² that is far
# below 1 MPa of strength. The fast one brings forty times as much.
assert slow[:2] == (0, 1) and slow[2] < 0.5
assert fast[0] > 10 and fast[1] > 3
