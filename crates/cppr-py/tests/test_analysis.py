"""Limits, safe ranges, continuation, sweeps: what the library computes, as Python sees it."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
from conftest import uniform

import cppr


def test_limits_of_every_notch() -> None:
    eq = cppr.Robot.from_toml("robots/r1.toml").solve(pull=4e-3)
    limits = eq.limits()
    assert [s.tube for s in limits.sections].count(1) == 15
    # Pulling takes the first sections of the follower below the plate.
    assert {s.place for s in limits.sections} == {"notch"}
    # York et al. 2015: rigid teeth let the notch take the bending of its whole cell.
    notch = next(s for s in limits.sections if s.tube == 1 and s.number == 8)
    k = np.interp(notch.x, eq.shape.x, eq.shape.curvature[:, 2])
    assert notch.curvature_z == pytest.approx(k, rel=1e-3) and k < -1
    offset = cppr.section(3e-3, 2e-3, 5e-3).centroid_offset
    # The outer fibre of the kept part, and the cut at α = γ - ρ.
    fibres = [-2 * k * (y - offset) for y in (3e-3, 2e-3)]
    assert notch.strain == pytest.approx(max(fibres, key=abs), rel=2e-3)
    assert notch.closure == pytest.approx(-2 * k * (3e-3 + offset), rel=2e-3)
    assert notch.allowable_strain == pytest.approx(0.015)
    bending = eq.limits("bending").sections
    assert bending[7].strain == pytest.approx(0.5 * limits.sections[7].strain)
    assert limits.governing is not None and limits.governing.section is not None
    worst = max(max(abs(s.strain) / 0.015, s.closure or 0) for s in limits.sections)
    assert limits.governing.utilisation == pytest.approx(worst)
    # Short where it is shown, whatever the number of notches.
    told = repr(limits)
    assert told.startswith("Limits: ") and len(told.splitlines()) == 3 and "tube 2 notch" in told
    # Torsion: a tube of twice the section's arm, turned alone.
    turned = cppr.Robot.from_toml("robots/r1.toml").solve(rotate=1.0).limits().sections
    assert all(s.allowable_shear == pytest.approx(2 * 1.35 / 3**0.5 * 0.015) for s in turned)
    assert all(0.002 < abs(s.shear) < 0.02 for s in turned if s.place == "notch")
    with pytest.raises(ValueError, match='"rigid" or "bending"'):
        eq.limits("soft")
    assert uniform().solve().limits().sections == ()


def test_safe_ranges_end_at_a_limit() -> None:
    robot = cppr.Robot.from_toml("robots/r1.toml")
    ranges = robot.solve().safe_ranges()
    assert [(r.means, r.tube) for r in ranges] == [("pull", 2), ("rotate", 2)]
    pull = ranges[0]
    assert pull.low.value < 0 < pull.high.value and pull.start == 0
    assert pull.high.bound == "limit" and pull.high.limit is not None
    at = robot.solve(pull=pull.high.value).limits().governing
    assert at is not None and at.utilisation == pytest.approx(1.0, abs=1e-3)
    assert at.limit == pull.high.limit.limit
    with pytest.raises(cppr.CommandError, match="exceeded already"):
        robot.solve(pull=1.2 * pull.high.value).safe_ranges()
    part = robot.solve(pull=1.25 * pull.high.value).safe_part()
    assert part.value == pytest.approx(0.8, abs=1e-7) and part.bound == "limit" and part.limit is not None
    assert robot.solve(pull=0.5 * pull.high.value).safe_part() == (1.0, "open", None)


def test_the_bend_goes_on_beyond_half_a_turn(r3: cppr.Robot) -> None:
    robot = uniform()
    eq = robot.solve(pull=5e-3)
    assert eq.total_bend == pytest.approx(np.linalg.norm(eq.shape.curvature[0]) * robot.length, rel=1e-9)
    far = r3.solve(pull=30e-3)
    assert far.total_bend > np.pi > np.arccos(far.tip_rotation[0, 0])


def test_a_path_without_folds_is_a_row_of_solves(r3: cppr.Robot) -> None:
    (branch,) = r3.solve(pull=1e-3).continue_path(pull=8e-3)
    assert branch.reached and branch.stable.all() and "end of the path" in branch.end
    for i in (0, len(branch.equilibria) // 2, -1):
        pull = branch.equilibria[i].pull[0]
        assert pull == pytest.approx(1e-3 + branch.fraction[i] * 7e-3, abs=1e-9)
        assert np.abs(branch.tip_position[i] - r3.solve(pull=pull).tip_position).max() < 1e-8
    assert branch.margin[0] > branch.margin[-1] > 0
    assert repr(branch).startswith(f"Branch({len(branch.fraction)} points, 0 folds")


def test_euler_s_load_is_a_branch_point() -> None:
    tube = cppr.StiffnessTube(0.0, 0.02, 0.01, 0.01, np.pi)
    rod = cppr.Robot(0.2, [tube])
    euler = np.pi**2 * 0.01 / (4 * 0.2**2)
    (branch,) = rod.solve(tip_force=(-0.5 * euler, 0, 0)).continue_path(load_factor=3.0)
    at = branch.kind.index("branch point")
    assert branch.parameter[at] == pytest.approx(2.0, rel=1e-4)
    assert branch.stable[: at - 1].all() and not branch.stable[at + 1 :].any()
    branches = rod.solve(tip_force=(-0.5 * euler, 0, 0)).continue_path(load_factor=2.2, depth=1)
    assert len(branches) == 3 and branches[1].origin is not None
    y = [b.tip_position[-1, 1] for b in branches[1:]]
    assert y[0] == pytest.approx(-y[1], rel=1e-6) and abs(y[0]) > 0.01


def test_paths_that_cannot_be(r3: cppr.Robot) -> None:
    eq = r3.solve(pull=1e-3)
    with pytest.raises(cppr.CommandError, match="nothing varies"):
        eq.continue_path()
    with pytest.raises(cppr.CommandError, match="by motion at one end"):
        eq.continue_path(tension=1.0)
    with pytest.raises(cppr.CommandError, match="no load"):
        eq.continue_path(load_factor=2.0)
    with pytest.raises(cppr.CommandError, match="not both"):
        eq.continue_path(pull=2e-3, load_factor=2.0)
    with pytest.raises(cppr.CommandError, match="Check the unit"):
        eq.continue_path(pull=5)


def test_a_sweep_agrees_with_solves(tmp_path: Path) -> None:
    robot = cppr.Robot.from_toml("robots/r1.toml")
    counts = cppr.sweep(
        "robots/r1.toml", tmp_path / "r1.npz", pull=cppr.Range(-4e-3, 4e-3, 5), rotate=0.2,
        tip_force=(0, cppr.Range(0, 0.1, 3), 0.01), margin=True, limits="rigid",
    )  # fmt: skip
    assert counts == {"converged": 15}
    table = np.load(tmp_path / "r1.npz")
    many = robot.solve_many(
        pull=np.linspace(-4e-3, 4e-3, 5), rotate=0.2,
        tip_force=np.stack([np.zeros(3), np.linspace(0, 0.1, 3), np.full(3, 0.01)], axis=-1)[:, None],
        margin=True,
    )  # fmt: skip
    assert np.abs(table["tip_y_m"] - many.tip_position[..., 1].ravel()).max() < 1e-9
    assert np.abs(table["margin_to_instability"] - many.margin.ravel()).max() < 1e-6
    assert (table["tube2_rotation_rad"].round(9) == 0.2).all() and "closure_utilisation" in table.files


def test_all_formats_hold_the_same_table(tmp_path: Path) -> None:
    for ending in ("csv", "npz", "parquet"):
        counts = cppr.sweep(
            "robots/r1.toml", tmp_path / f"t.{ending}", pull=cppr.Range(0, 0.2, 400), margin=True, limits="rigid",
            settings=cppr.Settings(planar=True),
        )  # fmt: skip
    assert counts["converged"] > 200 and counts["invalid_command"] == 100
    parquet = pyarrow.parquet.read_table(tmp_path / "t.parquet")
    csv = pd.read_csv(tmp_path / "t.csv", comment="#")
    pd.testing.assert_frame_equal(
        parquet.to_pandas().replace({None: np.nan}), csv, check_exact=True, check_dtype=False
    )
    is_null = parquet["tip_x_m"].is_null().to_numpy()
    assert (is_null == ~csv.status_text.isin(["converged", "unstable"])).all() and is_null.any()
    table = np.load(tmp_path / "t.npz")
    # Whole numbers have no NaN: where there is none they are 0, which is no number of steps, tube or notch.
    whole = {name for name in table.files if table[name].dtype.kind == "i"}
    assert {"newton_steps", "strain_tube", "closure_tube", "closure_notch"} <= whole
    for name in whole:
        assert (table[name] == csv[name].fillna(0)).all(), name
    reasons = json.loads(bytes(table["reasons"]))
    assert reasons == {str(row): text for row, text in csv.reason.dropna().items()} and reasons
    for name in set(table.files) - {"metadata", "reasons"} - whole:
        assert np.array_equal(table[name], csv[name], equal_nan=True), name
    description = parquet.schema.metadata[b"cppr"]
    assert description == table["metadata"].tobytes() and json.loads(description)["schema"] == "cppr/sweep"


def test_designs_vary_in_samples(tmp_path: Path) -> None:
    counts = cppr.sweep(
        "robots/r1.toml", tmp_path / "depth.csv", pull=4e-3, samples=20, seed=3,
        vary={"tube1.notches.depth_mm": cppr.Normal(5.0, 0.05)},
    )  # fmt: skip
    assert counts == {"converged": 20}
    table = pd.read_csv(tmp_path / "depth.csv", comment="#")
    depth = table["input_tube1.notches.depth_mm"]
    assert abs(depth.mean() - 5) < 0.03 and 0.02 < depth.std() < 0.08
    assert np.corrcoef(depth, table["tip_y_m"])[0, 1] ** 2 > 0.9


def test_an_interrupted_sweep_goes_on(tmp_path: Path) -> None:
    arguments = {"pull": cppr.Range(-6e-3, 6e-3, 3000), "rotate": cppr.Range(-0.5, 0.5, 40)}
    output = tmp_path / "long.npz"
    seen: list[int] = []

    def progress(done: int, total: int) -> None:
        assert total == 120_000
        seen.append(done)
        if done > 0 and len(seen) > 3:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        cppr.sweep("robots/r1.toml", output, **arguments, settings=cppr.Settings(), progress=progress)
    assert not output.exists() and 0 < seen[-1] < 120_000
    with pytest.raises(OSError, match="resume"):
        cppr.sweep("robots/r1.toml", output, **arguments)
    kept = seen[-1]
    seen.clear()

    def again(done: int, total: int) -> None:
        seen.append(done)
        if done > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cppr.sweep("robots/r1.toml", output, **arguments, resume=True, progress=again)
    # What was solved before is not solved again.
    assert next(done for done in seen if done > 0) >= kept


def test_sweeps_that_cannot_be(tmp_path: Path) -> None:
    r1, out = "robots/r1.toml", tmp_path / "a.npz"
    with pytest.raises(ValueError, match="has a count in a grid"):
        cppr.sweep(r1, out, pull=cppr.Range(0, 1e-3))
    with pytest.raises(cppr.CommandError):
        cppr.sweep(r1, out, pull=1e-3)
    with pytest.raises(cppr.CommandError, match="depth"):
        cppr.sweep(r1, out, vary={"tube1.depth": cppr.Range(1, 2, 2)})
    with pytest.raises(ValueError, match="written as .csv, .npz or .parquet"):
        cppr.sweep(r1, tmp_path / "a.txt", pull=cppr.Range(0, 1e-3, 2))
    with pytest.raises(cppr.RobotError, match="cannot be read"):
        cppr.sweep("none.toml", out, pull=cppr.Range(0, 1e-3, 2))
    with pytest.raises(TypeError, match="must be a Range or a Normal"):
        cppr.sweep(r1, out, vary={"length_mm": 3.0})
