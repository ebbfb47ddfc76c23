"""What documentation and examples say works, as a newcomer would run it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

PAGES = ["README.md", "docs/src/python.md", "docs/src/own-robot.md"]


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


def test_notch_design(tmp_path: Path) -> None:
    output = run(["examples/python/notch_design.py"], tmp_path)
    start, designed = numbers(output, r"start: rms .* curve (\S+) mm\ndesigned: rms .* curve (\S+) mm")
    assert designed < 0.1 * start
