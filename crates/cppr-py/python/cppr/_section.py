"""Properties of one notched section."""

from __future__ import annotations

from typing import Literal, NamedTuple

from . import _cppr


class SectionProperties(NamedTuple):
    """About axes through the centroid unless said; Y along the centroid direction, Z normal to it."""

    area: float
    """A (m²)."""
    centroid_offset: float
    """D (m)."""
    inertia_y: float
    """I_Y, the stiff one (m⁴)."""
    inertia_z: float
    """I_Z, the soft one (m⁴)."""
    polar_about_centre: float
    """I_Y + I_Z + A D² (m⁴)."""
    torsion_constant: float
    """Saint-Venant's J_t (m⁴)."""


def section(
    outer_radius: float,
    inner_radius: float,
    depth: float,
    shape: Literal["round", "square", "hexagon"] = "round",
) -> SectionProperties:
    """Properties of a section of a tube notched to a depth (all m; half widths across flats for polygons).

    Raises `RobotError` where the dimensions describe no section.
    """
    return SectionProperties(*_cppr.section(outer_radius, inner_radius, depth, shape))
