"""Labels of coordinates in plots: titles, sides, meaning of positive and negative values."""

COORDINATES = {  # title, and what positive and negative mean, short enough for an axis
    "pelvis_tilt": ("Pelvis tilt", "back", "forward"),
    "pelvis_list": ("Pelvis obliquity", "left up", "right up"),
    "pelvis_rotation": ("Pelvis rotation", "to left", "to right"),
    "pelvis_tx": ("Pelvis forward", "", ""),
    "pelvis_ty": ("Pelvis height", "", ""),
    "pelvis_tz": ("Pelvis sideways", "", ""),
    "hip_flexion": ("Hip flexion", "flex.", "ext."),
    "hip_adduction": ("Hip adduction", "add.", "abd."),
    "hip_rotation": ("Hip internal rotation", "internal", "external"),
    "knee_angle": ("Knee flexion", "flex.", "ext."),
    "ankle_angle": ("Ankle dorsiflexion", "dorsi", "plantar"),
    "ankle_dorsiflexion": ("Shank to metatarsals", "dorsi", "plantar"),
    "hip_adduction_thigh": ("Hip adduction by thigh markers", "add.", "abd."),
    "hip_rotation_thigh": ("Hip rotation by thigh markers", "internal", "external"),
    "knee_adduction_markers": ("Knee adduction by markers", "varus", "valgus"),
    "knee_rotation_markers": ("Knee rotation by markers", "internal", "external"),
    "subtalar_angle": ("Subtalar inversion", "inv.", "ev."),
    "foot_progression": ("Foot progression", "in", "out"),
    "mtp_angle": ("Toe dorsiflexion", "up", "down"),
    "lumbar_extension": ("Trunk extension", "ext.", "flex."),
    "lumbar_bending": ("Trunk side bending", "to right", "to left"),
    "lumbar_rotation": ("Trunk rotation", "to left", "to right"),
    "arm_flex": ("Shoulder flexion", "flex.", "ext."),
    "arm_add": ("Shoulder adduction", "add.", "abd."),
    "arm_rot": ("Shoulder rotation", "internal", "external"),
    "elbow_flex": ("Elbow flexion", "flex.", "ext."),
    "pro_sup": ("Forearm pronation", "pron.", "sup."),
    "wrist_flex": ("Wrist flexion", "flex.", "ext."),
    "wrist_dev": ("Wrist deviation", "ulnar", "radial"),
    "fingers_flex": ("Finger flexion", "", ""),
    "neck_bending": ("Neck side bending", "to right", "to left"),
    "mtp4_angle": ("Outer toes dorsiflexion", "", ""),
    "ground_force_up": ("Ground force, vertical", "", ""),
    "ground_force_forward": ("Ground force, forward", "pushes", "brakes"),
    "ground_force_sideways": ("Ground force, sideways", "left", "right"),
    "neck_extension": ("Neck extension", "ext.", "flex."),
    "neck_rotation": ("Neck rotation", "to left", "to right"),
}
SPAN = {"°": 10.0, "N m": 10.0, "N m/kg": 0.2, "W/kg": 0.2, "BW": 0.1}
"""Minimum span of the vertical axis, by unit; a smaller one would magnify noise."""


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
    """Return ``name`` without its side.

    Example:
        >>> without_side("knee_angle_r"), without_side("hip_flexion_l_moment")
        ('knee_angle', 'hip_flexion_moment')
    """
    parts = name.split("_")
    kept = [part for part in parts if part.lower() not in ("r", "l", "right", "left")]
    return "_".join(kept) or name


def title_of(name: str) -> str:
    """Return the title of the coordinate ``name``, without its side.

    Example:
        >>> title_of("knee_angle_r"), title_of("hip_flexion_l_moment"), title_of("neck_extension")
        ('Knee flexion', 'Hip flexion moment', 'Neck extension')
    """
    base = without_side(name)
    for ending in ("_moment", "_power", "_force"):
        if base.endswith(ending):
            return f"{title_of(base.removesuffix(ending))} {ending[1:]}"
    return COORDINATES.get(base, (base.replace("_", " ").strip().capitalize(),))[0]


def axis_label(base: str, unit: str) -> str:
    """Return the label of the vertical axis, with the meaning of its ends if known."""
    _, up, down = COORDINATES.get(base.removesuffix("_moment"), ("", "", ""))
    if base.endswith("_power"):
        up, down = "gives", "takes"
    return f"{down} ← [{unit}] → {up}" if up else f"[{unit}]"
