"""What documentation and examples say works, as a newcomer would run it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

PAGES = ["README.md", "docs/src/python.md"]


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
