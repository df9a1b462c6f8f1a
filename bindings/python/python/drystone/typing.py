"""Types of the keywords of drystone, for annotations. Nothing here is needed at run time."""

from collections.abc import Iterable, Sequence
from typing import Literal, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._drystone import Body, Joint, Shape

Floats = NDArray[np.float32]
"""An array of float32."""
Ids = NDArray[np.uint64]
"""Ids of bodies, shapes, joints, particles or links."""
Flags = NDArray[np.bool_]
"""Booleans."""
Records = NDArray[np.void]
"""A structured array: fields by name, as in `records["body"]`."""

BodyLike = Union[Body, int, np.uint64, str]
"""A body, its id, or its name."""
JointLike = Union[Joint, int, np.uint64]
"""A joint, or its id."""
Real = Union[float, np.floating, np.integer]
"""A number."""
Mask = Union[NDArray[np.bool_], NDArray[np.integer], Sequence[bool], Sequence[int]]
"""A boolean for each world, or numbers of worlds."""

BodyKind = Literal["dynamic", "static", "kinematic"]
AxisName = Literal["x", "y", "z", "turn_x", "turn_y", "turn_z"]
JointKind = Literal[
    "ball",
    "hinge",
    "slider",
    "fixed",
    "distance",
    "rope",
    "spring",
    "cone_twist",
    "universal",
    "cylindrical",
    "planar",
    "six_dof",
    "pulley",
    "servo",
    "wheel",
]
Combine = Literal["geometric_mean", "multiply", "maximum", "minimum", "average"]


class FilterOptions(TypedDict, total=False):
    """Which shapes meet which: bits of layers."""

    layers: int
    mask: int
    exclude: int


class SurfaceOptions(FilterOptions, total=False):
    """A surface."""

    friction: Real
    kinetic_friction: Real
    restitution: Real
    rolling_resistance: Real
    spinning_resistance: Real
    friction_combine: Combine
    restitution_combine: Combine


class ShapeOptions(SurfaceOptions, total=False):
    """The keywords of every shape."""

    position: ArrayLike
    rotation: ArrayLike
    density: Real
    sensor: bool
    senses_statics: bool
    senses_sensors: bool
    surface_velocity: ArrayLike
    surface_spin: ArrayLike
    one_way: ArrayLike
    report_touches: bool
    report_hits: bool
    hit_speed: Real
    report_forces: bool
    enabled: bool
    user_data: int


class FractureOptions(TypedDict, total=False):
    """How a body breaks when it is hit."""

    impulse: Real
    energy: Real
    pieces: int
    min_size: Real
    focus: int
    generations: int
    seed: int


class BodyOptions(TypedDict, total=False):
    """The keywords of `World.add_body`."""

    name: str
    shapes: Union[Shape, Iterable[Shape]]
    position: ArrayLike
    rotation: ArrayLike
    linear_velocity: ArrayLike
    angular_velocity: ArrayLike
    mass: Real
    center_of_mass: ArrayLike
    inertia: ArrayLike
    density: Real
    friction: Real
    restitution: Real
    gravity_scale: Real
    linear_damping: Real
    angular_damping: Real
    lock_linear: tuple[bool, bool, bool]
    lock_angular: tuple[bool, bool, bool]
    can_sleep: bool
    sleep_speed: Real
    asleep: bool
    enabled: bool
    glue: Union[Real, tuple[Real, Real]]
    glue_gap: Real
    fracture: FractureOptions
    user_data: int


class SpringOptions(TypedDict, total=False):
    """A spring: `hertz` and `damping_ratio`, alone or for a `load`, or `stiffness` and `damping`."""

    hertz: Real
    damping_ratio: Real
    load: Real
    stiffness: Real
    damping: Real
    rest_length: Real


class AxisOptions(TypedDict, total=False):
    """An axis of a joint."""

    limits: tuple[Real, Real]
    limit_spring: SpringOptions
    motor: tuple[Real, Real]
    servo: Union[tuple[Real, SpringOptions], tuple[Real, SpringOptions, Real]]
    friction: Real


class FatigueOptions(TypedDict, total=False):
    """How a joint wears out."""

    life: Real
    exponent: int
    endurance: Real


JointAxis = Union[AxisOptions, Literal["free", "locked"]]


class JointOptions(AxisOptions, total=False):
    """The keywords of `World.add_joint`; each kind has those that the README lists."""

    at: ArrayLike
    between: tuple[ArrayLike, ArrayLike]
    anchors: tuple[ArrayLike, ArrayLike]
    axis: ArrayLike
    axes: tuple[ArrayLike, ArrayLike]
    rotation: ArrayLike
    collide_connected: bool
    articulated: bool
    enabled: bool
    break_force: Real
    break_torque: Real
    break_impulse: Real
    fatigue: FatigueOptions
    user_data: int
    length: Real
    min: Real
    max: Real
    rest_length: Real
    hertz: Real
    damping_ratio: Real
    spring: SpringOptions
    linear_spring: SpringOptions
    angular_spring: SpringOptions
    swing: Union[Real, tuple[Real, Real]]
    twist: JointAxis
    cone_spring: SpringOptions
    cone: tuple[Real, Real]
    x: JointAxis
    y: JointAxis
    z: JointAxis
    turn: JointAxis
    turn_x: JointAxis
    turn_y: JointAxis
    turn_z: JointAxis
    along: JointAxis
    about: JointAxis
    points: tuple[ArrayLike, ArrayLike]
    ratio: Real
    rigid: bool
    hold_rotation: bool
    drive_force: Real
    drive_torque: Real
    suspension: JointAxis
    spin: JointAxis
    steering: JointAxis


class SurfaceRule(TypedDict, total=False):
    """A rule for the surfaces of two layers, or of two bodies."""

    first: int
    second: int
    friction: Real
    kinetic_friction: Real
    restitution: Real
    hertz: Real
    damping_ratio: Real


class CloudOptions(SurfaceOptions, total=False):
    """The keywords of the particles of ropes and cloths."""

    velocity: ArrayLike
    radius: Real
    gravity_scale: Real
    damping: Real
    mass: Real


class ParticleOptions(CloudOptions, total=False):
    """The keywords of `World.add_particle`."""

    pinned: bool


LinkKind = Union[Literal["equal", "at_most"], SpringOptions]


class RopeOptions(CloudOptions, total=False):
    """The keywords of `World.add_rope`."""

    length: Real
    pinned: tuple[bool, bool]
    kind: LinkKind
    tear_force: Real
    tear_strain: Real


class ClothOptions(CloudOptions, total=False):
    """The keywords of `World.add_cloth`."""

    stretch: LinkKind
    shear: Union[LinkKind, Literal["none"]]
    bend: Union[LinkKind, Literal["none"]]
    tear_force: Real
    tear_strain: Real


class QueryOptions(FilterOptions, total=False):
    """The keywords of all queries."""

    exclude_bodies: Iterable[BodyLike]
    kinds: Union[BodyKind, Iterable[BodyKind]]
    sensors: bool
    inside: Literal["solid", "hollow", "ignore"]


class EnergyReport(TypedDict):
    """Energies [J]."""

    linear: float
    angular: float
    potential: float
    elastic: float
    kinetic: float
    total: float


class MomentumReport(TypedDict):
    """Mass [kg], its center [m], and momenta [kg m/s, kg m²/s], all in the world's frame."""

    mass: float
    center_of_mass: Floats
    linear: Floats
    about_origin: Floats
    about_center: Floats


class PenetrationReport(TypedDict):
    """Overlaps [m]."""

    points: int
    max: float
    p99: float
    mean: float


class JointReport(TypedDict):
    """Largest errors of joints [m, rad]."""

    linear: float
    angular: float


class ResidualReport(TypedDict):
    """Errors that contacts left unsolved."""

    speed: float
    relative: float
    gap: float
    pull: float


class LedgerReport(TypedDict):
    """The energy balance of some steps [J]."""

    steps: int
    start: EnergyReport
    now: EnergyReport
    forces: float
    impulses: float
    changes: float
    kinematic: float
    dissipated: float


class Audit(TypedDict):
    """The result of `World.audit`."""

    step: int
    energy: EnergyReport
    momentum: MomentumReport
    penetration: PenetrationReport
    joints: JointReport
    residual: ResidualReport
    cone_use: Union[float, None]
    non_finite: list[int]
    ledger: Union[LedgerReport, None]
