"""What documentation and examples say works, as a newcomer would run it."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

import cppr

PAGES = ["README.md", "docs/src/python.md", "docs/src/own-robot.md", "docs/src/control-loop.md"]


def blocks(page: str) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.MULTILINE | re.DOTALL)


def run(code: list[str], folder: Path) -> str:
    for name in ("robots", "examples"):
        (folder / name).symlink_to(ROOT / name)
    found = subprocess.run(
        [sys.executable, *code], cwd=folder, env={"MPLBACKEND": "Agg", "PATH": "/usr/bin:/bin"},
        capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    assert not found.stderr, found.stderr
    return found.stdout


@pytest.mark.parametrize("page", PAGES)
def test_blocks_of_documentation_run(page: str, tmp_path: Path) -> None:
    """All blocks of a page in one process, from top to bottom."""
    own = blocks(page)
    assert own
    run(["-c", "\n".join(own)], tmp_path)


def numbers(output: str, pattern: str) -> list[float]:
    found = re.search(pattern, output)
    assert found, f"{pattern} is missing in\n{output}"
    return [float(group) for group in found.groups()]


def test_first_robot(tmp_path: Path) -> None:
    output = run(["examples/python/first_robot.py"], tmp_path)
    assert "converged; tip (125.331, -70.518, 0.000) mm" in output
    assert {p.name for p in tmp_path.glob("first_robot*")} == {
        "first_robot.png", "first_robot.html", "first_robot_range.png",
    }  # fmt: skip


def test_calibration_of_r1_and_r2(tmp_path: Path) -> None:
    """The data were made with a factor of 1.22, 4.8 GPa and noise of 0.5 mm."""
    output = run(["examples/python/calibrate.py"], tmp_path)
    factor, half = numbers(output, r"centroid_offset_factor: (\S+) ± (\S+)")
    assert abs(factor - 1.22) < half
    modulus, half = numbers(output, r"youngs_modulus: (\S+) ± (\S+)")
    assert abs(modulus - 4.8e9) < half
    # A combination has no sign.
    assert re.search(r"without loads: the data cannot see the combination [+-]1.00 youngs_modulus", output)
    for robot in ("R1", "R2"):
        before, after = numbers(
            output, rf"{robot} as designed: rms distance (\S+) mm\n{robot} calibrated: rms distance (\S+)"
        )
        assert after < 1.1 and before > 1.5 * after


def test_tip_tracking(tmp_path: Path) -> None:
    output = run(["examples/python/tip_tracking.py"], tmp_path)
    (error,) = numbers(output, r"tracking at 200 Hz: error (\S+) mm")
    assert error < 0.05
    (rate,) = numbers(output, r"up to (\S+) Hz")
    assert rate > 200


def test_own_robot_notebook(tmp_path: Path) -> None:
    """All cells in one process, from top to bottom; what a cell ends with is shown as a notebook shows it."""
    book = json.loads((ROOT / "examples/python/own_robot.ipynb").read_text())
    cells = ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 9 and not any(cell.get("outputs") for cell in book["cells"])
    # The last line of a cell is shown.
    shown = []
    for cell in cells:
        *body, last = ast.parse(cell).body
        if isinstance(last, ast.Expr):
            value = ast.unparse(last)
            shown.append("\n".join(map(ast.unparse, body)) + f"\nprint(repr({value}))\n")
        else:
            shown.append(cell + "\n")
    output = run(["-c", "".join(shown)], tmp_path)
    (difference,) = numbers(output, r"np\.float64\((\S+)\)\n")
    assert difference < 1e-9
    (moved,) = numbers(output, r"the tip moves by (\S+) of the length")
    assert moved < 1e-4
    assert "Limits: " in output and "[[tube]] # the leader" in output
    # A notebook shows the limits in a few lines.
    assert len(output.split("Limits: ")[1].split("the tip moves")[0].splitlines()) <= 4
    again = cppr.Robot.from_toml(tmp_path / "mine.toml").solve(pull=1e-3).tip_position
    assert abs(again - cppr.Robot.from_toml(ROOT / "examples/mine.toml").solve(pull=1e-3).tip_position).max() < 1e-9


def test_control_loop(tmp_path: Path) -> None:
    """Times depend on what else runs here and are not judged; the force that is found and the way of the tip are."""
    output = run(["examples/python/control_loop.py"], tmp_path)
    (error,) = numbers(output, r"tip at most (\S+) mm from the nearest place")
    assert error < 0.3
    found, noise = numbers(output, r"force sensed to (\S+) N \(standard deviation (\S+) N\)")
    assert found < 0.02 and noise < 0.02
    assert re.search(r"controller: \S+ ms median, \S+ ms in 99 of 100 cycles, \S+ ms at most", output)
    assert re.search(r"cycles begin late by \S+ us median, \S+ us in 99 of 100", output)


def test_notch_design(tmp_path: Path) -> None:
    output = run(["examples/python/notch_design.py"], tmp_path)
    start, designed = numbers(output, r"start: rms .* curve (\S+) mm\ndesigned: rms .* curve (\S+) mm")
    assert designed < 0.1 * start
