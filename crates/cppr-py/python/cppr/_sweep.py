"""Sweeps of a robot file into a table."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Union

from . import _cppr
from ._design import Settings
from ._loads import Load
from ._many import Progress, cores, watcher


@dataclass(frozen=True)
class Range:
    """Equally spaced values, both ends included; sampled uniformly between them where a sweep takes samples."""

    start: float
    """First value."""
    stop: float
    """Last value."""
    count: int = 0
    """How many values; 0 where they are sampled."""


@dataclass(frozen=True)
class Normal:
    """Normally distributed values, for sweeps that take samples."""

    mean: float
    """Mean."""
    deviation: float
    """Standard deviation."""


Spread = Union[float, Range, Normal]
"""A fixed number or what varies."""
PerTubeSpread = Union[Spread, Mapping[int, Spread], None]


def sweep(
    robot: str | os.PathLike[str],
    output: str | os.PathLike[str],
    pull: PerTubeSpread = None,
    rotate: PerTubeSpread = None,
    tension: PerTubeSpread = None,
    torque: PerTubeSpread = None,
    *,
    tip_force: Sequence[Spread] | None = None,
    tip_moment: Sequence[Spread] | None = None,
    vary: Mapping[str, Range | Normal] | None = None,
    loads: Iterable[Load] | None = None,
    settings: Settings | None = None,
    accuracy: float | None = 1e-4,
    samples: int | None = None,
    seed: int = 0,
    margin: bool = False,
    limits: Literal["rigid", "bending"] | None = None,
    friction: float | None = None,
    guide: float | None = None,
    resume: bool = False,
    threads: int | None = None,
    progress: Progress = False,
) -> dict[str, int]:
    """Solves a grid of poses, or quasi-random samples, of a robot file into a table; the number of rows by status.

    A number is fixed, a `Range` or `Normal` varies. `vary` holds numbers of the robot file by their keys, in their own
    units: ``{"tube2.notches.depth_mm": Range(1.9, 2.1, 5)}``. With `samples` that many points are taken instead of the grid.
    Twice or four times as many modes are taken where eight rows, from the first to the last, need them for tips within `accuracy` times the
    length, or an `AccuracyWarning` is given; None leaves the modes as they are. A robot with sudden changes along it, which no modes follow, is integrated
    instead and an `AccuracyWarning` says so, unless `settings` or `margin` need modes. `margin` and `limits` (what the teeth do) add columns. `friction`, the
    coefficient between the tubes (that of the robot file, if any; 0 leaves it out), adds tip and actuators with motors driven on (``loading_``) and driven back (``unloading_``), `guide` (m) the friction where tubes are held
    below the plate. `output` ends in .csv, .npz or .parquet; columns carry their units.
    Nothing that was solved is lost: after Ctrl-C or a crash the same call with `resume=True` goes on.

    Raises `RobotError`, `CommandError` for a sweep that cannot be, `OSError` where an unfinished sweep is in the way.
    """
    axes: list[tuple[str, int, str, str, float, float, int]] = []
    fixed: dict[str, dict[int, float]] = {}

    def take(what: str, index: int, key: str, spread: Spread) -> float:
        """Notes what varies; the value of what does not."""
        if isinstance(spread, Normal):
            axes.append((what, index, key, "normal", spread.mean, spread.deviation, 0))
        elif isinstance(spread, Range):
            if (spread.count == 0) != (samples is not None):
                raise ValueError(f"{what}: a Range has a count in a grid, and none where samples are taken")
            axes.append((what, index, key, "range", spread.start, spread.stop, spread.count))
        else:
            return spread
        return 0.0

    for key, varied in (vary or {}).items():
        if not isinstance(varied, (Range, Normal)):
            raise TypeError(f"vary: {key} must be a Range or a Normal, not {type(varied).__name__}")
        take("vary", 0, key, varied)
    tip = []
    for what, vector in (("tip_force", tip_force), ("tip_moment", tip_moment)):
        parts = (0.0, 0.0, 0.0) if vector is None else vector
        if len(parts) != 3:
            raise ValueError(f"{what} has {len(parts)} components; give three")
        tip.append([take(what, i, "", part) for i, part in enumerate(parts)])
    drives = {"pull": pull, "tension": tension, "rotate": rotate, "torque": torque}
    for what, given in drives.items():
        if given is None:
            continue
        for tube, spread in (given if isinstance(given, Mapping) else {2: given}).items():
            before = len(axes)
            value = take(what, tube, "", spread)
            if len(axes) == before:
                fixed.setdefault(what, {})[tube] = value
    callback, close = watcher(progress)
    try:
        return _cppr.sweep(
            robot, output, axes, tuple(fixed.get(k) for k in ("pull", "rotate", "tension", "torque")),
            None if tip_force is None and tip_moment is None else (tip[0], tip[1]),
            None if loads is None else list(loads), settings, accuracy, samples, seed, margin, limits,
            (friction, guide), resume,
            cores() if threads is None else threads, callback,
        )  # fmt: skip
    finally:
        close()
