"""Parameters from measured points."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _cppr

if TYPE_CHECKING:
    import pandas as pd


class Residual(NamedTuple):
    """One measured number against the fitted model."""

    row: int
    """Line of the table, the head being line 1."""
    what: str
    """x, y, z of a point, direction, bend, or an effort such as tension2."""
    value: float
    """Model minus measurement (m, rad for a bend or a component of a direction, N or N m of an effort)."""
    studentised: float
    """Divided by its own expected deviation (-)."""
    outlier: bool
    """Improbable: one such among all would be expected in less than one of twenty data sets."""


class Misses(NamedTuple):
    """Root mean squares of measured bends (rad), or of the force (N) or torque (N m) of one motor."""

    what: str
    """bend, or an effort such as tension2."""
    before: float
    """Of model minus measurement before the fit."""
    fitted: float
    """The same with the fitted values."""
    measured: float
    """Of the measured values."""


@dataclass(frozen=True)
class Calibration:
    """Fitted parameters; p of them."""

    robots: tuple[_cppr.Robot | _cppr.Bundle, ...]
    """The robots with the fitted parameters."""
    parameters: tuple[str, ...]
    """Names, as asked for."""
    values: NDArray[np.float64]
    """Fitted values (SI), shape (p,)."""
    before: NDArray[np.float64]
    """Values before the fit (SI), shape (p,)."""
    deviations: NDArray[np.float64]
    """Standard deviations (SI), shape (p,)."""
    intervals: NDArray[np.float64]
    """Half widths of the 95 % confidence intervals (SI), shape (p,)."""
    at_bounds: tuple[bool, ...]
    """Does the value stand at a bound, such as no friction, beyond which the data would be met better? p of them."""
    correlation: NDArray[np.float64]
    """Of the estimates, shape (p, p)."""
    residuals: tuple[Residual, ...]
    """One per measured number."""
    scale: float
    """Noise against the stated deviations: 1 where these are right and the model is (-)."""
    rms: float
    """Root mean square distance between measured and computed points (m); nan where no point was measured."""
    rms_before: float
    """The same before the fit (m)."""
    misses: tuple[Misses, ...]
    """How far measured bends and efforts are missed."""
    accuracy: float | None
    """Greatest error of the model's tip as a part of the length, in up to 8 measurements of each robot; None where none is known."""

    def __repr__(self) -> str:
        lines = [
            f"{name}: {value:.6g} ± {interval:.2g} (before {before:.6g})"
            for name, value, interval, before in zip(
                self.parameters, self.values, self.intervals, self.before
            )
        ]
        if not np.isnan(self.rms):
            lines.append(f"rms distance {self.rms * 1e3:.3f} mm (before {self.rms_before * 1e3:.3f} mm)")
        for own in self.misses:
            lines.append(f"rms {own.what} {own.fitted:.4g} (before {own.before:.4g}, of {own.measured:.4g} measured)")
        return "\n".join(["Calibration, 95 % intervals", *lines])


def calibrate(
    robots: _cppr.Robot | _cppr.Bundle | Iterable[_cppr.Robot | _cppr.Bundle],
    data: Union[str, os.PathLike[str], pd.DataFrame],
    fit: Sequence[str] = ("centroid_offset_factor", "youngs_modulus"),
    *,
    friction: float | None = None,
    guide: float | None = None,
) -> Calibration:
    """Fits parameters that all robots share to measured points, angles and efforts.

    `data` is the path of a CSV table or a pandas.DataFrame with its columns, whose names carry their units: robot,
    pull2_mm, rotate2_deg, tension2_N, tip_force_y_N, driven, x_mm, y_mm, z_mm, bend_deg, measured_tension2_N, sigma_mm, ... (the book's
    page on calibration has all). `fit` names parameters: centroid_offset_factor, youngs_modulus, shear_modulus, rest_curvature_factor,
    onset_strain, second_modulus, tooth_factor, gap, with ``@2`` for tube 2 alone, and friction; with none the robots are compared as they are. `friction` is
    the coefficient between the tubes at which its fit begins, or that holds where it is not fitted (that of the robots, if any; 0 leaves it out), `guide` (m) the length
    over which tubes are held below the plate.

    Raises `CalibrationError` for wrong data and for parameters that the data cannot determine.
    """
    if isinstance(robots, (_cppr.Robot, _cppr.Bundle)):
        robots = (robots,)
    if isinstance(data, (str, os.PathLike)):
        with open(data, encoding="utf-8") as file:
            table = file.read()
    elif hasattr(data, "to_csv"):
        table = data.to_csv(index=False)
    else:
        kind = type(data).__name__
        raise TypeError(f"data must be the path of a CSV table or a pandas.DataFrame, not {kind}")
    if isinstance(fit, str):
        raise TypeError(f'fit must be a sequence of names, such as ["{fit}"], not a text')
    found = _cppr.calibrate(list(robots), table, list(fit), friction, guide)
    return Calibration(
        robots=tuple(found["robots"]),
        parameters=tuple(found["parameters"]),
        values=np.array(found["values"]),
        before=np.array(found["before"]),
        deviations=np.array(found["deviations"]),
        intervals=np.array(found["intervals"]),
        at_bounds=tuple(found["at_bounds"]),
        correlation=np.array(found["correlation"]),
        residuals=tuple(Residual(*r) for r in found["residuals"]),
        scale=found["scale"],
        rms=found["rms"],
        rms_before=found["rms_before"],
        misses=tuple(Misses(*own) for own in found["misses"]),
        accuracy=found["accuracy"],
    )
