"""Inverse problems from an equilibrium on: its loads and drives stay, actuators move within their safe ranges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _cppr
from ._analysis import PerTubeNumber
from ._loads import VectorLike
from ._many import numbers

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Reach:
    """Actuators for a wanted tip; m inputs."""

    reached: bool
    """Did the tip get there? Otherwise this is the nearest pose found."""
    inputs: tuple[tuple[str, int], ...]
    """What the values are: ("pull", 2), ("rotate", 2), ..."""
    values: Floats
    """m, rad, N or N m; shape (m,)."""
    at_bound: NDArray[np.bool_]
    """Is the value at the end of its range? Shape (m,)."""
    equilibrium: _cppr.Equilibrium | _cppr.BundleEquilibrium
    """The equilibrium there."""
    distance: float | None
    """From the wanted position (m)."""
    angle: float | None
    """From the wanted direction (rad)."""
    depends_on_path: bool
    """True where the same values applied from rest lead to another pose."""
    limit_used: float
    """How much of the nearest limit this pose uses: 1 where a notch is strained to its limit or closed, or the robot snaps; NaN without limits."""
    condition: float
    """Greatest over least deviation of the tip along its principal axes (-)."""
    manipulability: float
    """Volume of the tip's uncertainty (m³); 0 where a direction cannot be reached."""


@dataclass(frozen=True)
class ShapeMatch:
    """Actuators for a measured or wanted shape; m inputs, n points."""

    inputs: tuple[tuple[str, int], ...]
    """What the values are: ("pull", 2), ("rotate", 2), ..."""
    values: Floats
    """m, rad, N or N m; shape (m,)."""
    deviations: Floats
    """Standard deviations of the values; infinite where the points do not tell; shape (m,)."""
    covariance: Floats
    """Of the values; shape (m, m)."""
    misfit: float
    """Root mean square of the weighted residuals per degree of freedom: about 1 where the deviations are right."""
    at_bound: NDArray[np.bool_]
    """Is the value at the end of its range? Shape (m,)."""
    equilibrium: _cppr.Equilibrium | _cppr.BundleEquilibrium
    """The equilibrium there."""
    distances: Floats
    """Of every point from its place on the centreline (m); shape (n,)."""
    rms: float
    """Root mean square of the distances (m)."""


@dataclass(frozen=True)
class Sensed:
    """The tip wrench that explains measurements best; u = 3 unknowns, or 6 with the moment."""

    force: Floats
    """N, base frame; shape (3,)."""
    moment: Floats
    """N m, base frame; zero where only a force was looked for; shape (3,)."""
    deviations: Floats
    """Standard deviations of the components; infinite where the measurements do not tell; shape (u,)."""
    covariance: Floats
    """Of the components; shape (u, u)."""
    misfit: float
    """Root mean square of the weighted residuals per degree of freedom: about 1 where the deviations are right."""
    misses: Floats
    """How many deviations each measurement (tensions, torques, position, direction) lies from the answer: where many, no wrench explains it."""
    equilibrium: _cppr.Equilibrium | _cppr.BundleEquilibrium
    """The equilibrium under the wrench."""
    loading: Sensed | None = None
    """Where tubes rub: what the measurements say if the motors were driven on to where they are. None without friction, and where no force was found
    that explains them so."""
    unloading: Sensed | None = None
    """The same if the motors were driven back."""


def reach(
    self: _cppr.Equilibrium | _cppr.BundleEquilibrium,
    position: VectorLike | None = None,
    direction: VectorLike | None = None,
    *,
    near: bool = False,
) -> Reach:
    """Actuators that bring the tip to a position (m), a direction of its axis, or both, base frame.

    The whole of the safe ranges is searched. With `near` the search starts at this equilibrium and stays on its branch: for a
    controller that knows where it is. Then actuators may move by half a turn of bend or rotation, beyond limits too: look at `limit_used`.

    Raises `CommandError` where nothing can be searched for; out of reach is no error, see `Reach.reached`.
    """
    found = _cppr.reach(self, position, direction, near)
    return Reach(**{**found, "at_bound": np.array(found["at_bound"], dtype=bool)})


def match_shape(
    self: _cppr.Equilibrium | _cppr.BundleEquilibrium,
    points: ArrayLike,
    x: ArrayLike | None = None,
    *,
    deviation: float = 1e-3,
) -> ShapeMatch:
    """Actuators for which the centreline is nearest to points (m), shape (n, 3), base frame.

    `x` are the rest abscissae of the points (m), shape (n,), where they are known; otherwise the nearest place counts.
    `deviation` is the standard deviation of each coordinate (m).
    """
    places = numbers("points", points)
    if places.ndim != 2 or places.shape[1] != 3:
        raise ValueError(f"points has shape {places.shape}; it must be (n, 3)")
    labels = np.full(len(places), np.nan) if x is None else numbers("x", x)
    if labels.shape != (len(places),):
        raise ValueError(f"x has shape {labels.shape} for {len(places)} points; it must be ({len(places)},)")
    found = _cppr.match_shape(self, np.column_stack([places, labels]).tolist(), deviation)
    return ShapeMatch(**{**found, "at_bound": np.array(found["at_bound"], dtype=bool)})


def sense(
    self: _cppr.Equilibrium | _cppr.BundleEquilibrium,
    tension: PerTubeNumber = None,
    torque: PerTubeNumber = None,
    position: VectorLike | None = None,
    direction: VectorLike | None = None,
    *,
    tension_deviation: float = 0.05,
    torque_deviation: float = 1e-3,
    position_deviation: float = 1e-3,
    direction_deviation: float = 0.02,
    moment: bool = False,
    friction: float | None = None,
    guide: float | None = None,
) -> Sensed:
    """The force on the tip, with `moment` the whole wrench, that explains what was measured while the motors stand as here.

    It comes on top of this equilibrium's loads, and is looked for from here on: an observer that solves its model under the force it knows of
    gets what is lacking. `tension` (N) and `torque` (N m) are measured efforts of followers moved by motion: a number for tube 2, a dict for others;
    `position` (m) and `direction` the measured tip, base frame. Their standard deviations weigh them.

    With `friction`, the coefficient between the tubes (that of the robot, if any; 0 leaves it out), `loading` and `unloading` are what the same measurements say if every tube slips, after motors that
    were driven on and back; `guide` (m) is where tubes are held below the plate. All of these, and the answer without friction beside them, are then of the robot
    integrated along its length: their equilibria are those of a `Bundle`. A friction that is not given is taken for a force.
    """
    deviations = (tension_deviation, torque_deviation, position_deviation, direction_deviation)
    found = _cppr.sense(
        self, (tension, torque), position, direction, deviations, moment, (friction, guide)
    )
    sides = {side: Sensed(**found.pop(side)) for side in ("loading", "unloading") if found.get(side)}
    return Sensed(**{**found, **sides})
