"""Left and right: names and coordinates of the mirror image of a person."""

LATERAL = ("pelvis_list", "pelvis_rotation", "pelvis_tz")
"""Coordinates of the pelvis that change sign in the mirror."""


def mirrored_name(name: str) -> str:
    """Return the name on the other side; a name without side is its own.

    Example:
        >>> mirrored_name("knee_angle_r"), mirrored_name("pelvis_tx")
        ('knee_angle_l', 'pelvis_tx')
    """
    if name.endswith("_r"):
        return name[:-2] + "_l"
    if name.endswith("_l"):
        return name[:-2] + "_r"
    return name


def mirror_sign(coordinate: str) -> float:
    """Return -1 for a coordinate of pelvis, trunk or head that changes sign in the mirror."""
    lateral = coordinate in LATERAL or coordinate.endswith(("_bending", "_rotation"))
    return -1.0 if lateral else 1.0
