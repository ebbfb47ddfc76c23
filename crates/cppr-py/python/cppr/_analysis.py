"""What an equilibrium tells: limits, safe ranges, the path it lies on. Methods of `Equilibrium` and `BundleEquilibrium`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _cppr

Floats = NDArray[np.float64]
PerTubeNumber = Union[float, Mapping[int, float], None]


class SectionLimit(NamedTuple):
    """State of a notch, or of a section of a tube without known notches."""

    tube: int
    """Tube number, 1 is the leader."""
    place: Literal["notch", "section", "uncut"]
    """What is judged; "uncut" is a section of the part from below the plate."""
    number: int | None
    """Of the notch, from 1 at the baseplate."""
    x: float
    """Rest abscissa of its middle on its own tube (m)."""
    label: float
    """Rest abscissa of the leader's section that it faces (m)."""
    curvature_y: float
    """Mean curvature of the cell about the axis along the centroid direction (1/m)."""
    curvature_z: float
    """Mean curvature of the cell about the axis normal to it (1/m)."""
    strain: float
    """Strain of largest magnitude, tension positive (-)."""
    allowable_strain: float | None
    """What the material may bear (-), where the design says so."""
    closure: float | None
    """Part of the notch's length that bending has taken up: 1 where the teeth touch."""
    gap: float | None
    """What is left between the teeth where they are nearest (m)."""
    shear: float = 0.0
    """Greatest shear strain by torsion, of the sign of the twist (-)."""
    allowable_shear: float | None = None
    """What of it the material may bear (-)."""

    @property
    def where(self) -> str:
        """The place in words."""
        name = f"notch {self.number}" if self.place == "notch" else self.place
        return f"tube {self.tube} {name} (x = {1e3 * self.x:.1f} mm)"


class Governing(NamedTuple):
    """The nearest limit."""

    limit: Literal["strain", "closure", "torsion", "stability"]
    """Which."""
    utilisation: float
    """0 where nothing of it is used, 1 where it is reached."""
    section: SectionLimit | None
    """Where; None for the stability of the whole."""


class Limits(NamedTuple):
    """How near an equilibrium is to its limits."""

    sections: tuple[SectionLimit, ...]
    """Every notch that stands in the robot, tube by tube; tubes given by their stiffness have none."""
    governing: Governing | None
    """The nearest limit, stability included."""

    def __repr__(self) -> str:
        """The nearest limit and the worst of each tube; `sections` has all."""
        near = self.governing
        told = "no limit is known" if near is None else f"{near.utilisation:.1%} of the nearest limit used: {near.limit}"
        place = "" if near is None or near.section is None else f", {near.section.where}"
        lines = [f"Limits: {told}{place}"]
        for tube in sorted({section.tube for section in self.sections}):
            own = [section for section in self.sections if section.tube == tube]
            worst = max(own, key=lambda section: abs(section.strain))
            allowed = "" if worst.allowable_strain is None else f" of {worst.allowable_strain:.2%} allowed"
            line = f"  tube {tube}: {len(own)} places, strain {worst.strain:+.2%}{allowed} at {worst.where}"
            closed = max((s for s in own if s.closure is not None), key=lambda s: s.closure or 0.0, default=None)
            if closed is not None:
                line += f"; closure {closed.closure:.1%} at {closed.where}"
            lines.append(line)
        return "\n".join(lines)


class RangeEnd(NamedTuple):
    """One end of a safe range."""

    value: float
    """Last safe value (m, rad, N or N m)."""
    bound: Literal["limit", "branch", "open"]
    """A limit, the end of the branch of equilibria, or nothing as far as the search went."""
    limit: Governing | None
    """The limit that is reached."""


class SafeRange(NamedTuple):
    """Values that one input may take while everything else stays."""

    means: Literal["pull", "rotate", "tension", "torque"]
    """Which input."""
    tube: int
    """Of which tube."""
    start: float
    """Its value in the equilibrium's command."""
    low: RangeEnd
    """Towards lesser values."""
    high: RangeEnd
    """Towards greater values."""


@dataclass(frozen=True)
class Branch:
    """A curve of n equilibria, in order along the curve."""

    parameter: Floats
    """Fraction of the way, or the load factor (-); shape (n,)."""
    fraction: Floats
    """0 at the first command, 1 at the last; it turns back at folds; shape (n,)."""
    kind: tuple[Literal["regular", "fold", "branch point", "edge"], ...]
    """What is special about each point; an edge is where the pattern of a follower passes the plate or a load."""
    tip_position: Floats
    """m, base frame; shape (n, 3)."""
    stable: NDArray[np.bool_]
    """False where the robot would leave the equilibrium; shape (n,)."""
    margin: Floats
    """Margin to instability; shape (n,)."""
    equilibria: tuple[_cppr.Equilibrium, ...] | tuple[_cppr.BundleEquilibrium, ...]
    """The equilibria themselves."""
    reached: bool
    """True where the branch ends at the last command."""
    end: str
    """Why it ends, as a sentence."""
    origin: tuple[int, int, int, bool] | None
    """Where it left another: index of that branch, of the point on it, of the critical direction, and whether along it."""

    def __repr__(self) -> str:
        folds, crossings = self.kind.count("fold"), self.kind.count("branch point")
        return f"Branch({len(self.fraction)} points, {folds} folds, {crossings} branch points; {self.end})"


def _governing(found: tuple[str, float, tuple[object, ...] | None] | None) -> Governing | None:
    if found is None:
        return None
    limit, utilisation, section = found
    return Governing(limit, utilisation, section and SectionLimit(*section))  # type: ignore[arg-type]


def limits(self: _cppr.Equilibrium | _cppr.BundleEquilibrium, teeth: Literal["rigid", "bending"] = "rigid") -> Limits:
    """Strain and closure of every notch, and the nearest limit.

    `teeth` are "rigid" (the notches take all bending: safe) or "bending" (as the notches do: the least there can be).
    """
    sections, nearest = _cppr.limits(self, teeth)
    return Limits(tuple(SectionLimit(*s) for s in sections), _governing(nearest))


def safe_ranges(self: _cppr.Equilibrium | _cppr.BundleEquilibrium, teeth: Literal["rigid", "bending"] = "rigid") -> tuple[SafeRange, ...]:
    """How far each actuator may go from here while the others and the loads stay: to a limit of a notch or to instability.

    Raises `CommandError` where a limit is exceeded already.
    """

    def end(value: float, bound: str, limit: tuple[str, float, tuple[object, ...] | None] | None) -> RangeEnd:
        return RangeEnd(value, bound, _governing(limit))  # type: ignore[arg-type]

    return tuple(
        SafeRange(means, tube, start, end(*low), end(*high))
        for means, tube, start, low, high in _cppr.ranges(self, teeth)
    )


def safe_part(self: _cppr.Equilibrium | _cppr.BundleEquilibrium, teeth: Literal["rigid", "bending"] = "rigid") -> RangeEnd:
    """How much of the equilibrium's command, applied from rest in proportion, keeps all limits: `value` from 0 to 1 (all)."""
    value, bound, limit = _cppr.part(self, teeth)
    return RangeEnd(value, bound, _governing(limit))


def continue_path(
    self: _cppr.Equilibrium | _cppr.BundleEquilibrium,
    pull: PerTubeNumber = None,
    rotate: PerTubeNumber = None,
    tension: PerTubeNumber = None,
    torque: PerTubeNumber = None,
    *,
    load_factor: float | None = None,
    step: float = 0.05,
    points: int = 2000,
    depth: int = 0,
) -> tuple[Branch, ...]:
    """All equilibria from here to other actuator values, past folds; or to `load_factor` times the present loads.

    Pseudo-arclength continuation: where the robot would snap, the path turns back and goes on through the unstable
    equilibria. `step` is the longest step along the path (a twentieth of the way, or some 3 degrees of bending), `points` the
    most points of a branch, `depth` how many times a branch is left for another at branch points.
    """
    found = _cppr.trace(self, (pull, rotate, tension, torque), load_factor, step, points, depth)
    return tuple(Branch(**{**branch, "stable": np.array(branch["stable"], dtype=bool)}) for branch in found)
