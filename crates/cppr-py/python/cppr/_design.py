"""What is built, and how it is solved: plain data. All numbers in SI: m, rad, N, N m, Pa.

A value along a tube, from the baseplate (x = 0) to the tip (x = L), is

- a number: the same everywhere,
- two numbers: at base and tip, linear between,
- more numbers: at equal steps from base to tip, interpolated without overshoot,
- a function of x (m): called once at 257 abscissae from 0 to L,
- a `Table` or `PerNotch`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Union

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Table:
    """Values at given abscissae, interpolated without overshoot, constant beyond them."""

    x: Sequence[float] | NDArray[np.float64]
    """Abscissae from base to tip (m), shape (n,)."""
    values: Sequence[float] | NDArray[np.float64]
    """Values there, shape (n,)."""


@dataclass(frozen=True)
class PerNotch:
    """One value per notch: a natural cubic spline through the middles of the tube's notches (eq 1 of the paper)."""

    values: Sequence[float] | NDArray[np.float64]
    """Values from base to tip, shape (count of the tube's `NotchPattern`,)."""


ProfileLike = Union[
    float, Sequence[float], NDArray[np.float64], Callable[[float], float], Table, PerNotch
]
"""A value along a tube; see the head of this module."""


@dataclass(frozen=True)
class Material:
    """Isotropic material."""

    youngs_modulus: float
    """E (Pa)."""
    poissons_ratio: float
    """ν (-)."""
    density: float = 0.0
    """kg/m³; only gravity needs it."""
    allowable_strain: float | None = None
    """Greatest strain to bear (-); only limits need it."""


@dataclass(frozen=True)
class NotchPattern:
    """A row of equal notches from the baseplate on, with half a tooth before the first."""

    length: float
    """Of a notch along the tube (m)."""
    tooth: float
    """Length of the tooth between two notches (m)."""
    count: int
    """Number of notches."""


@dataclass(frozen=True)
class NotchedTube:
    """A tube cut by notches; its stiffness follows from its geometry. Depth 0 is an uncut tube."""

    outer_radius: float
    """m; half the width across flats of a polygon."""
    inner_radius: float
    """m; half the width across flats of a polygon."""
    depth: ProfileLike
    """Notch depth along the tube (m), from the outer surface on the side where the notch opens."""
    opening: ProfileLike
    """Direction the notches open to (rad), from +Y towards +Z. The leader's is usually pi; the centroid lies opposite."""
    material: Material
    """Of the whole tube."""
    notches: NotchPattern | None = None
    """Where the notches are. The mechanics spreads them evenly; limits and `PerNotch` need them one by one."""
    shape: Literal["round", "square", "hexagon"] = "round"
    """Of the uncut section."""
    torsion: Literal["saint-venant", "polar"] | ProfileLike = "saint-venant"
    """Torsional stiffness: of the open section, the paper's polar one, or given along the tube (N m²)."""
    below_plate: Literal["plain", "continued"] = "plain"
    """What of a follower enters the robot when it is pushed: uncut tube, or the pattern continued."""
    centroid_offset_factor: float = 1.0
    """Factor on the centroid offset in the kinematics (Remark 17 of the paper)."""


@dataclass(frozen=True)
class StiffnessTube:
    """A tube whose stiffness is given."""

    centroid_offset: ProfileLike
    """Distance of the centroid from the tube's centre (m)."""
    bending_y: ProfileLike
    """Bending stiffness about the axis along the centroid direction, the stiff one (N m²)."""
    bending_z: ProfileLike
    """Bending stiffness about the axis normal to the centroid direction, the soft one (N m²)."""
    torsion: ProfileLike
    """Torsional stiffness about the tube's centre (N m²)."""
    opening: ProfileLike
    """Direction opposite to the centroid (rad), from +Y towards +Z. The leader's is usually pi."""
    axial: ProfileLike | None = None
    """Axial stiffness (N); only stretch needs it."""
    mass_per_length: ProfileLike = 0.0
    """kg/m; only gravity needs it."""
    centroid_offset_factor: float = 1.0
    """Factor on the centroid offset in the kinematics."""


TubeLike = Union[NotchedTube, StiffnessTube]
"""A tube of either kind."""


@dataclass(frozen=True)
class Settings:
    """How to solve. The defaults serve every robot."""

    planar: bool = False
    """Five modes, nothing leaves the X-Y plane: fast, and blind to lateral instability."""
    stretch: bool = False
    """Let the tubes stretch."""
    refine: float = 1
    """Multiplies modes and nodes (1 to 8), to see whether an answer stays; 0.375, 0.5 or 0.75 for loops that need no more (`Robot.fewest_modes`)."""
    formulation: Literal["consistent", "printed"] = "consistent"
    """Stationary total energy, or the paper's projection of wrenches, for comparison."""
    relative_angle: bool = False
    """`rotate` means the angle between follower and leader at the plate (Figure 22 of the paper), not the motor."""
    tolerance: float = 1e-11
    """Largest scaled residual at convergence (-)."""
    iterations: int = 40
    """Newton iterations of one attempt."""
    smallest_step: float = 1.0 / 256.0
    """Smallest fraction of the command that load stepping tries to add (-)."""
