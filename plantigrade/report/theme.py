"""Colours and names that every picture, plot and page shares.

Left and right keep one colour each everywhere: blue for right, vermilion for left (Okabe and Ito's
palette, told apart by people with any common form of colour blindness).
"""

RIGHT = "#0072b2"
LEFT = "#d55e00"
MIDDLE = "#6b7280"
RECORDED = "#009e73"
FITTED = "#cc79a7"
REFERENCE = "#7e57c2"
FORCE = "#e0a100"
SIDE_NAMES = {"r": "right", "l": "left"}
SIDE_COLOURS = {"r": RIGHT, "l": LEFT}


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
    """Return ``name`` without its side word.

    Example:
        >>> without_side("knee_angle_r"), without_side("hip_flexion_l_moment")
        ('knee_angle', 'hip_flexion_moment')
    """
    parts = name.split("_")
    kept = [part for part in parts if part.lower() not in ("r", "l", "right", "left")]
    return "_".join(kept) or name


def colour_of(name: str) -> str:
    """Return the colour of the side that ``name`` belongs to."""
    return SIDE_COLOURS.get(side_of(name) or "", MIDDLE)


TITLES = {
    "pelvis_tilt": "Pelvis tilt",
    "pelvis_list": "Pelvis obliquity",
    "pelvis_rotation": "Pelvis rotation",
    "pelvis_tx": "Pelvis forward",
    "pelvis_ty": "Pelvis height",
    "pelvis_tz": "Pelvis sideways",
    "hip_flexion": "Hip flexion",
    "hip_adduction": "Hip adduction",
    "hip_rotation": "Hip internal rotation",
    "knee_angle": "Knee flexion",
    "ankle_angle": "Ankle dorsiflexion",
    "subtalar_angle": "Subtalar inversion",
    "mtp_angle": "Toe dorsiflexion",
    "lumbar_extension": "Trunk extension",
    "lumbar_bending": "Trunk side bending",
    "lumbar_rotation": "Trunk rotation",
    "arm_flex": "Shoulder flexion",
    "arm_add": "Shoulder adduction",
    "arm_rot": "Shoulder rotation",
    "elbow_flex": "Elbow flexion",
    "pro_sup": "Forearm pronation",
    "wrist_flex": "Wrist flexion",
    "wrist_dev": "Wrist deviation",
    "fingers_flex": "Finger flexion",
    "neck_bending": "Neck side bending",
    "mtp4_angle": "Outer toes dorsiflexion",
    "ground_force_up": "Ground force, vertical",
    "ground_force_forward": "Ground force, forward",
    "ground_force_sideways": "Ground force, sideways",
}


def title_of(name: str) -> str:
    """Return the words a reader sees for coordinate ``name``, side left out.

    Example:
        >>> title_of("knee_angle_r"), title_of("hip_flexion_l_moment"), title_of("neck_extension")
        ('Knee flexion', 'Hip flexion moment', 'Neck extension')
    """
    base = without_side(name)
    for ending in ("_moment", "_power", "_force"):
        if base.endswith(ending):
            return f"{title_of(base.removesuffix(ending))} {ending[1:]}"
    return TITLES.get(base, base.replace("_", " ").strip().capitalize())
