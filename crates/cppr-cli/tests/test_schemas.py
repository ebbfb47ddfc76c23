"""Every output in JSON against the schema that is published with the book: nothing missing, nothing undescribed, and nothing
described that no output has. The program is target/release/cppr."""

from __future__ import annotations

import copy
import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

ROOT = Path(__file__).parents[3]
SCHEMAS = ROOT / "docs/src/schemas"

# Commands that together show every key of a schema.
COMMANDS = {
    "solve": [
        "robots/childs3.toml --pull 2=1mm --tension 3=-0.5N --torque 2=1Nmm --tip-force 0,0,-0.5N --samples 3",
        "robots/r3.toml --pull -4mm --gravity 0,0,-1g --thread 0.1962N:150,-24,0mm --distributed 0..100mm:0,-1,0N/m --samples 2",
        "robots/r1.toml --pull 140mm --samples 2",
        "robots/r3.toml --pull 149mm",
        "robots/r3.toml --pull -5mm --tip-force -2,0,0N --samples 2",
        "robots/r1.toml --pull 1mm --formulation printed --samples 2",
        "robots/r1.toml --pull 3mm --friction 0.2 --guide 20mm --contact --samples 2",
        "robots/r1.toml --pull 3mm --clearance 0.2mm --samples 2",
        "robots/helicoid.toml --pull 5mm --clearance radii --samples 2",
        "robots/r1.toml --pull 3mm --clearance 0.2mm --guide 20mm --guide-gap 0.1mm --samples 2",
        "crates/cppr-cli/tests/data/folds_on_the_way.toml --pull 2=0.02310248mm --pull 3=-0.08407234mm --rotate 3=14.037675deg --refine 4 --samples 2",
    ],
    "cycle": [
        "robots/r1.toml --pull 0..1..0..1mm --friction 0.2 --steps 3",
        "robots/r1.toml --pull 1mm --rotate 0..10deg --friction 0.2 --guide 20mm --steps 2",
    ],
    "continue": [
        "robots/childs3.toml --along rotate=3 --to 180deg --pull 2=1mm",
        "robots/r3.toml --along load --to 2 --pull -5mm --tip-force -1,0,0N --branches",
        "robots/childs3.toml --along tension=2 --to 1N --torque 2=0Nmm --distributed 0..10mm:0,1,0N/m --thread 0.1N:30,-24,0mm",
    ],
    "limits": [
        "robots/r4.toml --pull -4mm",
        "robots/childs3.toml",
        "robots/r1.toml --pull 140mm",
        "robots/r1.toml --clearance 0.2mm",
    ],
    "reach": [
        "robots/r4.toml --direction 0.7,0.7,0 --rotate 0deg --tip-force 0,-0.05,0N",
        "robots/r1.toml --position 100,100,100mm --rotate-bounds -90..90deg",
        "robots/r1.toml --position 128,-58.3,0mm --rotate 0deg --pull-bounds 0..6mm --friction 0.2",
    ],
    "match": ["robots/r3.toml --points examples/shapes/r3.csv --rotate 0deg"],
    "sense": [
        "robots/r1.toml --pull 5mm --rotate 20deg --measured-tension 5.07N --measured-torque 3.8Nmm"
        " --measured-position 120.9,-65.5,-2mm --measured-direction 0.37,-0.93,-0.04",
        "robots/r1.toml --pull 5mm --measured-tension 5.2N --measured-position 120.3,-66.6,0mm --friction 0.2",
    ],
    "derivatives": [
        "robots/childs3.toml --pull 2=1mm --tension 3=-2N --by tube3.stiffness.centroid_offset_mm"
    ],
    "calibrate": [
        "robots/r1.toml --data {folder}/directions.csv --fit centroid_offset_factor",
        "robots/bundles/concentric3.toml --data examples/calibration/concentric3.csv --fit rest_curvature_factor",
        "robots/r1.toml --data {folder}/efforts.csv --fit youngs_modulus,friction",
        "robots/r1.toml --data {folder}/efforts.csv --friction 0.1",
    ],
    "section": ["robots/r3.toml --samples 3", "robots/childs3.toml --samples 2"],
    "cell": ["robots/r1.toml --tube 1 --corner-radius 1mm"],
    "check": ["robots/r3.toml robots/helicoid.toml robots/bundles/hybrid.toml {folder}/wrong.toml {folder}/missing.toml"],
    "sweep": [
        "robots/r3.toml --pull 0..149mm:3 --output {folder}/poses.csv",
        "robots/r1.toml --pull 4mm --vary tube1.notches.depth_mm=normal(5,0.05) --samples 8 --output {folder}/tolerance.csv",
        "robots/bundles/two_sections.toml --pull 2=0..1mm:2 --pull 4=0..200mm:2 --output {folder}/sections.npz",
    ],
    "export": [
        "robots/r1.toml --tube 1 --output {folder}/tube.stl",
        "robots/r1.toml --tube 1 --kerf 20um --output {folder}/cuts.dxf",
        "robots/r1.toml --pull 5mm --output {folder}/bent.glb",
    ],
}

# Robots with parts or joints have schemas of their own.
BUNDLES = {
    "bundle": [
        "solve robots/bundles/hybrid.toml --pull 2=1mm --rotate 3=90deg --samples 3",
        "solve robots/bundles/s_shape.toml --pull 2=60mm",
        "solve robots/bundles/uncut_ends.toml --rotate 6000deg --samples 3",
        "solve robots/bundles/two_sections.toml --pull 2=1mm --friction 0.1 --contact --samples 3",
        "solve robots/wrists/superelastic.toml --tension 2=0.5N --hysteresis --samples 2",
        "solve robots/bundles/s_shape.toml --pull 5mm --clearance 0.1mm --samples 3",
        "solve robots/bundles/concentric3.toml --rotate 3=60deg --clearance radii --samples 3",
        "solve robots/wrists/superelastic.toml --pull 2=0.2mm --clearance 0.05mm --samples 2",
    ],
    "bundle-continue": [
        "continue robots/bundles/two_curved.toml --along rotate=2 --to 360deg",
        "continue robots/bundles/two_sections.toml --along load --from 16 --to 17.3 --tip-force -1,0,0N --branches --points 20",
    ],
    "bundle-derivatives": [
        "derivatives robots/bundles/s_shape.toml --pull 1mm --torque 2=1Nmm --by tube2.part1.stiffness.bending_z_Nmm2"
    ],
}


def cppr(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([ROOT / "target/release/cppr", *arguments], cwd=ROOT, capture_output=True, text=True)


def output(*arguments: str) -> Any:
    """What a command writes as JSON, whatever its exit code."""
    done = cppr(*arguments, "--json", "-")
    assert done.stdout.startswith("{"), f"{arguments}: {done.stderr}"
    return json.loads(done.stdout)


def published(name: str) -> dict[str, Any]:
    schema = json.loads((SCHEMAS / f"{name}.schema.json").read_text())
    Draft202012Validator.check_schema(schema)
    return schema


def strict(schema: Any) -> Any:
    """The published schemas let new keys come; here none may go undescribed."""
    if isinstance(schema, dict):
        own = {key: strict(value) for key, value in schema.items()}
        return {"additionalProperties": False, **own} if "properties" in own else own
    return [strict(value) for value in schema] if isinstance(schema, list) else schema


def described(schema: Any) -> set[str]:
    """Keys that a schema describes."""
    if isinstance(schema, dict):
        return set(schema.get("properties", ())).union(*map(described, schema.values()))
    return set().union(*map(described, schema)) if isinstance(schema, list) else set()


def present(value: Any) -> set[str]:
    """Keys that an output has."""
    if isinstance(value, dict):
        return set(value).union(*map(present, value.values()))
    return set().union(*map(present, value)) if isinstance(value, list) else set()


def check(name: str, outputs: list[Any]) -> None:
    schema = published(name)
    validator = Draft202012Validator(strict(schema))
    for own in outputs:
        errors = [f"{error.json_path}: {error.message[:200]}" for error in validator.iter_errors(own)]
        assert not errors, errors
    stale = described(schema) - present(outputs)
    assert not stale, f"no output has {stale}"


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the commands need beside what is shipped: a robot that is wrong, and measurements with a direction."""
    place = tmp_path_factory.mktemp("schemas")
    robot = (ROOT / "robots/r1.toml").read_text()
    wrong = robot.replace("length_mm = 150.0", "length = 150.0")
    assert wrong != robot
    (place / "wrong.toml").write_text(wrong)
    rows = ["robot,pull2_mm,x_mm,y_mm,z_mm,direction_x,direction_y,direction_z"]
    for pull in (2, 4, 6):
        found = output("solve", "robots/r1.toml", "--pull", f"{pull}mm")
        tip = [v * 1e3 + 0.1 * (-1) ** pull for v in found["tip_position_m"]]
        rows.append(",".join(map(str, ["R1", pull, *tip, *(row[0] for row in found["tip_rotation"])])))
    (place / "directions.csv").write_text("\n".join(rows) + "\n")
    rows = ["pull2_mm,driven,measured_tension2_N,measured_torque2_Nmm,bend_deg,sigma_N"]
    rows += [f"{pull},{way},{force},0,{10 * pull},0.01" for pull, way, force in ((2, "on", 1.9), (4, "on", 3.9), (4, "back", 3.4))]
    (place / "efforts.csv").write_text("\n".join(rows) + "\n")
    return place


@pytest.mark.parametrize("name", COMMANDS)
def test_outputs_are_as_their_schema_says(name: str, folder: Path) -> None:
    check(name, [output(name, *line.format(folder=folder).split()) for line in COMMANDS[name]])


@pytest.mark.parametrize("name", BUNDLES)
def test_outputs_of_bundles_are_as_their_schema_says(name: str) -> None:
    check(name, [output(*line.split()) for line in BUNDLES[name]])


def test_the_numbers_of_the_report_are_as_their_schema_says(tmp_path: Path) -> None:
    done = cppr("paper", "--only", "differences", "--output", str(tmp_path / "report"))
    assert done.returncode == 0, done.stderr
    check("paper", [json.loads((tmp_path / "report/numbers.json").read_text())])


def test_what_is_wrong_is_found() -> None:
    validator = Draft202012Validator(strict(published("check")))
    sound = output("check", "robots/r3.toml")
    assert validator.is_valid(sound)
    for place, key, value in [
        ([], "schema", "cppr/other"),
        ([], "schema_version", 2),
        (["files", 0, "robot"], "length_m", "150 mm"),
        (["files", 0, "robot"], "new", 1),
        (["files", 0], "problems", None),
    ]:
        wrong = copy.deepcopy(sound)
        inner = wrong
        for step in place:
            inner = inner[step]
        inner[key] = value
        assert not validator.is_valid(wrong), (place, key)


def test_every_output_has_a_schema() -> None:
    """A sub-command with --json has a schema, and a schema belongs to one."""
    commands = cppr("--help").stdout.split("Commands:\n")[1].split("\n\n")[0].splitlines()
    names = {line.split()[0] for line in commands} - {"help"}
    assert len(names) > 12
    writes = {name for name in names if "--json <FILE>" in cppr(name, "--help").stdout}
    # The JSON of the report is one of its files.
    assert {path.name.split(".")[0] for path in SCHEMAS.iterdir()} == writes | {"paper", *BUNDLES}
    assert set(COMMANDS) == writes
