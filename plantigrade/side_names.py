"""Sides in names of bodies, joints, coordinates and landmarks: ``_r`` and ``_l``."""


def split_side(name: str) -> tuple[str, str]:
    """Return a name without its side suffix, and the side (``"r"``, ``"l"`` or ``""``).

    Example:
        >>> split_side("knee_angle_r"), split_side("lumbar_extension")
        (('knee_angle', 'r'), ('lumbar_extension', ''))
    """
    return (name[:-2], name[-1]) if name[-2:] in ("_r", "_l") else (name, "")


def opposite(side: str) -> str:
    """Return the other of ``"r"`` and ``"l"``."""
    return {"r": "l", "l": "r"}[side]


def side_of(name: str) -> str | None:
    """Return ``"r"`` or ``"l"`` of a body, joint or marker-like ``name``; None for the middle.

    Example:
        >>> side_of("knee_angle_r"), side_of("lumbar_extension"), side_of("calcn_l_moment")
        ('r', None, 'l')
    """
    parts = name.lower().replace("/", "_").replace("-", "_").split("_")
    for word, side in (("r", "r"), ("l", "l"), ("right", "r"), ("left", "l")):
        if word in parts:
            return side
    return None


def without_side(name: str) -> str:
    """Return ``name`` without its side, wherever in it that is.

    Example:
        >>> without_side("knee_angle_r"), without_side("hip_flexion_l_moment")
        ('knee_angle', 'hip_flexion_moment')
    """
    parts = name.split("_")
    kept = [part for part in parts if part.lower() not in ("r", "l", "right", "left")]
    return "_".join(kept) or name
