"""drystone: a deterministic rigid-body physics engine.

The same bits on every machine, at any number of worlds and threads, and from any snapshot.
Units are SI; rotations are quaternions [w, x, y, z]; arrays are float32 with a row for each body.
"""

from ._drystone import (
    Batch,
    Body,
    DefError,
    Events,
    Hit,
    Joint,
    Scene,
    SceneError,
    Shape,
    Snapshot,
    SnapshotError,
    Strand,
    World,
    __version__,
)

__all__ = [
    "Batch",
    "Body",
    "DefError",
    "Events",
    "Hit",
    "Joint",
    "Scene",
    "SceneError",
    "Shape",
    "Snapshot",
    "SnapshotError",
    "Strand",
    "World",
    "__version__",
]
