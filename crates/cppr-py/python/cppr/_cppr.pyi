import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal, final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray
from pandas import DataFrame
from typing_extensions import TypeAlias
from xarray import Dataset

from ._analysis import Branch, Limits, PerTubeNumber, RangeEnd, SafeRange
from ._bundle import Joint, Tube
from ._design import Settings, TubeLike
from ._inverse import Reach, Sensed, ShapeMatch
from ._loads import Load, VectorLike
from ._many import BundleSolutions, PerTube, Progress, Solutions
from ._show import View

_Floats: TypeAlias = NDArray[np.float64]

__all__ = [
    "_bundle",
    "_bundle_equilibrium",
    "_equilibrium",
    "_robot",
    "_shape",
    "__version__",
    "Robot",
    "Equilibrium",
    "Shape",
    "Bundle",
    "BundleEquilibrium",
    "section",
    "calibrate",
    "limits",
    "part",
    "ranges",
    "trace",
    "reach",
    "match_shape",
    "sense",
    "solve_many",
    "solve_many_of_bundle",
    "modes_for",
    "sweep",
    "time_solves",
    "time_many",
]

__version__: str

@final
class Robot:
    """A checked robot. Immutable; any number of threads may solve with it at the same time.

    `length` is the rest length of all tubes above the baseplate (m); `tubes` are the leader, then the followers from
    outside to inside. `friction` is the coefficient between the tubes and `guide` (m) the length over which they are held below the plate: what asks for friction
    takes them where it is given no others. Raises `RobotError` with everything that is wrong with the robot, `ValueError` for a negative friction.
    """

    def __new__(
        cls,
        length: float,
        tubes: Sequence[TubeLike],
        name: str = "robot",
        *,
        friction: float | None = None,
        guide: float | None = None,
    ) -> Robot: ...
    @staticmethod
    def from_toml(path: str | os.PathLike[str]) -> Robot:
        """Reads a robot file. Raises `RobotError` with all its problems, each with its line.

        Gives an `AccuracyWarning` where there are sudden changes along a tube, which modes do not follow: ``cppr.Bundle.of(robot)``, or
        `Bundle.from_toml`, integrates such a robot.
        """

    @staticmethod
    def from_toml_text(text: str) -> Robot:
        """Reads a robot from the text of a robot file. Raises `RobotError` as `from_toml`."""

    def to_toml(self, path: str | os.PathLike[str]) -> None:
        """Writes a robot file that reads back as this robot.

        Raises `RobotError` for what no file can say, such as a modulus below that of any solid.
        """

    def to_toml_text(self) -> str:
        """The text of a robot file that reads back as this robot. Raises `RobotError` as `to_toml`."""

    @property
    def name(self) -> str:
        """Name."""

    @property
    def friction(self) -> float | None:
        """Coefficient of friction between the tubes; None where the robot does not say it."""

    @property
    def guide(self) -> float | None:
        """Length of the guide below the plate in which tubes rub too (m)."""

    @property
    def length(self) -> float:
        """Rest length of every tube above the baseplate (m)."""

    @property
    def tubes(self) -> tuple[TubeLike, ...]:
        """The tubes, the leader first; change them with `dataclasses.replace` and build another robot.

        Profiles that are neither constant nor linear come as a `Table` of 257 values.
        """

    @property
    def followers(self) -> tuple[int, ...]:
        """Tube numbers of the followers: 2, 3, ..."""

    @property
    def is_planar(self) -> bool:
        """True where all centroid lines at rest lie in the X-Y plane."""

    def fields(self, x: ArrayLike, tube: int = 1) -> dict[str, _Floats]:
        """Fields of a tube at rest abscissae `x` (m), shape (n,); x < 0 is below the baseplate. Each of shape (n,).

        centroid_offset (m), bending_y, bending_z, torsion (N m²), axial (N, NaN where unknown), mass_per_length
        (kg/m), direction of the centroid (rad), depth of the notches (m, NaN for a tube given by its stiffness).
        """

    def fewest_modes(
        self, commands: Sequence[dict[str, Any]], accuracy: float = 1e-4, settings: Settings | None = None
    ) -> Settings:
        """Settings with as few modes as some commands bear with, for a loop that moves between them: those at the ends of what it moves through, for example.

        A command is a dict of the keywords `pull`, `rotate`, `tension`, `torque`, `tip_force`, `tip_moment` and `loads` of `solve`. Every one, solved from rest, has its tip within
        `accuracy` times the length, and is as stable as with all modes. `refine` of the settings, else as given, is 0.375, 0.5, 0.75 or 1, and 2 or 4 where more modes are needed. Forces
        and derivatives become coarser with the tip. Raises `NoEquilibrium` where no error is known, as in the printed formulation.
        """

    def solve(
        self,
        pull: PerTubeNumber = None,
        rotate: PerTubeNumber = None,
        tension: PerTubeNumber = None,
        torque: PerTubeNumber = None,
        *,
        tip_force: VectorLike | None = None,
        tip_moment: VectorLike | None = None,
        loads: Iterable[Load] | None = None,
        start: Equilibrium | None = None,
        settings: Settings | None = None,
        accuracy: float | None = 1e-4,
    ) -> Equilibrium:
        """The equilibrium under prescribed motions or efforts and loads.

        `pull` (m, push negative) and `rotate` (rad, right-handed about +X) prescribe motions of the followers below
        the plate, `tension` (N) and `torque` (N m) efforts: a number for tube 2 or a dict from tube number to number.
        What is not prescribed is held. `tip_force` (N) and `tip_moment` (N m), shape (3,), are dead loads at the
        centre of the tip; `loads` holds others. `start` is an equilibrium of this robot to start at; without it the
        solve starts from rest.

        From rest, `accuracy` is the error of the tip that is accepted, as a part of the robot's length: where the modes of the
        settings exceed it, twice or four times as many are taken; None leaves them as they are. See `Equilibrium.accuracy`.

        Where a solve from rest finds no stable equilibrium the path of equilibria from rest is followed to the command; a `SnapWarning` says where it
        folds. An unstable equilibrium is returned: see `Equilibrium.stable`. Raises `NoEquilibrium` where there is none,
        `CommandError` for what cannot be asked of this robot; warns with `UnitWarning` and `AccuracyWarning`.
        """

    def solve_many(
        self,
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

        `pull` (m), `rotate` (rad), `tension` (N) and `torque` (N m) are arrays for tube 2 or dicts from tube number
        to array; `tip_force` (N) and `tip_moment` (N m) have shape (..., 3). All broadcast together to the shape P
        of the result. `loads` act in every pose. `jacobian`, `margin` and `sections` (points of the centreline) ask
        for more than tip and actuators. Twice or four times as many modes are taken where the tips of some poses, among them the first,
        the last and those with the least and the greatest inputs, are not within `accuracy` times the length otherwise; None leaves
        the modes as they are. A pose near the one before it, by less than 0.35 rad of bending or turning, begins there, all others at rest;
        `warm=False` begins every pose at rest. `progress` is True (a bar of tqdm) or a function of (done, total).

        Warns with `AccuracyWarning` where that is not reached.
        """

    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Equilibrium:
    """The state of a robot under a command. F stands for the number of followers, m = 2 F for that of inputs.

    Pickled and copied with its robot, number by number; nothing is solved again.
    """

    def __reduce__(self) -> tuple[Any, ...]: ...

    def contact(self) -> list[dict[str, Any]]:
        """How the tubes press on each other where they have no clearance: per pair of neighbours the tube numbers `outer` and `inner`, `length` of
        the centreline (m), `outer_abscissa` and `inner_abscissa` (m), each of shape (m,), and `force`, of the outer tube on the inner one per length of the
        centreline (N/m), base frame, shape (m, 3).
        """

    def friction(
        self, coefficient: float | None = None, guide: float | None = None
    ) -> tuple[dict[str, _Floats], dict[str, _Floats]]:
        """The two equilibria of full slip between which friction leaves the pose: as if all motors had been driven on to the command, and as if
        they had been driven back to it. `guide` is the length (m) over which tubes are held below the baseplate and rub there as well. What is not given is the robot's.

        Each has `tip_position` (m), and per tube, the leader first, `pull` (m), `rotation` (rad), `tension` (N), `torque` (N m). Raises
        `NoEquilibrium` where one of them was not found.
        """

    def clearance_estimate(self, gap: float | None = None) -> dict[str, Any]:
        """What radial gaps between the tubes make of the pose, estimated: those that the radii leave, or `gap` (m) between all tubes.

        `pairs` has per pair of neighbours the tube numbers `outer` and `inner`, `gap` (m), the mean `offset` of the inner tube's axis (m), the length
        `layer` behind the plate beyond which it lies on the wall (m) and whether it does, `touches`. `tip_position` (m) and `tip_direction` are those of the tip; per tube,
        the outermost first, `pull` (m), `tension` (N) and `backlash` (m), the travel over which the tension passes zero, NaN where there is none. Raises `NoEquilibrium`
        where the estimate cannot be made.
        """

    def with_clearance(
        self, gap: float | None = None, *, guide: tuple[float, float] | None = None, elements: int = 120
    ) -> dict[str, Any]:
        """The equilibrium with radial gaps between the tubes and contact at their walls, from this one without: gaps that the radii leave, or `gap` (m)
        between all tubes. `guide` is length and radial gap (m) of a guide below the baseplate in which tube 2 has play; without it every tube leaves the plate on the axis and straight.

        `tip_position` (m) and `bend_angle` (rad, between the tip and +X) are those of the tip; `error` says how far tip (m) and tensions (N) moved from half as many
        `elements`. `pull` (m), `tension` (N) and `torque` (N m) have one value for each of tubes 2, 3, ...; `leader` has `pull`, `rotation`, `tension` and `torque` of tube 1. At sections, whose
        `labels` (m), shape (n,), are those of tube 1, beyond its tip those of the outermost tube that goes on, shifted, and go on below the plate in the guide: `centres` of the outermost tube (m),
        shape (n, 3), and `frames`, shape (n, 3, 3), whose columns are the tangent and the axes of its material that are +Y and +Z where it is straight and not turned. `pairs` has per pair of neighbours the tube numbers
        `outer` and `inner`, `gap` (m), the offset of the inner tube's axis along these two axes, `offset` (m), shape (n, 2), NaN where both are no neighbours, its mean size `mean_offset`, the `force` of the wall on the inner tube per length
        (N/m), shape (n, 2), and `zones` where the inner tube lies on a wall: labels (m) from and to, the angles of the offset there (rad), and the force (N).

        Raises `ValueError` for gaps that are not known and what else cannot be asked (in a bundle, metal that is not linear), and `NoEquilibrium` where none is found.
        """

    @property
    def robot(self) -> Robot:
        """The robot."""

    @property
    def status(self) -> Literal["converged", "unstable", "not converged"]:
        """An unstable equilibrium is left at the slightest disturbance."""

    @property
    def stable(self) -> bool:
        """True where the energy is a minimum under the prescribed motions."""

    @property
    def tip_position(self) -> _Floats:
        """Centre of the tip section (m), base frame; shape (3,)."""

    @property
    def tip_rotation(self) -> _Floats:
        """Columns: tangent, direction of the leader's centroid, normal to both; shape (3, 3)."""

    @property
    def pull(self) -> _Floats:
        """Translation of every follower below the plate (m), push negative; shape (F,)."""

    @property
    def rotation(self) -> _Floats:
        """Rotation of every follower's base (rad), right-handed about +X; shape (F,)."""

    @property
    def tension(self) -> _Floats:
        """Force that pulls every follower (N); shape (F,)."""

    @property
    def torque(self) -> _Floats:
        """Torque on every follower (N m), conjugate to its rotation; shape (F,)."""

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads it was solved under."""

    @property
    def elastic_energy(self) -> float:
        """Of all tubes (J)."""

    @property
    def total_bend(self) -> float:
        """Total curvature of the centreline (rad): goes on beyond half a turn; greater than the angle of the tip where bends differ."""

    @property
    def residual(self) -> float:
        """Largest scaled residual (-)."""

    @property
    def iterations(self) -> int:
        """Newton steps taken."""

    @property
    def evaluations(self) -> int:
        """Evaluations of residual and tangent."""

    @property
    def load_steps(self) -> int:
        """Load steps taken after the first attempt failed."""

    @property
    def inputs(self) -> tuple[tuple[str, int], ...]:
        """What the columns of `jacobian` are: ("pull", 2), ("rotate", 2), ("pull", 3), ..."""

    @property
    def jacobian(self) -> _Floats:
        """Tip twist (m, rad) by the inputs (m, rad, or N, N m where efforts are prescribed), base frame; shape (6, m).

        Raises `NoEquilibrium` at a fold, where there is no derivative; so do the following.
        """

    @property
    def jacobian_body(self) -> _Floats:
        """The same in the frame of the tip section; shape (6, m)."""

    @property
    def response(self) -> _Floats:
        """The conjugate of every input by every input: effort by motion, motion by effort; shape (m, m)."""

    @property
    def compliance(self) -> _Floats:
        """Tip twist (m, rad) by a dead tip wrench (N, N m), base frame, inputs held; shape (6, 6)."""

    @property
    def response_by_wrench(self) -> _Floats:
        """The conjugate of every input by a dead tip wrench: what force sensing inverts; shape (m, 6)."""

    @property
    def margin(self) -> float:
        """Margin to instability: 1 at rest, 0 where the robot snaps; NaN in the printed formulation."""

    @property
    def accuracy(self) -> dict[str, Any] | None:
        """Discretisation error: of the tip (`tip`, m), the greatest of a tension (`force`, N) and of a torque (`torque`, N m), that of the stability
        margin (`margin`, against twice as many modes; None where it is not known), and what it was
        compared `against`: "integration" of the same bundle from the plate to the tip, or "half the modes", whose tip is `reference_tip` (m) and which is stable where
        `reference_stable` (None where that cannot be told). None where the integration
        finds no counterpart, and without an equilibrium."""

    @property
    def critical_direction(self) -> _Floats:
        """Where the tip goes, either way, under the softest motion, whose stiffness `margin` is: unit vector of the base
        frame, zero where the tip stays; shape (3,)."""

    @property
    def shape(self) -> Shape:
        """Fields at 101 sections from baseplate to tip."""

    def sample(self, x: int | ArrayLike | None = None) -> Shape:
        """Fields at rest abscissae of the leader (m), shape (n,), or at a number of equal steps from 0 to L."""

    def limits(self, teeth: Literal["rigid", "bending"] = "rigid") -> Limits:
        """Strain and closure of every notch, and the nearest limit.

        `teeth` are "rigid" (the notches take all bending: safe) or "bending" (as the notches do: the least there can be).
        """

    def safe_part(self, teeth: Literal["rigid", "bending"] = "rigid") -> RangeEnd:
        """How much of the command, applied from rest in proportion, keeps all limits: `value` from 0 to 1 (all)."""

    def safe_ranges(self, teeth: Literal["rigid", "bending"] = "rigid") -> tuple[SafeRange, ...]:
        """How far each actuator may go from here while the others and the loads stay.

        Raises `CommandError` where a limit is exceeded already.
        """

    def continue_path(
        self,
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
        equilibria. `step` is the longest step along the path, `points` the most points of a branch, `depth` how many times
        a branch is left for another at branch points.
        """

    def reach(
        self, position: VectorLike | None = None, direction: VectorLike | None = None, *, near: bool = False
    ) -> Reach:
        """Actuators that bring the tip to a position (m), a direction of its axis, or both, base frame.

        Loads and drives are those of this equilibrium, actuators move within their safe ranges about it. With `near`
        the search starts here and stays on this branch, which takes well under a millisecond: for a controller that knows where
        it is. Then limits are not kept but told, in `Reach.limit_used`. Raises
        `CommandError` where nothing can be searched for; out of reach is no error, see `Reach.reached`.
        """

    def match_shape(
        self, points: ArrayLike, x: ArrayLike | None = None, *, deviation: float = 1e-3
    ) -> ShapeMatch:
        """Actuators for which the centreline is nearest to points (m), shape (n, 3), base frame.

        `x` are the rest abscissae of the points (m), shape (n,), where they are known; otherwise the nearest place
        counts. `deviation` is the standard deviation of each coordinate (m).
        """

    def sense(
        self,
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
        """The force on the tip, with `moment` the whole wrench, that explains measurements while the motors stand as here.

        `tension` (N) and `torque` (N m) are measured efforts of followers moved by motion, `position` (m) and
        `direction` the measured tip, base frame. Their standard deviations weigh them. With `friction` between the tubes, and `guide` (m) below the
        plate, the answer has `loading` and `unloading` too, and the robot is integrated along its length: all equilibria are those of a `Bundle`.
        """

    def plot(
        self,
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

    def show(self, sections: int = 61) -> View:
        """A view that turns, zooms (wheel) and shifts (shift) with the mouse; works offline."""

    def to_dataframe(self, sections: int = 101) -> DataFrame:
        """One row per section and tube; columns carry their units. Needs pandas."""

    def to_xarray(self, sections: int = 101) -> Dataset:
        """Every field of `Shape` with named axes; units are attributes. Needs xarray."""

@final
class Shape:
    """Fields along a robot at n sections of the leader; N tubes, F = N - 1 followers.

    Vectors along tubes are in the section's axes: tangent, direction of the tube's centroid, normal to both. Moments
    and forces are those that the part towards the tip exerts.
    """

    def __reduce__(self) -> tuple[Any, ...]: ...
    @property
    def x(self) -> _Floats:
        """Rest abscissa of the leader (m); shape (n,)."""

    @property
    def centre(self) -> _Floats:
        """Common centreline (m), base frame; shape (n, 3)."""

    @property
    def rotation(self) -> _Floats:
        """The leader's rotation; shape (n, 3, 3)."""

    @property
    def curvature(self) -> _Floats:
        """The leader's curvature vector in its own frame (1/m), twist of the pattern included; shape (n, 3)."""

    @property
    def angles(self) -> _Floats:
        """Angles of the followers against rest (rad); shape (n, F)."""

    @property
    def energy_density(self) -> _Floats:
        """Elastic energy of all tubes per length of the leader (J/m); shape (n,)."""

    @property
    def abscissa(self) -> _Floats:
        """Rest abscissa of every tube's section that stands here (m), negative from below the plate; shape (n, N)."""

    @property
    def centroid(self) -> _Floats:
        """Centroids (m), base frame; shape (n, N, 3)."""

    @property
    def tube_rotation(self) -> _Floats:
        """Rotations of the tubes' sections; shape (n, N, 3, 3)."""

    @property
    def rate(self) -> _Floats:
        """Length of the tube per length of the leader (-); shape (n, N)."""

    @property
    def strain(self) -> _Floats:
        """Twist rate against rest (rad/m) and curvatures about the second and third axis (1/m); shape (n, N, 3)."""

    @property
    def stretch(self) -> _Floats:
        """Axial strain (-); shape (n, N)."""

    @property
    def moment(self) -> _Floats:
        """Torque about the tube's centre, bending moments through the centroid (N m); shape (n, N, 3)."""

    @property
    def force(self) -> _Floats:
        """Axial force, tension positive, and shear forces (N); shape (n, N, 3)."""

def _robot(state: bytes, version: str) -> Robot: ...
def _equilibrium(robot: Robot, state: bytes, version: str) -> Equilibrium: ...
def _bundle(state: bytes, version: str) -> Bundle: ...
def _bundle_equilibrium(robot: Bundle, state: bytes, version: str) -> BundleEquilibrium: ...
def _shape(
    x: _Floats,
    centre: _Floats,
    rotation: _Floats,
    curvature: _Floats,
    angles: _Floats,
    energy_density: _Floats,
    abscissa: _Floats,
    centroid: _Floats,
    tube_rotation: _Floats,
    rate: _Floats,
    strain: _Floats,
    stretch: _Floats,
    moment: _Floats,
    force: _Floats,
) -> Shape: ...
@final
class Bundle:
    """A checked robot of parts and joints: tubes of any length, bonded anywhere or free at their tips, curved or straight at rest.

    `tubes` are from outside to inside, and as many as nest. Without `joints` all tips are bonded to each other, which takes tubes
    of one length; `joints=[]` leaves all tips free. `friction` and `guide` (m) are as those of a `Robot`. Raises `RobotError` with what is wrong with the robot. Can be pickled and copied.
    """

    def __new__(
        cls,
        tubes: Sequence[Tube],
        joints: Sequence[Joint] | None = None,
        name: str = "robot",
        *,
        friction: float | None = None,
        guide: float | None = None,
    ) -> Bundle: ...
    @staticmethod
    def from_toml(path: str | os.PathLike[str]) -> Bundle:
        """Reads a robot file of any kind. Raises `RobotError` with all its problems, each with its line."""

    @staticmethod
    def from_toml_text(text: str) -> Bundle:
        """Reads a robot from the text of a robot file of any kind. Raises `RobotError` as `from_toml`."""

    @staticmethod
    def of(robot: Robot) -> Bundle:
        """The same robot without modes: integrated along its length, whatever its fields do there."""

    def unloading(self) -> Bundle | None:
        """The same robot with all of its superelastic metal on the curve along which it unloads (`unloading_onset_strain_percent`); None where that is the curve of
        loading. Between the equilibria of both under one command the metal's hysteresis leaves the robot, whatever was done before."""

    @property
    def name(self) -> str:
        """Name."""

    @property
    def friction(self) -> float | None:
        """Coefficient of friction between the tubes; None where the robot does not say it."""

    @property
    def guide(self) -> float | None:
        """Length of the guide below the plate in which tubes rub too (m)."""

    @property
    def length(self) -> float:
        """Greatest length of a tube above the baseplate (m)."""

    @property
    def lengths(self) -> _Floats:
        """Lengths of the tubes above the baseplate (m), shape (n,)."""

    def solve(
        self,
        pull: PerTubeNumber = None,
        rotate: PerTubeNumber = None,
        tension: PerTubeNumber = None,
        torque: PerTubeNumber = None,
        *,
        tip_force: VectorLike | None = None,
        tip_moment: VectorLike | None = None,
        loads: Iterable[Load] | None = None,
        start: BundleEquilibrium | None = None,
        stretch: bool = False,
        loop_tolerance: float | None = None,
    ) -> BundleEquilibrium:
        """The equilibrium under prescribed motions or efforts and loads, from rest or from `start`.

        `pull` (m, push and insertion negative) and `rotate` (rad, right-handed about +X) prescribe motions of the motors, `tension` (N)
        and `torque` (N m) efforts: a number for tube 2 or a dict from tube number to number; tube 1 can be driven as well. What is not
        prescribed is held. Loads are those of `Robot.solve`; places of loads are labels of tube 1.

        With `loop_tolerance` the step from `start` is that of a control loop: on the tangent of the path, without an estimate of its error, a step of the integration
        off by no more than this part of the length (up to 1e-4). 1e-6 leaves the tip within 1e-5 of the length; solves without it take 1e-8.

        Raises `NoEquilibrium` where none was found, `CommandError` for what cannot be asked of this robot; warns with `UnitWarning`.
        """

    def solve_many(
        self,
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

        `pull` (m), `rotate` (rad), `tension` (N) and `torque` (N m) are arrays for tube 2 or dicts from tube number to array; `tip_force` (N)
        and `tip_moment` (N m) have shape (..., 3). All broadcast together to the shape P of the result. `loads` act in every pose. A pose that
        is near the one before it in memory (no motor moves by more than 0.3 % of the length and 0.1 rad, and nothing else changes) begins
        there, all others at rest; `warm=False` begins every pose at rest. `progress` is True (a bar of tqdm) or a function of (done, total).

        Raises `CommandError` for poses that cannot be asked of this robot. A pose without equilibrium is no error: see `BundleSolutions.code`.
        """

    def cycle(
        self,
        waypoints: Sequence[dict[str, Any]],
        friction: float | None = None,
        *,
        guide: float | None = None,
        steps: int = 14,
        tip_force: VectorLike | None = None,
        loads: Iterable[Load] | None = None,
        stretch: bool = False,
    ) -> dict[str, Any]:
        """A history of commands with friction between the tubes (the robot's where none is given): from rest to the first waypoint, then from each to the next in `steps` steps.

        A waypoint is a dict of the keywords `pull`, `rotate`, `tension` and `torque` of `solve`. Gives, with a row for every point, `leg`, `tip_position`
        (m), `slipping` (part of the length on which neighbours slip), and `pull` (m), `rotation` (rad), `tension` (N), `torque` (N m) of all tubes.

        Raises `NoEquilibrium` where a step found none.
        """

@final
class BundleEquilibrium:
    """A robot of parts and joints under a command. n stands for the number of tubes.

    Pickled and copied with its robot and its own numbers; nothing is solved again.
    """

    @property
    def robot(self) -> Bundle:
        """Its robot."""

    @property
    def name(self) -> str:
        """Name of the robot."""

    @property
    def joints(self) -> list[dict[int, float]]:
        """Per joint the label (m) on each of its tubes, by their numbers."""

    @property
    def stable(self) -> bool:
        """True where the second variation of the energy has no negative eigenvalue: counted along the bundle."""

    @property
    def tip_position(self) -> _Floats:
        """Centre of the last tip (m), base frame; shape (3,)."""

    @property
    def tip_rotation(self) -> _Floats:
        """Columns: tangent, direction of the centroid, normal to both; shape (3, 3)."""

    @property
    def pull(self) -> _Floats:
        """Label of every tube at the baseplate (m): how far it is pulled, insertion negative; shape (n,)."""

    @property
    def rotation(self) -> _Floats:
        """Rotation of every tube at the baseplate (rad), right-handed about +X; shape (n,)."""

    @property
    def tension(self) -> _Floats:
        """Force with which every motor pulls (N); shape (n,)."""

    @property
    def torque(self) -> _Floats:
        """Torque of every motor (N m), right-handed about +X; shape (n,)."""

    @property
    def length(self) -> float:
        """Length of the centreline (m)."""

    @property
    def tip_error(self) -> float:
        """How far the tip moves when every step of the integration is halved (m)."""

    @property
    def force_error(self) -> float:
        """How far the greatest of the forces moves then (N)."""

    @property
    def iterations(self) -> int:
        """Newton steps."""

    def contact(self) -> list[dict[str, Any]]:
        """How the tubes press on each other where they have no clearance: per pair of neighbours the tube numbers `outer` and `inner`, `length` of
        the centreline (m), `outer_abscissa` and `inner_abscissa` (m), each of shape (m,), and `force`, of the outer tube on the inner one per length of the
        centreline (N/m), base frame, shape (m, 3).
        """

    def friction(
        self, coefficient: float | None = None, guide: float | None = None
    ) -> tuple[dict[str, _Floats], dict[str, _Floats]]:
        """The two equilibria of full slip between which friction leaves the pose: as if all motors had been driven on to the command, and as if
        they had been driven back to it. `guide` is the length (m) over which tubes are held below the baseplate and rub there as well. What is not given is the robot's.

        Each has `tip_position` (m), and per tube, the leader first, `pull` (m), `rotation` (rad), `tension` (N), `torque` (N m). Raises
        `NoEquilibrium` where one of them was not found.
        """

    def clearance_estimate(self, gap: float | None = None) -> dict[str, Any]:
        """What radial gaps between the tubes make of the pose, estimated: those that the radii leave, or `gap` (m) between all tubes.

        `pairs` has per pair of neighbours the tube numbers `outer` and `inner`, `gap` (m), the mean `offset` of the inner tube's axis (m), the length
        `layer` behind the plate beyond which it lies on the wall (m) and whether it does, `touches`. `tip_position` (m) and `tip_direction` are those of the tip; per tube,
        the outermost first, `pull` (m), `tension` (N) and `backlash` (m), the travel over which the tension passes zero, NaN where there is none. Raises `NoEquilibrium`
        where the estimate cannot be made.
        """

    def with_clearance(
        self, gap: float | None = None, *, guide: tuple[float, float] | None = None, elements: int = 120
    ) -> dict[str, Any]:
        """The equilibrium with radial gaps between the tubes and contact at their walls, from this one without: gaps that the radii leave, or `gap` (m)
        between all tubes. `guide` is length and radial gap (m) of a guide below the baseplate in which tube 2 has play; without it every tube leaves the plate on the axis and straight.

        `tip_position` (m) and `bend_angle` (rad, between the tip and +X) are those of the tip; `error` says how far tip (m) and tensions (N) moved from half as many
        `elements`. `pull` (m), `tension` (N) and `torque` (N m) have one value for each of tubes 2, 3, ...; `leader` has `pull`, `rotation`, `tension` and `torque` of tube 1. At sections, whose
        `labels` (m), shape (n,), are those of tube 1, beyond its tip those of the outermost tube that goes on, shifted, and go on below the plate in the guide: `centres` of the outermost tube (m),
        shape (n, 3), and `frames`, shape (n, 3, 3), whose columns are the tangent and the axes of its material that are +Y and +Z where it is straight and not turned. `pairs` has per pair of neighbours the tube numbers
        `outer` and `inner`, `gap` (m), the offset of the inner tube's axis along these two axes, `offset` (m), shape (n, 2), NaN where both are no neighbours, its mean size `mean_offset`, the `force` of the wall on the inner tube per length
        (N/m), shape (n, 2), and `zones` where the inner tube lies on a wall: labels (m) from and to, the angles of the offset there (rad), and the force (N).

        Raises `ValueError` for gaps that are not known and what else cannot be asked (in a bundle, metal that is not linear), and `NoEquilibrium` where none is found.
        """

    @property
    def inputs(self) -> tuple[tuple[str, int], ...]:
        """What the columns of `jacobian` are: ("pull", 1), ("rotate", 1), ("pull", 2), ..."""

    @property
    def jacobian(self) -> _Floats:
        """Slopes of the tip by the motors, shape (6, 2 n): rows position (m) and rotation about the base axes (rad), columns
        translation and rotation of every tube's motor, by motion (m, rad) or by effort (N, N m), as it is driven.

        Raises `NoEquilibrium` at a fold; so do the following.
        """

    @property
    def jacobian_body(self) -> _Floats:
        """The same in the frame of the tip; shape (6, 2 n)."""

    @property
    def response(self) -> _Floats:
        """The conjugate of every input by every input: effort by motion, motion at the baseplate by effort; shape (2 n, 2 n)."""

    @property
    def compliance(self) -> _Floats:
        """Tip twist (m, rad) by a dead tip wrench (N, N m), base frame, inputs held; shape (6, 6)."""

    @property
    def response_by_wrench(self) -> _Floats:
        """The conjugate of every input by a dead tip wrench; shape (2 n, 6)."""

    def sample(self, spacing: float | None = None) -> dict[str, _Floats]:
        """Fields at sections at most `spacing` (m; default a hundredth of the length) apart, from the baseplate to the last tip, on both sides of
        every place where something changes.

        length of the centreline (m), shape (k,); centre (m), (k, 3); frame, (k, 3, 3), whose first column is the tangent and which does
        not twist; and per tube, (k, n), NaN beyond its tip: abscissa (m), angle of its section against the frame (rad), centroid_offset (m),
        tension (N), torque (N m), curvature_y, curvature_z (1/m) and twist (rad/m) less those at rest.
        """

    def limits(self, teeth: Literal["rigid", "bending"] = "rigid") -> Limits:
        """Strain and closure of every notch that stands before the baseplate, and the nearest limit; as `Equilibrium.limits`."""

    def safe_part(self, teeth: Literal["rigid", "bending"] = "rigid") -> RangeEnd:
        """How much of the command, applied from rest in proportion, keeps all limits: `value` from 0 to 1 (all)."""

    def safe_ranges(self, teeth: Literal["rigid", "bending"] = "rigid") -> tuple[SafeRange, ...]:
        """How far each motor may go from here while the others and the loads stay; as `Equilibrium.safe_ranges`."""

    def continue_path(
        self,
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
        """All equilibria from here to other values of the motors, past folds; or to `load_factor` times the present loads; as
        `Equilibrium.continue_path`. Margins are not computed (NaN)."""

    def reach(
        self, position: VectorLike | None = None, direction: VectorLike | None = None, *, near: bool = False
    ) -> Reach:
        """Motors that bring the tip to a position (m), a direction of its axis, or both, base frame; as `Equilibrium.reach`. Where
        tubes are joined, those of tube 1, which advance the whole robot, stay where they are."""

    def match_shape(
        self, points: ArrayLike, x: ArrayLike | None = None, *, deviation: float = 1e-3
    ) -> ShapeMatch:
        """Motors for which the centreline is nearest to points (m), shape (n, 3), base frame; as `Equilibrium.match_shape`. `x` are lengths of
        the centreline up to the points (m). The motors of tube 1 stay as in `reach`."""

    def sense(
        self,
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
        """The force on the tip, with `moment` the whole wrench, that explains measurements while the motors stand as here; as
        `Equilibrium.sense`."""

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the centroid line of every tube as far as it reaches, the joints and the centreline (mm); returns the axes."""


def section(
    outer_radius: float, inner_radius: float, depth: float, shape: str = "round"
) -> tuple[float, float, float, float, float, float]: ...
def calibrate(
    robots: Sequence[Robot | Bundle],
    table: str,
    parameters: Sequence[str],
    friction: float | None,
    guide: float | None,
) -> dict[str, Any]: ...
def limits(equilibrium: Equilibrium | BundleEquilibrium, teeth: str) -> tuple[list[tuple[Any, ...]], Any]: ...
def part(equilibrium: Equilibrium | BundleEquilibrium, teeth: str) -> tuple[Any, Any, Any]: ...
def ranges(equilibrium: Equilibrium | BundleEquilibrium, teeth: str) -> list[tuple[Any, ...]]: ...
def trace(
    equilibrium: Equilibrium | BundleEquilibrium,
    drives: tuple[PerTubeNumber, PerTubeNumber, PerTubeNumber, PerTubeNumber],
    load_factor: float | None,
    step: float,
    points: int,
    depth: int,
) -> list[dict[str, Any]]: ...
def reach(
    equilibrium: Equilibrium | BundleEquilibrium, position: VectorLike | None, direction: VectorLike | None, near: bool
) -> dict[str, Any]: ...
def match_shape(
    equilibrium: Equilibrium | BundleEquilibrium, points: Sequence[Sequence[float]], deviation: float
) -> dict[str, Any]: ...
def sense(
    equilibrium: Equilibrium | BundleEquilibrium,
    efforts: tuple[PerTubeNumber, PerTubeNumber],
    position: VectorLike | None,
    direction: VectorLike | None,
    deviations: tuple[float, float, float, float],
    moment: bool,
    friction: tuple[float | None, float | None],
) -> dict[str, Any]: ...
def sweep(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str],
    axes: Sequence[tuple[str, int, str, str, float, float, int]],
    drives: tuple[PerTubeNumber, ...],
    tip: tuple[Sequence[float], Sequence[float]] | None,
    loads: Sequence[Load] | None,
    settings: Settings | None,
    accuracy: float | None,
    samples: int | None,
    seed: int,
    margin: bool,
    teeth: str | None,
    friction: tuple[float | None, float | None],
    resume: bool,
    threads: int,
    progress: Callable[[int, int], object] | None,
) -> dict[str, int]: ...
def solve_many(
    robot: Robot,
    columns: Sequence[tuple[int, int, _Floats]],
    tip_force: _Floats | None,
    tip_moment: _Floats | None,
    loads: Sequence[Load] | None,
    settings: Settings | None,
    out: _Floats,
    jacobian: bool,
    stability: bool,
    sections: int,
    threads: int,
    progress: Callable[[int, int], object] | None,
    first: int,
    warm: bool,
) -> None: ...
def solve_many_of_bundle(
    bundle: Bundle,
    columns: Sequence[tuple[int, int, _Floats]],
    tip_force: _Floats | None,
    tip_moment: _Floats | None,
    loads: Sequence[Load] | None,
    stretch: bool,
    out: _Floats,
    jacobian: bool,
    threads: int,
    progress: Callable[[int, int], object] | None,
    warm: bool,
) -> None: ...
def modes_for(
    robot: Robot,
    columns: Sequence[tuple[int, int, _Floats]],
    tip_force: _Floats | None,
    tip_moment: _Floats | None,
    loads: Sequence[Load] | None,
    settings: Settings | None,
    poses: int,
    accuracy: float,
) -> tuple[int, float | None, int]: ...
def time_solves(robot: Robot, pulls: Sequence[float], options: Settings | None) -> float: ...
def time_many(
    robot: Robot, pulls: Sequence[float], options: Settings | None, threads: int
) -> float: ...
