"""Names and coordinates of the mirror image of a person."""

MIDLINE_PREFIXES = (
    "pelvis_",
    "lumbar_",
    "thorax_",
    "lower_thorax_",
    "neck_",
    "lower_neck_",
    "upper_neck_",
)
LATERAL_SUFFIXES = ("_list", "_rotation", "_bending", "_tz")


def mirrored_name(name: str) -> str:
    """Return the name for the other side; a name without side is unchanged.

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
    """Return -1 for a coordinate of pelvis, trunk or head that changes sign under mirroring."""
    return (
        -1.0
        if coordinate.startswith(MIDLINE_PREFIXES) and coordinate.endswith(LATERAL_SUFFIXES)
        else 1.0
    )
