"""Figures of an equilibrium with Matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from . import _cppr
from ._loads import DistributedForce, Gravity, Thread, Wrench

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Colours and dashes of the program's figures: tubes are told apart in grey as well.
STYLES = (
    ("#0b3c6f", "-"), ("#d9541e", "--"), ("#4bbdae", "-."), ("#8b2f7f", (0, (7, 2))), ("#d0a200", ":"),
    ("#5a5a5a", (0, (4.5, 1.3, 1, 1.3, 1, 1.3))),
)  # fmt: skip
_LOAD = "#222222"
_FRAME = ("#b2182b", "#1b7837", "#2166ac")


class Canvas(Protocol):
    """What arrows can be drawn on."""

    def draw(
        self, tail: Any, arrow: Any, color: str, width: float = 1.2, label: str | None = None
    ) -> None:
        """Draws an arrow from `tail` (m)."""


class _Arrows:
    """Arrows given in m, drawn in mm, in the plane or in space."""

    def __init__(self, ax: Any, flat: bool) -> None:
        self.ax, self.flat = ax, flat
        self.ends: list[NDArray[np.float64]] = []

    def draw(self, tail: Any, arrow: Any, color: str, width: float = 1.2, label: str | None = None) -> None:
        tail, arrow = np.asarray(tail) * 1e3, np.asarray(arrow) * 1e3
        if not np.any(arrow) or (self.flat and np.hypot(*arrow[:2]) < 1e-3 * np.linalg.norm(arrow)):
            return
        self.ends += [tail, tail + arrow]
        if self.flat:
            self.ax.annotate(
                "", xy=(tail + arrow)[:2], xytext=tail[:2],
                arrowprops={"arrowstyle": "-|>", "color": color, "lw": width, "shrinkA": 0, "shrinkB": 0},
            )  # fmt: skip
        else:
            self.ax.quiver(*tail, *arrow, color=color, lw=width, arrow_length_ratio=0.25)
        if label:
            at = tail[:2] if self.flat else tail
            self.ax.text(*at, label + " ", color=color, fontsize=8, ha="right", va="bottom")


def plot(
    self: _cppr.Equilibrium,
    ax: Axes | None = None,
    *,
    view: Literal["auto", "2d", "3d"] = "auto",
    sections: int = 101,
    frames: bool = True,
    loads: bool = True,
) -> Axes:
    """Draws the centroid lines of all tubes (mm) with base and tip frames and loads; returns the axes.

    `view` is "2d" (the X-Y plane), "3d", or chosen by whether the robot leaves the plane. Needs Matplotlib.
    """
    if view not in ("auto", "2d", "3d"):
        raise ValueError(f'view must be "auto", "2d" or "3d", not "{view}"')
    import matplotlib.pyplot as plt

    shape = self.sample(sections)
    length = self.robot.length
    flat = view == "2d" or (view == "auto" and bool(np.abs(shape.centroid[..., 2]).max() < 1e-3 * length))
    if ax is None:
        ax = plt.figure(layout="constrained").add_subplot(projection=None if flat else "3d")
    elif not flat and not hasattr(ax, "set_zlim"):
        raise ValueError('a view in space needs axes made with projection="3d"')
    any_ax: Any = ax
    dimensions = 2 if flat else 3
    for tube in range(shape.centroid.shape[1]):
        color, dashes = STYLES[tube % len(STYLES)]
        name = "tube 1 (leader)" if tube == 0 else f"tube {tube + 1}"
        line = shape.centroid[:, tube, :dimensions].T * 1e3
        any_ax.plot(*line, color=color, ls=dashes, lw=1.8, label=name)
    any_ax.plot(*shape.centre[:, :dimensions].T * 1e3, color="0.6", lw=0.8, label="centre")
    arrows = _Arrows(any_ax, flat)
    if frames:
        for i in (0, -1):
            for axis in range(3):
                arrows.draw(shape.centre[i], 0.1 * length * shape.rotation[i, :, axis], _FRAME[axis])
    if loads:
        draw_loads(self, arrows, length)
    points = np.concatenate([shape.centroid.reshape(-1, 3) * 1e3, *(e[None] for e in arrows.ends)])
    low, high = points.min(axis=0), points.max(axis=0)
    pad = 0.05 * (high - low).max()
    limits = [any_ax.set_xlim, any_ax.set_ylim] + ([] if flat else [any_ax.set_zlim])
    for axis, limit in enumerate(limits):
        limit(low[axis] - pad, high[axis] + pad)
    any_ax.set_xlabel("x (mm)")
    any_ax.set_ylabel("y (mm)")
    if flat:
        any_ax.set_aspect("equal")
        any_ax.grid(color="0.9", lw=0.5)
    else:
        any_ax.set_zlabel("z (mm)")
        any_ax.set_box_aspect(high - low + 2 * pad)
    any_ax.set_title(f"{self.robot.name}: {self.status}", fontsize=10)
    any_ax.legend(fontsize=8, frameon=False)
    return ax


def draw_loads(eq: _cppr.Equilibrium, arrows: Canvas, length: float) -> None:
    """Loads as arrows that end where they act, a fifth of the robot long."""
    span = 0.2 * length

    def pointed(at: Any, vector: Any, label: str) -> None:
        vector = np.asarray(vector)
        size = np.linalg.norm(vector)
        if size > 0:
            arrow = vector / size * span
            arrows.draw(at - arrow, arrow, _LOAD, 1.6, label)

    for load in eq.loads:
        if isinstance(load, Wrench):
            section = eq.sample([length if load.at is None else load.at])
            turn = section.rotation[0]
            at = section.centre[0] + turn @ np.asarray(load.point)
            own = turn if load.frame == "section" else np.eye(3)
            pointed(at, own @ np.asarray(load.force), f"{np.linalg.norm(load.force):.3g} N")
            pointed(at, own @ np.asarray(load.moment), f"{1e3 * np.linalg.norm(load.moment):.3g} N mm")
        elif isinstance(load, DistributedForce):
            places = eq.sample(np.linspace(load.start, load.end, 7)).centre
            for i, at in enumerate(places):
                pointed(at, load.force, f"{np.linalg.norm(load.force):.3g} N/m" if i == 3 else "")
        elif isinstance(load, Gravity):
            middle = eq.sample([0.5 * length]).centre[0]
            pointed(middle, load.acceleration, f"{np.linalg.norm(load.acceleration):.3g} m/s²")
        elif isinstance(load, Thread):
            at = eq.tip_position + eq.tip_rotation @ np.asarray(load.point)
            pull = np.asarray(load.pulley) - at
            if np.any(pull):
                arrows.draw(at, pull / np.linalg.norm(pull) * span, _LOAD, 1.6, f"{load.tension:.3g} N")
