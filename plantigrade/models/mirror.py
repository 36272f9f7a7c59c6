"""Left and right: names and coordinates of the mirror image of a person."""

TRUNK = ("pelvis_", "lumbar_", "thorax_", "lower_thorax_", "neck_", "lower_neck_", "upper_neck_")
LATERAL = ("_list", "_rotation", "_bending", "_tz")


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
    return -1.0 if coordinate.startswith(TRUNK) and coordinate.endswith(LATERAL) else 1.0
