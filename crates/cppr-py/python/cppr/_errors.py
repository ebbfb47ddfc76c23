"""What can go wrong, as exceptions that say what is wrong, where, and what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ._cppr import Equilibrium


class Problem(NamedTuple):
    """One problem of a robot."""

    line: int
    """Line of the file, from 1; 0 where the problem has no line."""
    column: int
    """Column in characters, from 1; 0 where the problem has no line."""
    key: str
    """The value concerned, such as ``tube 2, notches.depth_mm``; may be empty."""
    message: str
    """What is wrong."""
    help: str
    """What to write instead; may be empty."""


class Error(Exception):
    """Base of every exception of this package."""


class RobotError(Error, ValueError):
    """A robot cannot be built. The message lists everything that is wrong with it, not only the first."""

    def __init__(self, message: str, problems: tuple[Problem, ...] = ()) -> None:
        super().__init__(message, problems)
        self.problems = problems
        """All problems, in the order of the file's lines."""

    def __str__(self) -> str:
        return str(self.args[0])


class CommandError(Error, ValueError):
    """What is asked for cannot be asked of this robot."""


class CalibrationError(Error, ValueError):
    """Parameters cannot be fitted to these data."""


class NoEquilibrium(Error, ArithmeticError):
    """No equilibrium was found, or the one found has no derivative."""

    def __init__(
        self, message: str, fraction: float = 0.0, equilibrium: Equilibrium | None = None
    ) -> None:
        super().__init__(message, fraction, equilibrium)
        self.status = message
        """Why, as a sentence."""
        self.fraction = fraction
        """Greatest fraction of the command at which an equilibrium was found (0 to 1)."""
        self.equilibrium = equilibrium
        """The last iterate: the state at `fraction`, to look at, not to rely on."""

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> tuple[Any, ...]:
        # An iterate belongs to its process.
        return (type(self), (self.status, self.fraction))


class UnitWarning(UserWarning):
    """A number looks as if it were given in another unit than SI."""


class AccuracyWarning(UserWarning):
    """The answer is not as accurate as was asked for."""


class SnapWarning(UserWarning):
    """Driven from rest the robot snaps on its way to this equilibrium."""
