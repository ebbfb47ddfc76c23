"""Inverse problems against the forward one."""

from __future__ import annotations

import time

import numpy as np
import pytest

import cppr


def test_reach_comes_back(three: cppr.Robot) -> None:
    wanted = three.solve(pull={2: 3e-4, 3: -2e-4})
    answer = three.solve().reach(position=wanted.tip_position)
    assert answer.reached and answer.distance is not None and answer.distance < 1e-6
    assert answer.inputs == (("pull", 2), ("rotate", 2), ("pull", 3), ("rotate", 3))
    assert np.allclose(answer.equilibrium.tip_position, wanted.tip_position, atol=1e-6)
    assert answer.equilibrium.pull.tolist() == pytest.approx(answer.values[::2].tolist(), abs=1e-9)
    assert answer.angle is None and answer.condition > 1 and answer.manipulability > 0
    far = three.solve().reach(position=(0.1, 0, 0))
    assert not far.reached and far.distance is not None and far.distance > 0.05
    with pytest.raises(cppr.CommandError):
        three.solve().reach()


def test_a_controller_reaches_from_where_it_is() -> None:
    r1 = cppr.Robot.from_toml("robots/r1.toml")
    here = r1.solve(pull=3e-3, rotate=0.4)
    wanted = r1.solve(pull=3.2e-3, rotate=0.45)
    answer = here.reach(position=wanted.tip_position, near=True)
    assert answer.reached and not answer.depends_on_path
    assert answer.values == pytest.approx([3.2e-3, 0.45], rel=1e-5)
    nearest = answer.equilibrium.limits().governing
    assert nearest is not None and answer.limit_used == pytest.approx(nearest.utilisation)
    # Beyond the limits it goes on, and says so.
    far = r1.solve(pull=7e-3).reach(position=r1.solve(pull=9e-3).tip_position, near=True)
    assert far.reached and far.limit_used > 1

    def best(near: bool, times: int) -> float:
        """Least time of a call (s)."""
        spent = []
        for _ in range(times):
            start = time.perf_counter()
            here.reach(position=wanted.tip_position, near=near)
            spent.append(time.perf_counter() - start)
        return min(spent)

    assert best(True, 20) < best(False, 1) / 30


def test_a_shape_gives_its_actuators_back(r3: cppr.Robot) -> None:
    made = r3.solve(pull=3e-3)
    x = np.linspace(0.03, 0.15, 9)
    answer = r3.solve().match_shape(made.sample(x).centre, x)
    assert answer.values[answer.inputs.index(("pull", 2))] == pytest.approx(3e-3, abs=1e-6)
    assert answer.rms < 1e-6 and answer.distances.shape == (9,) and answer.covariance.shape == (2, 2)
    loose = r3.solve().match_shape(made.sample(x).centre)
    assert loose.rms < 1e-5
    with pytest.raises(ValueError, match=r"must be \(n, 3\)"):
        r3.solve().match_shape([1, 2, 3])
    with pytest.raises(ValueError, match="for 9 points"):
        r3.solve().match_shape(made.sample(x).centre, [0.1])


def test_a_force_is_sensed_from_tension_and_tip(r3: cppr.Robot) -> None:
    made = r3.solve(pull=4e-3, tip_force=(0, 0.08, 0.03))
    standing = r3.solve(pull=4e-3)
    answer = standing.sense(tension=made.tension[0], torque={2: made.torque[0]}, position=made.tip_position)
    assert np.abs(answer.force[1:] - [0.08, 0.03]).max() < 1e-3
    assert answer.deviations.shape == (3,) and not answer.moment.any()
    assert answer.misses.shape == (3,) and answer.misses.max() < 1e-3
    assert answer.equilibrium.tension[0] == pytest.approx(made.tension[0], abs=1e-3)
    with pytest.raises(cppr.CommandError, match="there is no tube 3"):
        standing.sense(tension={3: 1.0})
    with pytest.raises(cppr.CommandError):
        standing.sense()


def test_a_force_is_sensed_through_friction(r3: cppr.Robot) -> None:
    force = (0.0, 0.08, 0.03)
    made = r3.solve(pull=4e-3, tip_force=force)
    rubbed = dict(zip(("loading", "unloading"), made.friction(0.2)))
    standing = {"loading": r3.solve(pull=4e-3), "unloading": cppr.Bundle.of(r3).solve(pull=4e-3)}
    for side, measured in rubbed.items():
        seen = {"tension": measured["tension"][1], "position": measured["tip_position"]}
        answer = standing[side].sense(**seen, friction=0.2)
        own = getattr(answer, side)
        assert np.abs(own.force - force).max() < 1e-3, (side, own.force)
        assert np.abs(answer.force - force).max() > 0.05, "friction that is not known of is taken for a force"
        assert isinstance(own.equilibrium, cppr.BundleEquilibrium) and own.equilibrium.stable
        assert own.equilibrium.tip_position == pytest.approx(made.tip_position, abs=1e-5)
        free = standing[side].sense(**seen)
        assert free.force == pytest.approx(answer.force, abs=1e-3)
        assert free.loading is None and free.unloading is None
    guided = standing["unloading"].sense(**seen, friction=0.2, guide=0.02).unloading
    assert guided is not None and np.abs(guided.force - force).max() > 0.01, "the guide rubs too"
    with pytest.raises(ValueError, match="at least 0"):
        r3.solve(pull=4e-3).sense(tension=1.0, friction=-0.1)
