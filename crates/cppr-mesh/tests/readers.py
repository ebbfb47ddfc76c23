"""Files of `cppr export` in trimesh and ezdxf; the folder is the argument."""

import math
import sys
import tomllib
from pathlib import Path

import ezdxf
import numpy as np
import trimesh

FOLDER = Path(sys.argv[1])
ROBOTS = Path(__file__).parents[3] / "robots"


def bodies(path):
    """Meshes of a file in mm, equal vertices made one."""
    scene = trimesh.load_scene(path, process=False)
    unit = 1e3 if path.suffix in (".glb", ".gltf") else 1.0
    for mesh in scene.geometry.values():
        mesh = trimesh.Trimesh(mesh.vertices * unit, mesh.faces, process=False)
        mesh.merge_vertices(digits_vertex=None if path.suffix == ".stl" else 7)
        yield from mesh.split(only_watertight=False)


def check_body(body, what):
    assert body.is_watertight and body.is_winding_consistent and body.volume > 0, what
    # A tube with notches that reach through its wall, in one piece: genus from Euler's number.
    assert body.body_count == 1 and body.euler_number % 2 == 0, what


def kept_area(outer, inner, depth):
    """Area of a round section beyond the cut: segments of two disks, in closed form."""

    def segment(radius):
        alpha = np.clip((depth - outer) / radius, -1, 1)
        return radius**2 * (np.arccos(alpha) - alpha * np.sqrt(1 - alpha**2))

    return segment(outer) - segment(inner)


def design_volume(name, tube):
    """Integral of the section area of a shipped robot's tube in mm³."""
    robot = tomllib.loads((ROBOTS / f"{name}.toml").read_text())
    tube, length = robot["tube"][tube - 1], robot["length_mm"]
    outer, inner = tube["outer_radius_mm"], tube["inner_radius_mm"]
    notch, tooth = tube["notches"]["length_mm"], tube["notches"]["tooth_mm"]
    base, tip = np.broadcast_to(tube["notches"]["depth_mm"], 2)
    x = (np.arange(150_000) + 0.5) * length / 150_000
    cell = x % (notch + tooth) - tooth / 2
    depth = np.where((cell > 0) & (cell < notch), base + (tip - base) * x / length, 0)
    return length * kept_area(outer, inner, depth).mean()


def check_tubes():
    for name in ("r1", "r2", "r3", "r4", "helicoid"):
        for tube in (1, 2):
            want = design_volume(name, tube)
            for ending in ("stl", "3mf", "glb"):
                path = FOLDER / f"{name}-{tube}.{ending}"
                (body,) = bodies(path)
                check_body(body, path)
                assert abs(body.volume / want - 1) < 1e-3, (path, body.volume, want)
                assert np.allclose(body.bounds[:, 0], [0, 150], atol=1e-4), path


def check_additions():
    (body,) = bodies(FOLDER / "dressed.3mf")
    check_body(body, "dressed.3mf")
    assert np.allclose(body.bounds, [[-32, -8, -8], [151, 8, 8]], atol=1e-6), body.bounds
    additions = 2 * math.pi * (8**2 - 2.4**2) + math.pi * 3.2**2 + 30 * math.pi * (3.2**2 - 2.4**2)
    assert abs(body.volume / (design_volume("r3", 2) + additions) - 1) < 1e-3


def check_assemblies():
    for name in ("bent", "wound"):
        volumes = []
        for ending in ("stl", "3mf", "obj", "glb", "gltf"):
            found = list(bodies(FOLDER / f"{name}.{ending}"))
            assert len(found) == 2, (name, ending, len(found))
            for body in found:
                check_body(body, (name, ending))
            volumes.append(sorted(body.volume for body in found))
        assert np.allclose(volumes, volumes[0], rtol=1e-5), volumes


def check_parts():
    """The outer tube of a robot with an uncut shaft of 30 mm and an uncut tip of 5 mm, its 100 notches between them."""
    (body,) = bodies(FOLDER / "uncut_ends-1.stl")
    check_body(body, "uncut_ends-1.stl")
    assert np.allclose(body.bounds, [[0, -1, -1], [115, 1, 1]], atol=1e-4), body.bounds
    want = 65 * kept_area(1, 0.9, 0) + 50 * kept_area(1, 0.9, 1.6)
    assert abs(body.volume / want - 1) < 1e-3, (body.volume, want)
    cuts = [e for e in ezdxf.readfile(FOLDER / "uncut_ends-1.dxf").modelspace() if e.dxf.layer == "CUT"]
    along = np.array([[point[0] for point in cut.get_points()] for cut in cuts])
    assert len(cuts) == 100 and along.min() > 30 and along.max() < 110, (along.min(), along.max())
    for name, tubes in (("advanced", 2), ("hybrid", 3)):
        found = list(bodies(FOLDER / f"{name}.glb"))
        assert len(found) == tubes, (name, len(found))
        for body in found:
            check_body(body, name)


def check_patterns():
    files = [f"{name}-{tube}.dxf" for name in ("r1", "r2", "r3", "r4", "helicoid") for tube in (1, 2)]
    for name in [*files, "kerf.dxf"]:
        drawing = ezdxf.readfile(FOLDER / name)
        audit = drawing.audit()
        # The library leaves out the handles of tables, which every reader makes up for.
        repairs = [e for e in audit.fixes if not e.message.startswith("Fixed invalid table head handle")]
        assert not audit.errors and not repairs, (name, audit.errors, repairs)
        assert drawing.header["$INSUNITS"] == 4, "millimetres"
        lines = list(drawing.modelspace())
        assert all(line.dxftype() == "LWPOLYLINE" and line.closed for line in lines)
        layers = [line.dxf.layer for line in lines]
        assert layers.count("OUTLINE") == 1 and layers.count("CUT") == 15, (name, layers)


check_tubes()
check_additions()
check_assemblies()
check_parts()
check_patterns()
print("trimesh and ezdxf read every file")
