"""Robots of parts and joints: plain data in SI, and their figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _cppr
from ._design import TubeLike
from ._plot import STYLES

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Part:
    """One part of a tube. Along it, x runs from 0 at its base to its length."""

    length: float
    """m. A first part of length 0 is what lies below the baseplate alone."""
    body: TubeLike
    """What it is made of; a `NotchedTube` of depth 0 is uncut."""
    rest_curvature: float = 0.0
    """Curvature of the free part's axis (1/m)."""
    rest_direction: float = 0.0
    """Towards which it curves (rad), about the axis from +Y towards +Z."""


@dataclass(frozen=True)
class Shaft:
    """What lies between the motor of a tube and the baseplate."""

    axial: float
    """Axial stiffness (N/m)."""
    torsional: float
    """Torsional stiffness (N m/rad)."""


@dataclass(frozen=True)
class Tube:
    """A tube made of parts."""

    parts: Sequence[Part]
    """From base to tip."""
    shaft: Shaft | None = None
    """None is rigid."""


@dataclass(frozen=True)
class Joint:
    """Tubes bonded to each other."""

    tubes: Sequence[int]
    """Their numbers, from 1."""
    at: Sequence[float] | None = None
    """Label on each tube (m); None is their tips."""


def plot(self: _cppr.BundleEquilibrium, ax: Axes | None = None) -> Axes:
    """Draws the centroid line of every tube as far as it reaches, the joints and the centreline (mm); returns the axes.

    In the X-Y plane, or in space where the robot leaves it. Needs Matplotlib.
    """
    import matplotlib.pyplot as plt

    fields = self.sample(self.length / 200)
    centre, angle = fields["centre"], fields["angle"]
    flat = bool(np.abs(centre[:, 2]).max() < 1e-3 * self.length)
    if ax is None:
        ax = plt.figure(layout="constrained").add_subplot(projection=None if flat else "3d")
    elif not flat and not hasattr(ax, "set_zlim"):
        raise ValueError('a view in space needs axes made with projection="3d"')
    any_ax: Any = ax
    dimensions = 2 if flat else 3
    across, up = fields["frame"][:, :, 1], fields["frame"][:, :, 2]
    # Inner tubes first: the outer ones are drawn over them, and show where they end.
    for tube in reversed(range(angle.shape[1])):
        towards = across * np.cos(angle[:, tube, None]) + up * np.sin(angle[:, tube, None])
        line = (centre + towards * fields["centroid_offset"][:, tube, None]) * 1e3
        color, dashes = STYLES[tube % len(STYLES)]
        any_ax.plot(*line[:, :dimensions].T, color=color, ls=dashes, lw=1.8, label=f"tube {tube + 1}")
    any_ax.plot(*centre[:, :dimensions].T * 1e3, color="0.6", lw=0.8, label="centre")
    places = []
    for joint in self.joints:
        tube, label = next(iter(joint.items()))
        off = np.abs(fields["abscissa"][:, tube - 1] - label)
        if np.isfinite(off).any():
            places.append(centre[np.nanargmin(off), :dimensions] * 1e3)
    if places:
        any_ax.plot(*np.transpose(places), "x", color="#1f5fd0", ms=7, label="joint")
    any_ax.set_xlabel("x (mm)")
    any_ax.set_ylabel("y (mm)")
    any_ax.set_aspect("equal")
    if flat:
        any_ax.grid(color="0.9", lw=0.5)
    else:
        any_ax.set_zlabel("z (mm)")
    any_ax.set_title(f"{self.name}: {'stable' if self.stable else 'unstable'}", fontsize=10)
    any_ax.legend(fontsize=8, frameon=False)
    return ax
