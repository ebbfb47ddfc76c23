"""Draws exported files: tubes at rest above, the bent robot below. Arguments: STL files, then the GLB, then the picture."""

import sys

import pyvista

*tubes, bent, picture = sys.argv[1:]
COLOURS = ["#3b6ea5", "#d9541e"]
LOOK = {"smooth_shading": True, "split_sharp_edges": True, "feature_angle": 30, "specular": 0.2}

plotter = pyvista.Plotter(off_screen=True, shape=(2, 1), row_weights=[0.45, 1], window_size=(1200, 960), border=False)
plotter.enable_anti_aliasing("ssaa")


def aim(width, centre):
    """From the front, a little from above and from the tip; `width` of the picture in mm."""
    plotter.enable_parallel_projection()
    plotter.view_vector((0.25, 0.35, 1), viewup=(0, 1, 0))
    plotter.camera.focal_point = centre
    plotter.camera.parallel_scale = width
    plotter.reset_camera_clipping_range()


def scale_bar(start):
    """10 mm long, with its length below."""
    plotter.add_mesh(pyvista.Line(start, (start[0] + 10, *start[1:])), color="black", line_width=3)
    label = {"shape": None, "show_points": False, "always_visible": True, "font_size": 22, "text_color": "black"}
    below = (start[0] + 5, start[1] - 1, start[2])
    plotter.add_point_labels([below], ["10 mm"], justification_horizontal="center", justification_vertical="top", **label)


plotter.subplot(0, 0)
for row, (path, colour) in enumerate(zip(tubes, COLOURS)):
    plotter.add_mesh(pyvista.read(path).translate((0, -9 * row, 0)), color=colour, **LOOK)
scale_bar((0, -16, 0))
aim(21, (75, -5, 0))

plotter.subplot(1, 0)
meshes = [block for block in pyvista.read(bent).recursive_iterator() if block.n_cells]
for mesh, colour in zip(meshes, COLOURS):
    plotter.add_mesh(mesh.extract_surface(algorithm=None).scale(1000), color=colour, **LOOK)
scale_bar((-25, -80, 0))
aim(50, (47, -38, 0))

plotter.screenshot(picture)
