"""Many poses in one call, as arrays."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _cppr
from ._design import Settings
from ._errors import AccuracyWarning
from ._loads import Load

Floats = NDArray[np.float64]
PerTube = Union[ArrayLike, Mapping[int, ArrayLike], None]
"""An array for tube 2, or a dict from tube number to array."""

_MEANS = ("pull", "rotate", "tension", "torque")
_STATUS = np.array(["converged", "unstable", "not converged", "not converged"])


class _Coded:
    """What is told of poses by their code."""

    code: NDArray[np.uint8]

    @property
    def status(self) -> NDArray[np.str_]:
        """The codes in words; shape P."""
        words: NDArray[np.str_] = _STATUS[self.code]
        return words

    @property
    def stable(self) -> NDArray[np.bool_]:
        """True where there is a stable equilibrium; shape P."""
        return np.asarray(self.code == 0)

    def __len__(self) -> int:
        return len(self.code)

    def __repr__(self) -> str:
        converged, unstable, *none = np.bincount(self.code.ravel(), minlength=4)
        counts = (converged, unstable, sum(none))
        words = ", ".join(f"{n} {w}" for n, w in zip(counts, _STATUS) if n)
        return f"{type(self).__name__}({self.code.shape}: {words or 'none'})"


@dataclass(frozen=True, repr=False)
class Solutions(_Coded):
    """Equilibria of many poses. P stands for the shape of the poses, F for the number of followers.

    Where no equilibrium was found, every number is NaN.
    """

    code: NDArray[np.uint8]
    """0 converged and stable, 1 an unstable equilibrium, 2 and 3 none found: load stepping ended, or no consistent entry
    of the uncut part below the plate; shape P."""
    iterations: Floats
    """Newton steps; shape P."""
    elastic_energy: Floats
    """J; shape P."""
    tip_position: Floats
    """Centre of the tip section (m), base frame; shape (*P, 3)."""
    tip_rotation: Floats
    """Columns: tangent, direction of the leader's centroid, normal to both; shape (*P, 3, 3)."""
    pull: Floats
    """Translation of the followers below the plate (m); shape (*P, F)."""
    rotation: Floats
    """Rotation of their bases (rad); shape (*P, F)."""
    tension: Floats
    """Pulling force (N); shape (*P, F)."""
    torque: Floats
    """N m; shape (*P, F)."""
    jacobian: Floats | None = None
    """Tip twist (m, rad), base frame, by the inputs: translation and rotation of tube 2, then of tube 3, ...; shape (*P, 6, 2 F)."""
    compliance: Floats | None = None
    """Tip twist by a dead tip wrench (N, N m), base frame; shape (*P, 6, 6)."""
    margin: Floats | None = None
    """Margin to instability: 1 at rest, 0 where it snaps; shape P."""
    centreline: Floats | None = None
    """Centreline from baseplate to tip (m); shape (*P, sections, 3)."""
    error: float = math.nan
    """Greatest discretisation error of the tip (m) among the poses that were looked at; NaN where none was or it is not known."""


@dataclass(frozen=True, repr=False)
class BundleSolutions(_Coded):
    """Equilibria of many poses of a robot of parts and joints. P stands for the shape of the poses, n for the number of tubes.

    Where no equilibrium was found, every number is NaN.
    """

    code: NDArray[np.uint8]
    """0 converged and stable, 1 an unstable equilibrium, 2 none found; shape P."""
    iterations: Floats
    """Newton steps; shape P."""
    tip_error: Floats
    """How far the tip moves when every step of the integration is halved (m), of poses that were found from rest; NaN elsewhere, where it is
    below 1e-5 of the length; shape P."""
    tip_position: Floats
    """Centre of the last tip (m), base frame; shape (*P, 3)."""
    tip_rotation: Floats
    """Columns: tangent, direction of the centroid, normal to both; shape (*P, 3, 3)."""
    pull: Floats
    """Label of every tube at the baseplate (m); shape (*P, n)."""
    rotation: Floats
    """Rotation of every tube at the baseplate (rad); shape (*P, n)."""
    tension: Floats
    """Force with which every motor pulls (N); shape (*P, n)."""
    torque: Floats
    """Torque of every motor (N m); shape (*P, n)."""
    jacobian: Floats | None = None
    """Tip twist (m, rad), base frame, by the motors: translation and rotation of tube 1, then of tube 2, ...; shape (*P, 6, 2 n)."""


class Poses:
    """Broadcast inputs of many poses; slices of the flattened poses are made as they are needed."""

    def __init__(
        self,
        drives: Mapping[str, PerTube],
        tip_force: ArrayLike | None,
        tip_moment: ArrayLike | None,
    ) -> None:
        columns: list[tuple[int, int, Floats]] = []
        for means, name in enumerate(_MEANS):
            given = drives[name]
            if given is None:
                continue
            for tube, values in (given if isinstance(given, Mapping) else {2: given}).items():
                columns.append((means, tube, numbers(f"{name} of tube {tube}", values)))
        vectors = [
            None if v is None else _vectors(name, v)
            for name, v in (("tip_force", tip_force), ("tip_moment", tip_moment))
        ]
        shapes = [a.shape for _, _, a in columns] + [v.shape[:-1] for v in vectors if v is not None]
        try:
            self.shape = np.broadcast_shapes(*shapes)
        except ValueError:
            listed = ", ".join(str(s) for s in shapes)
            raise ValueError(f"the shapes {listed} of the poses do not broadcast together") from None
        self.columns = [(m, t, np.broadcast_to(a, self.shape)) for m, t, a in columns]
        self.vectors = [
            None if v is None else np.broadcast_to(v, (*self.shape, 3)) for v in vectors
        ]
        self.count = int(np.prod(self.shape, dtype=object))

    @classmethod
    def of(
        cls, columns: list[tuple[int, int, Floats]], vectors: list[Floats | None], count: int
    ) -> Poses:
        """From a slice of other poses."""
        own = cls.__new__(cls)
        own.columns, own.vectors, own.shape, own.count = columns, vectors, (count,), count
        return own

    def slice(
        self, start: int, stop: int
    ) -> tuple[list[tuple[int, int, Floats]], list[Floats | None]]:
        """Columns of poses `start` to `stop` in C order, contiguous."""
        columns = [(m, t, np.array(a.flat[start:stop])) for m, t, a in self.columns]
        vectors = [
            None if v is None else np.array(v.flat[3 * start : 3 * stop]).reshape(-1, 3)
            for v in self.vectors
        ]
        return columns, vectors

    def at(
        self, places: NDArray[np.int64]
    ) -> tuple[list[tuple[int, int, Floats]], list[Floats | None]]:
        """Columns of some poses, by their numbers in C order, contiguous."""
        columns = [(m, t, np.array(a.flat[places])) for m, t, a in self.columns]
        vectors = [
            None if v is None else np.stack([v[..., k].flat[places] for k in range(3)], axis=-1)
            for v in self.vectors
        ]
        return columns, vectors


def resolved(
    robot: _cppr.Robot,
    poses: Poses,
    loads: list[Load] | None,
    settings: Settings | None,
    accuracy: float | None,
) -> tuple[Settings | None, float]:
    """Settings with which the tips of some poses are within `accuracy` times the length, and the greatest error (m) that is left: of
    poses from the first to the last, and of those with the least and the greatest value of every input. Modes that
    `settings.refine` chooses stay."""
    if accuracy is None or not poses.count:
        return settings, math.nan
    if not 0 < accuracy <= 1:
        raise ValueError(f"accuracy is {accuracy}; it is a part of the robot's length above 0 and up to 1, or None")
    settings = settings or Settings()
    places = set(np.linspace(0, poses.count - 1, 8).astype(int).tolist())
    inputs = [values for _, _, values in poses.columns]
    inputs += [vector[..., k] for vector in poses.vectors if vector is not None for k in range(3)]
    for values in inputs:
        places |= {int(np.argmin(values)), int(np.argmax(values))}
    columns, (force, moment) = poses.at(np.array(sorted(places)))
    factor, error, known = _cppr.modes_for(
        robot, columns, force, moment, loads, settings, len(places), accuracy
    )
    if error is not None and settings.refine == 1 and error > accuracy * robot.length:
        warnings.warn(
            f"a tip is within {error / robot.length:.1e} of the length only, not {accuracy:.1e}, among {known} poses looked at: "
            "the fields of this robot change faster along it than four times as many modes follow; cppr.Bundle.of(robot) solves without modes",
            AccuracyWarning,
            stacklevel=3,
        )
    return replace(settings, refine=factor * settings.refine), math.nan if error is None else error


def numbers(name: str, values: ArrayLike) -> Floats:
    """An array of numbers; what a mask hides is none."""
    if np.ma.is_masked(values):
        raise ValueError(
            f"{name} has masked values: leave them out, or put numbers in their places with filled()"
        )
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be an array of numbers, not of {array.dtype}")
    return array.astype(np.float64, copy=False)


def _vectors(name: str, values: ArrayLike) -> Floats:
    array = numbers(name, values)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{name} has shape {array.shape}; its last axis must hold 3 components")
    return array


Progress = Union[bool, Callable[[int, int], object]]


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def watcher(progress: Progress) -> tuple[Callable[[int, int], object] | None, Callable[[], object]]:
    """A callback for `progress`, and what closes it: a bar of tqdm for True."""
    if callable(progress):
        return progress, lambda: None
    if not progress:
        return None, lambda: None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        raise ImportError("progress=True draws a bar with tqdm: pip install tqdm") from None
    bar = tqdm(unit="pose")

    def update(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)

    return update, bar.close


def solve_many(
    self: _cppr.Robot,
    pull: PerTube = None,
    rotate: PerTube = None,
    tension: PerTube = None,
    torque: PerTube = None,
    *,
    tip_force: ArrayLike | None = None,
    tip_moment: ArrayLike | None = None,
    loads: Iterable[Load] | None = None,
    settings: Settings | None = None,
    accuracy: float | None = 1e-4,
    jacobian: bool = False,
    margin: bool = False,
    sections: int = 0,
    warm: bool = True,
    threads: int | None = None,
    progress: Progress = False,
) -> Solutions:
    """Equilibria of many poses, on all cores.

    `pull` (m), `rotate` (rad), `tension` (N) and `torque` (N m) are arrays for tube 2 or dicts from tube number to
    array; `tip_force` (N) and `tip_moment` (N m) have shape (..., 3). All broadcast together to the shape P of the
    result. `loads` act in every pose. `jacobian`, `margin` and `sections` (points of the centreline) ask for more
    than tip and actuators. Twice or four times as many modes are taken where the tips of some poses, among them the first, the last and
    those with the least and the greatest inputs, are not within `accuracy` times the length otherwise; None leaves the modes as they
    are, unknown errors included. A pose that is near the one before it in memory (what changes would bend or turn the robot by less than 0.35 rad) begins there,
    all others at rest; `warm=False` begins every pose at rest. `progress` is True (a bar of tqdm) or a function of (done, total). Ctrl-C stops it.

    Warns with `AccuracyWarning` where that is not reached. Raises `CommandError` for poses that cannot be asked of this robot, before any is solved. A pose without
    equilibrium is no error: see `Solutions.code`.
    """
    drives = {"pull": pull, "rotate": rotate, "tension": tension, "torque": torque}
    poses = Poses(drives, tip_force, tip_moment)
    loads = None if loads is None else list(loads)
    settings, error = resolved(self, poses, loads, settings, accuracy)
    out = solve_slice(
        self, poses, 0, poses.count,
        loads=loads, settings=settings, jacobian=jacobian, margin=margin, sections=sections,
        warm=warm, threads=threads, progress=progress,
    )  # fmt: skip
    return replace(unpack(out, poses.shape, len(self.followers), jacobian, margin, sections), error=error)


def solve_slice(
    robot: _cppr.Robot,
    poses: Poses,
    start: int,
    stop: int,
    *,
    loads: Iterable[Load] | None,
    settings: Settings | None,
    jacobian: bool,
    margin: bool,
    sections: int,
    warm: bool,
    threads: int | None,
    progress: Progress,
    first: int = 0,
) -> Floats:
    """One row per pose; see `unpack`. Messages count poses from `first`."""
    if not 0 <= sections <= 100_000:
        raise ValueError(f"sections is {sections}; it must lie between 0 and 100000")
    if threads is None:
        threads = cores()
    if threads < 1:
        raise ValueError(f"threads is {threads}; at least one is needed")
    followers = len(robot.followers)
    width = 15 + 4 * followers + (12 * followers + 36) * jacobian + margin + 3 * sections
    out = np.empty((stop - start, width))
    columns, (force, moment) = poses.slice(start, stop)
    callback, close = watcher(progress)
    try:
        _cppr.solve_many(
            robot, columns, force, moment, None if loads is None else list(loads), settings,
            out, jacobian, margin, sections, threads, callback, start + first, warm,
        )  # fmt: skip
    finally:
        close()
    return out


def _taker(out: Floats, shape: tuple[int, ...]) -> Callable[..., Floats]:
    """Takes the next numbers of every row, in the shape that each pose has of them."""
    at = 0

    def take(*each: int) -> Floats:
        nonlocal at
        count = math.prod(each)
        view = out[:, at : at + count]
        at += count
        return view.reshape((*shape, *each))

    return take


def unpack(
    out: Floats, shape: tuple[int, ...], followers: int, jacobian: bool, margin: bool, sections: int
) -> Solutions:
    """Views of the rows as fields."""
    take = _taker(out, shape)
    fields: dict[str, Any] = {"code": take().astype(np.uint8), "iterations": take(), "elastic_energy": take()}
    fields |= {"tip_position": take(3), "tip_rotation": take(3, 3)}
    fields |= {name: take(followers) for name in ("pull", "rotation", "tension", "torque")}
    if jacobian:
        fields |= {"jacobian": take(6, 2 * followers), "compliance": take(6, 6)}
    if margin:
        fields["margin"] = take()
    if sections:
        fields["centreline"] = take(sections, 3)
    return Solutions(**fields)


def solve_many_of_bundle(
    self: _cppr.Bundle,
    pull: PerTube = None,
    rotate: PerTube = None,
    tension: PerTube = None,
    torque: PerTube = None,
    *,
    tip_force: ArrayLike | None = None,
    tip_moment: ArrayLike | None = None,
    loads: Iterable[Load] | None = None,
    jacobian: bool = False,
    stretch: bool = False,
    warm: bool = True,
    threads: int | None = None,
    progress: Progress = False,
) -> BundleSolutions:
    """Equilibria of many poses, on all cores.

    `pull` (m), `rotate` (rad), `tension` (N) and `torque` (N m) are arrays for tube 2 or dicts from tube number to
    array; `tip_force` (N) and `tip_moment` (N m) have shape (..., 3). All broadcast together to the shape P of the
    result. `loads` act in every pose. A pose that is near the one before it in memory (no motor moves by more than 0.3 % of the length and 0.1 rad, and nothing else
    changes) begins there, all others at rest; `warm=False` begins every pose at rest. `progress` is True (a bar of tqdm) or a function of (done, total). Ctrl-C stops it.

    Raises `CommandError` for poses that cannot be asked of this robot, before any is solved. A pose without equilibrium is no error: see `BundleSolutions.code`.
    """
    threads = cores() if threads is None else threads
    if threads < 1:
        raise ValueError(f"threads is {threads}; at least one is needed")
    drives = {"pull": pull, "rotate": rotate, "tension": tension, "torque": torque}
    poses = Poses(drives, tip_force, tip_moment)
    columns, (force, moment) = poses.slice(0, poses.count)
    tubes = len(self.lengths)
    out = np.empty((poses.count, 15 + 4 * tubes + 12 * tubes * jacobian))
    callback, close = watcher(progress)
    try:
        _cppr.solve_many_of_bundle(
            self, columns, force, moment, None if loads is None else list(loads), stretch, out, jacobian, threads,
            callback, warm,
        )  # fmt: skip
    finally:
        close()
    take = _taker(out, poses.shape)
    fields: dict[str, Any] = {"code": take().astype(np.uint8), "iterations": take(), "tip_error": take()}
    fields |= {"tip_position": take(3), "tip_rotation": take(3, 3)}
    fields |= {name: take(tubes) for name in ("pull", "rotation", "tension", "torque")}
    if jacobian:
        fields["jacobian"] = take(6, 2 * tubes)
    return BundleSolutions(**fields)


solve_many_of_bundle.__name__ = "solve_many"
