"""Quantities of the check: key in ``metrics.json``, unit, wording and advice."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """Report of a quantity."""

    key: str  #: Its key in ``metrics.json``
    unit: str  #: Unit of its value and limit
    words: str  #: Sentence of a fault, with ``{where}``, ``{value}`` and ``{unit}``
    advice: str  #: Advice


_REFINE = "refine the mesh there"
_ROOT = (
    f"{_REFINE}, increase the weight of the accelerations, and make sure that contact changes only "
    "at nodes"
)
_HOLD = f"{_REFINE}, or constrain its velocity to zero at touchdown and lift-off"
_BEFORE = "let a site carry load at a node only if it stands before and after that node"
_SPLINE = "evaluate qpos, qvel and qacc from the same spline, and check on a finer grid"
_BW, _BWM = "% of body weight", "% of body weight times metre"
QUANTITY = {
    "root_force": Quantity(
        "check_root_force_max_bw_percent",
        _BW,
        "the residual force at the root is {value} % of body weight",
        _ROOT,
    ),
    "root_force_rms": Quantity(
        "check_root_force_rms_bw_percent",
        _BW,
        "the RMS residual force at the root is {value} % of body weight",
        "refine the mesh, or increase the weight of the accelerations",
    ),
    "root_moment": Quantity(
        "check_root_moment_max_bwm_percent",
        _BWM,
        "the residual moment at the root is {value} % of body weight times metre",
        _ROOT,
    ),
    "root_moment_rms": Quantity(
        "check_root_moment_rms_bwm_percent",
        _BWM,
        "the RMS residual moment at the root is {value} % of body weight times metre",
        "refine the mesh, or increase the weight of the accelerations",
    ),
    "slip": Quantity("check_slip_max_mm", "mm", "the {where} slips {value} mm", _HOLD),
    "slip_speed": Quantity(
        "check_slip_speed_max_m_s", "m/s", "the {where} slides at {value} m/s in stance", _HOLD
    ),
    "penetration": Quantity(
        "check_penetration_max_mm",
        "mm",
        "the {where} is {value} mm inside the ground",
        f"{_REFINE}, or require a clearance of that place",
    ),
    "hover": Quantity(
        "check_hover_max_mm",
        "mm",
        "the {where} should stand but is {value} mm above the ground",
        f"{_REFINE}, or plan its lift-off at another time",
    ),
    "friction": Quantity(
        "check_friction_ratio_max",
        "of its normal force",
        "the {where} needs friction of {value} of its normal force",
        "give the optimiser a smaller coefficient (a friction pyramid outside the cone exceeds it "
        "by up to √2 at its edges), move more slowly, or allow more friction",
    ),
    "adhesion": Quantity(
        "check_adhesion_max_bw_percent",
        _BW,
        "the ground pulls at the {where} with {value} % of body weight",
        "bound the normal force below by zero at every node",
    ),
    "pressure": Quantity(
        "check_pressure_outside_max_mm",
        "mm",
        "the centre of pressure of {where} is {value} mm outside the base of support",
        f"{_BEFORE}, and refine the mesh",
    ),
    "overlap": Quantity(
        "check_overlap_max_mm",
        "mm",
        "{where} is {value} mm deep",
        f"{_REFINE}, or add a term solid-limbs with a larger margin",
    ),
    "unsupported": Quantity(
        "check_unsupported_force_max_bw_percent",
        _BW,
        "the {where} carries {value} % of body weight although it does not stand",
        _BEFORE,
    ),
    "force": Quantity(
        "check_site_force_max_n",
        "N",
        "the {where} carries {value} N",
        "spread the load over more sites, land more softly, or allow more force",
    ),
    "coordinate": Quantity(
        "check_joint_limit_excess_max_deg",
        "deg",
        "{where} is {value} deg beyond its limit",
        f"{_REFINE}, or widen the range of the joint",
    ),
    "velocity": Quantity(
        "check_velocity_limit_use_max_percent",
        "% of its limit",
        "{where} turns at {value} {unit}",
        f"{_REFINE}, give the motion more time, or allow a higher speed",
    ),
    "torque": Quantity(
        "check_torque_limit_use_max_percent",
        "% of its limit",
        "{where} needs {value} {unit}",
        f"{_REFINE}, give the motion more time, or use a stronger joint",
    ),
    "velocity_mismatch": Quantity(
        "check_velocity_mismatch_max_percent",
        "% of its greatest speed",
        "the velocity of {where} is not the derivative of its position: it is off by {value} % of "
        "its greatest speed",
        _SPLINE,
    ),
    "acceleration_mismatch": Quantity(
        "check_acceleration_mismatch_max_percent",
        "% of its greatest acceleration",
        "the acceleration of {where} does not match its positions: it is off by {value} % of its "
        "greatest acceleration",
        _SPLINE,
    ),
    "momentum": Quantity(
        "check_momentum_force_max_bw_percent",
        _BW,
        "the rate of momentum differs from the external forces by {value} % of body weight",
        "make sure that qvel, qacc and the forces belong to one motion, and check on a finer grid",
    ),
    "energy": Quantity(
        "check_energy_power_max_percent",
        "% of the greatest power",
        "the rate of energy differs from the power of the joints by {value} % of the greatest "
        "power",
        "make sure that qvel and qacc belong to one motion, and check on a finer grid",
    ),
}
QUANTITIES = tuple(QUANTITY)
"""Quantities that are checked in every motion."""

CONDITION = Quantity(
    "check_conditions_broken", "", "{where} is {value} {unit}", f"{_REFINE}, or relax the task"
)
"""Conditions of a task, reported by their own names and units."""

OF_JOINTS = ("coordinate", "velocity", "torque", "condition")
"""Quantities that are reported by name."""

OF_COORDINATES = (*OF_JOINTS, "velocity_mismatch", "acceleration_mismatch")
"""Quantities whose names are those of coordinates."""


def quantity(name: str) -> Quantity:
    """Return a quantity by name."""
    return CONDITION if name == "condition" else QUANTITY[name]
