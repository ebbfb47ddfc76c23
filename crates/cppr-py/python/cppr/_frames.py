"""Shapes as tables of pandas and data sets of xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import _cppr

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Name, axes and unit of every field of a shape.
_FIELDS: dict[str, tuple[tuple[str, ...], str]] = {
    "centre": (("x", "axis"), "m"),
    "rotation": (("x", "axis", "column"), "1"),
    "curvature": (("x", "axis"), "1/m"),
    "angles": (("x", "follower"), "rad"),
    "energy_density": (("x",), "J/m"),
    "abscissa": (("x", "tube"), "m"),
    "centroid": (("x", "tube", "axis"), "m"),
    "tube_rotation": (("x", "tube", "axis", "column"), "1"),
    "rate": (("x", "tube"), "1"),
    "strain": (("x", "tube", "axis"), "rad/m"),
    "stretch": (("x", "tube"), "1"),
    "moment": (("x", "tube", "axis"), "N m"),
    "force": (("x", "tube", "axis"), "N"),
}
_UNITS = {"m": "m", "1/m": "1_m", "rad": "rad", "J/m": "J_m", "rad/m": "rad_m", "N m": "Nm", "N": "N"}


def to_dataframe(self: _cppr.Equilibrium, sections: int = 101) -> pd.DataFrame:
    """One row per section and tube, `sections` from baseplate to tip; columns carry their units.

    Fields of the robot as a whole (centre, curvature) are repeated in the rows of its tubes.
    """
    import pandas as pd

    shape = self.sample(sections)
    n, tubes = shape.abscissa.shape
    table: dict[str, object] = {
        "x_m": np.repeat(shape.x, tubes),
        "tube": np.tile(np.arange(1, tubes + 1), n),
    }
    for name, (axes, unit) in _FIELDS.items():
        if "column" in axes or "follower" in axes:
            continue
        values = getattr(shape, name)
        if "tube" not in axes:
            values = np.repeat(values, tubes, axis=0)
        suffix = f"_{_UNITS[unit]}" if unit in _UNITS else ""
        if "axis" in axes:
            flat = values.reshape(-1, 3)
            table |= {f"{name}_{axis}{suffix}": flat[:, i] for i, axis in enumerate("xyz")}
        else:
            table[f"{name}{suffix}"] = values.reshape(-1)
    return pd.DataFrame(table)


def to_xarray(self: _cppr.Equilibrium, sections: int = 101) -> xr.Dataset:
    """Every field of `Shape` with named axes, `sections` from baseplate to tip; units are attributes."""
    import xarray as xr

    shape = self.sample(sections)
    tubes = shape.abscissa.shape[1]
    fields = {name: (axes, getattr(shape, name), {"units": unit}) for name, (axes, unit) in _FIELDS.items()}
    return xr.Dataset(
        fields,
        coords={
            "x": ("x", shape.x, {"units": "m", "long_name": "rest abscissa of the leader"}),
            "axis": ["x", "y", "z"],
            "column": ["tangent", "centroid", "normal"],
            "tube": np.arange(1, tubes + 1),
            "follower": np.arange(2, tubes + 1),
        },
        attrs={"robot": self.robot.name, "status": self.status},
    )
