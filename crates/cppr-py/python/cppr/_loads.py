"""What acts on a robot from outside. N, N m, m; base frame: X along the robot at rest, leader's centroid towards +Y.

The frame of a section has its origin at the tube's centre, X along the tangent, Y towards the leader's centroid there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Union

import numpy as np
from numpy.typing import NDArray

VectorLike = Union[Sequence[float], NDArray[np.float64]]
"""Three numbers."""


@dataclass(frozen=True)
class Wrench:
    """A concentrated force and moment."""

    force: VectorLike = (0.0, 0.0, 0.0)
    """N, shape (3,)."""
    moment: VectorLike = (0.0, 0.0, 0.0)
    """About the point of action (N m), shape (3,)."""
    at: float | None = None
    """Rest abscissa of the leader's section it acts on (m); None is the tip."""
    point: VectorLike = (0.0, 0.0, 0.0)
    """Point of action in the section's frame (m), shape (3,)."""
    frame: Literal["base", "section"] = "base"
    """Frame in which the components stay: "base" is a dead load, "section" turns with the robot."""


@dataclass(frozen=True)
class DistributedForce:
    """A dead force per length of the leader, on the centreline between two abscissae."""

    force: VectorLike
    """N/m, base frame, shape (3,)."""
    start: float
    """First rest abscissa (m)."""
    end: float
    """Last rest abscissa (m)."""


@dataclass(frozen=True)
class Gravity:
    """Gravity on every tube above the plate. The tubes need a density or a mass per length."""

    acceleration: VectorLike = (0.0, 0.0, -9.81)
    """m/s², base frame, shape (3,)."""


@dataclass(frozen=True)
class Thread:
    """A thread from the tip over a pulley, axle parallel to Z, to a hanging weight."""

    tension: float
    """N."""
    pulley: VectorLike
    """Centre of the pulley (m), base frame, shape (3,)."""
    radius: float = 0.0
    """Of the pulley (m); 0 is an eyelet."""
    side: Literal["left", "right"] = "left"
    """Side on which the thread runs onto the pulley, seen from the tip with +Z up."""
    point: VectorLike = (0.0, 0.0, 0.0)
    """Where it is tied, in the tip's frame (m), shape (3,)."""


Load = Union[Wrench, DistributedForce, Gravity, Thread]
"""Any load."""
