"""An interactive view of an equilibrium: one HTML page without a server, a network or a library."""

from __future__ import annotations

import html
import json
import os
import webbrowser
from importlib.resources import files
from pathlib import Path
from tempfile import mkstemp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _cppr
from ._design import NotchedTube
from ._plot import STYLES, draw_loads

# Sides of a whole tube's section as it is drawn.
_SIDES = 16


class View:
    """A page that turns with the mouse. Notebooks show it; `save` writes it, `open` opens it in a browser."""

    def __init__(self, page: str) -> None:
        self.page = page
        """The whole page as HTML."""

    def _repr_html_(self) -> str:
        source = html.escape(self.page, quote=True)
        return f'<iframe srcdoc="{source}" style="width:100%;height:480px;border:0"></iframe>'

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page."""
        Path(path).write_text(self.page, encoding="utf-8")

    def open(self) -> None:
        """Opens the page in the browser."""
        handle, path = mkstemp(suffix=".html", prefix="cppr-")
        os.close(handle)
        self.save(path)
        webbrowser.open(Path(path).as_uri())


def _rings(design: NotchedTube, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Abscissae of the rings that are drawn (m), and which of them are cut: two at every end of a notch."""
    cut = (x >= 0) | (design.below_plate == "continued")
    pattern = design.notches
    if pattern is None:
        return x, cut
    pitch = pattern.length + pattern.tooth
    middles = np.arange(np.floor(x[0] / pitch), pattern.count) * pitch + 0.5 * pitch
    ends = (middles[:, None] + 0.5 * pattern.length * np.array([-1, -1, 1, 1])).ravel()
    notched = np.tile([False, True, True, False], len(middles))
    if design.below_plate == "plain":
        notched &= ends >= 0
    inside = (ends > x[0]) & (ends < x[-1])
    rings, notched = ends[inside], notched[inside]
    # The ends of the tube are like what is next to them.
    first, last = ([notched[0]], [notched[-1]]) if len(notched) else ([False], [False])
    return np.concatenate([x[:1], rings, x[-1:]]), np.concatenate([first, notched, last])


def _strip(eq: _cppr.Equilibrium, shape: _cppr.Shape, tube: int) -> NDArray[np.float64]:
    """Outer surface of a tube where its notches leave it (m), shape (rings, points, 3).

    A tube given by its stiffness is drawn as a thin rod along its centroid line.
    """
    design = eq.robot.tubes[tube]
    rotation = shape.tube_rotation[:, tube]
    if isinstance(design, NotchedTube):
        own = shape.abscissa[:, tube]
        x, notched = _rings(design, own)

        def between(values: NDArray[np.float64]) -> NDArray[np.float64]:
            flat = values.reshape(len(own), -1).T
            return np.stack([np.interp(x, own, v) for v in flat], axis=-1).reshape(len(x), *values.shape[1:])

        centre, rotation = between(shape.centre), between(rotation)
        rotation = rotation / np.linalg.norm(rotation, axis=1, keepdims=True)
        depth = np.where(notched, eq.robot.fields(np.clip(x, 0.0, eq.robot.length), tube + 1)["depth"], 0.0)
        radius = np.full(len(x), design.outer_radius)
        half = np.where(depth > 0, np.arccos(np.clip((depth - radius) / radius, -1, 1)), np.pi)
    else:
        radius = np.full(len(shape.x), 0.006 * eq.robot.length)
        centre = shape.centroid[:, tube]
        half = np.full(len(radius), np.pi)
    angle = half[:, None] * np.linspace(-1, 1, _SIDES + 1)
    local = np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=-1) * radius[:, None, None]
    surface: NDArray[np.float64] = centre[:, None] + np.einsum("nij,npj->npi", rotation, local)
    return surface


class _Collector:
    """Takes arrows as `_plot` draws them."""

    flat = False

    def __init__(self) -> None:
        self.list: list[dict[str, object]] = []

    def draw(self, tail: Any, arrow: Any, color: str, width: float = 1.2, label: str | None = None) -> None:
        ends = np.stack([tail, np.asarray(tail) + arrow])
        self.list.append({"line": np.round(ends, 6).tolist(), "label": label})


def show(self: _cppr.Equilibrium, sections: int = 61) -> View:
    """A view that turns, zooms (wheel) and shifts (shift) with the mouse; works offline.

    The tubes are drawn as what their notches leave of the outer surface, notch by notch where these are known.
    """
    shape = self.sample(sections)
    arrows = _Collector()
    draw_loads(self, arrows, self.robot.length)
    tubes = range(shape.centroid.shape[1])
    forces = "; ".join(
        f"tube {i + 2}: {p * 1e3:.2f} mm, {t:.3f} N" for i, (p, t) in enumerate(zip(self.pull, self.tension))
    )
    data = {
        "title": f"{self.robot.name}: {self.status}",
        "note": forces,
        "length": self.robot.length,
        "colours": [STYLES[tube % len(STYLES)][0] for tube in tubes],
        "tubes": [np.round(_strip(self, shape, tube), 6).tolist() for tube in tubes],
        "centre": np.round(shape.centre, 6).tolist(),
        "tip": np.round(self.tip_rotation, 6).tolist(),
        "loads": arrows.list,
    }
    template = files("cppr").joinpath("view.html").read_text(encoding="utf-8")
    # A robot's name may hold anything; "<" would end the script.
    text = json.dumps(data).replace("<", "\\u003c")
    return View(template.replace("/*DATA*/null", text))
