"""Statics of concentric push-pull robots: nested, asymmetrically notched tubes, joined at the tip.

SI throughout: m, rad, N, N m, Pa. Multiply by `mm` and `deg` where that reads better. Tube 1 is the leader, tubes
2, 3, ... are followers; a bare number belongs to tube 2, ``{2: ..., 3: ...}`` names tubes. Base frame: origin in the
middle of the baseplate, X along the robot at rest, angles about it from +Y towards +Z.

>>> import cppr
>>> robot = cppr.Robot.from_toml("robots/r3.toml")
>>> eq = robot.solve(pull=5 * cppr.mm)
>>> eq.tip_position.round(4)
array([ 0.1344, -0.0549,  0.    ])
"""

from __future__ import annotations

import math

from . import _processor  # before anything compiled
from . import _analysis, _bundle, _frames, _inverse, _many, _plot, _show
from ._analysis import Branch, Governing, Limits, RangeEnd, SafeRange, SectionLimit
from ._bundle import Joint, Part, Shaft, Tube
from ._calibrate import Calibration, Misses, Residual, calibrate
from ._cppr import Bundle, BundleEquilibrium, Equilibrium, Robot, Shape, __version__
from ._design import (
    Material,
    NotchPattern,
    NotchedTube,
    PerNotch,
    ProfileLike,
    Settings,
    StiffnessTube,
    Table,
    TubeLike,
)
from ._errors import (
    AccuracyWarning,
    CalibrationError,
    CommandError,
    Error,
    NoEquilibrium,
    Problem,
    RobotError,
    SnapWarning,
    UnitWarning,
)
from ._inverse import Reach, Sensed, ShapeMatch
from ._loads import DistributedForce, Gravity, Load, Thread, VectorLike, Wrench
from ._many import BundleSolutions, Solutions
from ._section import SectionProperties, section
from ._show import View
from ._sweep import Normal, Range, sweep

mm = 1e-3
"""One millimetre (m)."""
deg = math.pi / 180
"""One degree (rad)."""

# Methods that need no speed are written in Python; the stub of `_cppr` describes them with the others.
for _class, _method in (
    (Robot, _many.solve_many),
    (Equilibrium, _analysis.limits),
    (Equilibrium, _analysis.safe_part),
    (Equilibrium, _analysis.safe_ranges),
    (Equilibrium, _analysis.continue_path),
    (Equilibrium, _inverse.reach),
    (Equilibrium, _inverse.match_shape),
    (Equilibrium, _inverse.sense),
    (Equilibrium, _plot.plot),
    (Bundle, _many.solve_many_of_bundle),
    (BundleEquilibrium, _analysis.limits),
    (BundleEquilibrium, _analysis.safe_part),
    (BundleEquilibrium, _analysis.safe_ranges),
    (BundleEquilibrium, _analysis.continue_path),
    (BundleEquilibrium, _inverse.reach),
    (BundleEquilibrium, _inverse.match_shape),
    (BundleEquilibrium, _inverse.sense),
    (BundleEquilibrium, _bundle.plot),
    (Equilibrium, _show.show),
    (Equilibrium, _frames.to_dataframe),
    (Equilibrium, _frames.to_xarray),
):
    setattr(_class, _method.__name__, _method)

__all__ = [
    "AccuracyWarning",
    "Branch",
    "Bundle",
    "BundleEquilibrium",
    "BundleSolutions",
    "Calibration",
    "CalibrationError",
    "CommandError",
    "DistributedForce",
    "Equilibrium",
    "Error",
    "Governing",
    "Gravity",
    "Joint",
    "Limits",
    "Load",
    "Material",
    "Misses",
    "NoEquilibrium",
    "Normal",
    "NotchPattern",
    "NotchedTube",
    "Part",
    "PerNotch",
    "Problem",
    "ProfileLike",
    "Range",
    "RangeEnd",
    "Reach",
    "Residual",
    "Robot",
    "RobotError",
    "SafeRange",
    "SectionLimit",
    "SectionProperties",
    "Sensed",
    "Settings",
    "Shaft",
    "Shape",
    "ShapeMatch",
    "SnapWarning",
    "Solutions",
    "StiffnessTube",
    "Table",
    "Thread",
    "Tube",
    "TubeLike",
    "UnitWarning",
    "VectorLike",
    "View",
    "Wrench",
    "__version__",
    "calibrate",
    "deg",
    "mm",
    "section",
    "sweep",
]
