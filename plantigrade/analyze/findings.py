"""What is looked at in a motion under test, what is allowed, and how a fault is put in words."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tolerances:
    """How far a motion may be off and still be called physical.

    Body weight is mass times gravity; "percent of body weight times metre" is the moment of a
    hundredth of it at one metre.

    Attributes:
        root_force_rms: Unexplained force at the root, root mean square [% of body weight].
        root_force_max: The same at any instant.
        root_moment_rms: Unexplained moment about the centre of mass, root mean square
            [% of body weight times metre].
        root_moment_max: The same at any instant.
        slip: Way of the material at a standing site along the ground during one stance [mm].
        slip_speed: Its speed at any instant [m/s]; infinite: reported, not judged.
        penetration: Depth of any contact sphere in the ground [mm].
        hover: Height of a standing site above the ground [mm].
        friction: By how much tangential over normal force may exceed the coefficient of friction.
        negligible: Normal force below which the ratio is taken over this force instead
            [% of body weight].
        adhesion: Pull of the ground [% of body weight].
        pressure: Distance of a centre of pressure from the hull of what stands [mm].
        unsupported: Force of a site that does not stand [% of body weight].
        force: Excess over the greatest normal force of a site [% of that limit].
        coordinate: Excess over the limit of a joint [deg].
        velocity: Excess over the limit of a joint's speed [% of that limit].
        torque: Excess over the limit of a joint's torque [% of that limit].
        velocity_mismatch: Difference between given velocity and rate of position, in percent of
            the coordinate's greatest speed (but of no less than 1 rad/s or 0.5 m/s).
        acceleration_mismatch: Likewise of accelerations (no less than 10 rad/s² or 3 m/s²).
        momentum: Force, and moment over one metre, by which the rate of momentum differs from the
            external forces, mean over a step [% of body weight].
        energy: Power by which the rate of energy differs from that of the joints, mean over a step,
            in percent of its greatest value (but of no less than body weight times 1 m/s).
    """

    root_force_rms: float = 0.5
    root_force_max: float = 1.0
    root_moment_rms: float = 0.5
    root_moment_max: float = 1.0
    slip: float = 3.0
    slip_speed: float = np.inf
    penetration: float = 2.0
    hover: float = 2.0
    friction: float = 0.01
    negligible: float = 1.0
    adhesion: float = 0.1
    pressure: float = 3.0
    unsupported: float = 0.1
    force: float = 1.0
    coordinate: float = 0.5
    velocity: float = 2.0
    torque: float = 2.0
    velocity_mismatch: float = 0.5
    acceleration_mismatch: float = 5.0
    momentum: float = 2.0
    energy: float = 5.0


@dataclass(frozen=True)
class Measure:
    """The worst of one quantity over the motion.

    Attributes:
        quantity: Which, one of :data:`QUANTITIES`.
        value: The worst value; NaN where there was nothing to look at.
        limit: What is allowed.
        unit: Unit of both.
        time: When [s]; NaN for a mean over the motion.
        name: Site or coordinate; empty for the whole body.
        side: ``"r"``, ``"l"`` or empty.
    """

    quantity: str
    value: float
    limit: float
    unit: str
    time: float = np.nan
    name: str = ""
    side: str = ""


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    Attributes:
        quantity: What, one of :data:`QUANTITIES`.
        name: Site or coordinate where it is worst; empty for the whole body.
        side: ``"r"``, ``"l"`` or empty.
        time: When it is worst [s].
        start: Since when it is too large [s].
        end: Until when [s].
        value: Its worst value.
        limit: What is allowed.
        unit: Unit of both.
        advice: What to refine or relax.
        others: More sites of the same foot with the same fault at the same time.
    """

    quantity: str
    name: str
    side: str
    time: float
    start: float
    end: float
    value: float
    limit: float
    unit: str
    advice: str
    others: tuple[str, ...] = ()

    @property
    def where(self) -> str:
        """The place in words: ``"left heel back medial"``, or the name of a coordinate."""
        return _place(self.quantity, self.name, self.side)

    def sentence(self, more_times: int = 0) -> str:
        """Return what is wrong, where, when, what is allowed and what to do.

        Args:
            more_times: How often the same happens at other times.
        """
        what = QUANTITY[self.quantity].words.format(
            where=self.where, value=_number(self.value), unit=self.unit
        )
        allowed = f"at most {_number(self.limit)}{_spaced(self.unit)} is allowed"
        if self.others:
            n, foot = len(self.others), self.side and self.quantity not in _OF_COORDINATES
            kind = ("more place" if n == 1 else "more places") + " of that foot" if foot else "more"
            what += f" (and so {'does' if n == 1 else 'do'} {n} {kind})"
        again = "once more" if more_times == 1 else f"{more_times} more times"
        when = self._when() + (f", and {again}" if more_times else "")
        return f"{what} {when}; {allowed}: {self.advice}"

    def _when(self) -> str:
        if np.isnan(self.time):
            return "over the whole motion"
        if self.end - self.start < 5e-3:
            return f"at {self.time:.2f} s"
        return f"between {self.start:.2f} and {self.end:.2f} s"


@dataclass(frozen=True, eq=False)
class Slip:
    """One stance of one site.

    Attributes:
        site: Its name.
        side: Its foot.
        start: First frame of the stance, its time [s].
        end: Last frame [s].
        distance: Greatest way along the ground from where the material touched [mm].
        time: When [s].
        since: When a twentieth of that way was done [s].
        until: When all but a twentieth of it was done [s].
    """

    site: str
    side: str
    start: float
    end: float
    distance: float
    time: float
    since: float
    until: float


@dataclass(frozen=True)
class Quantity:
    """How a quantity is called, in words, in metrics.json, and what helps against it."""

    key: str
    unit: str
    words: str
    advice: str


_REFINE = "refine the mesh there"
_BW, _BWM = "% of body weight", "% of body weight times metre"
QUANTITY = {
    "root_force": Quantity(
        "check_root_force_max_bw_percent",
        _BW,
        "{value} % of body weight act on the body unexplained by any contact",
        f"{_REFINE}, weigh accelerations more, and see that every switch of contact is a node",
    ),
    "root_force_rms": Quantity(
        "check_root_force_rms_bw_percent",
        _BW,
        "{value} % of body weight (root mean square) act on the body unexplained by any contact",
        "refine the mesh, or weigh accelerations more",
    ),
    "root_moment": Quantity(
        "check_root_moment_max_bwm_percent",
        _BWM,
        "a moment of {value} % of body weight times metre acts on the body unexplained",
        f"{_REFINE}, weigh accelerations more, and see that every switch of contact is a node",
    ),
    "root_moment_rms": Quantity(
        "check_root_moment_rms_bwm_percent",
        _BWM,
        "a moment of {value} % of body weight times metre (root mean square) acts unexplained",
        "refine the mesh, or weigh accelerations more",
    ),
    "slip": Quantity(
        "check_slip_max_mm",
        "mm",
        "the {where} slips {value} mm",
        f"{_REFINE}, or hold its velocity at zero where it touches down and lifts off",
    ),
    "slip_speed": Quantity(
        "check_slip_speed_max_m_s",
        "m/s",
        "the {where} slides at {value} m/s while it stands",
        f"{_REFINE}, or hold its velocity at zero where it touches down and lifts off",
    ),
    "penetration": Quantity(
        "check_penetration_max_mm",
        "mm",
        "the {where} is {value} mm in the ground",
        f"{_REFINE}, or ask for a clearance of that place",
    ),
    "hover": Quantity(
        "check_hover_max_mm",
        "mm",
        "the {where} should stand but is {value} mm above the ground",
        f"{_REFINE}, or let the plan lift it at another time",
    ),
    "friction": Quantity(
        "check_friction_ratio_max",
        "of its normal force",
        "the {where} needs friction of {value} of its normal force",
        "take a smaller coefficient for the optimiser (a pyramid around the cone reaches √2 of it "
        "at its edges), move more slowly, or allow rougher ground",
    ),
    "adhesion": Quantity(
        "check_adhesion_max_bw_percent",
        _BW,
        "the ground pulls at the {where} with {value} % of body weight",
        "bound the normal force from below by zero at every node",
    ),
    "pressure": Quantity(
        "check_pressure_outside_max_mm",
        "mm",
        "the centre of pressure of {where} is {value} mm outside of what stands",
        "let a site carry at a node only where it stands before and after it, and refine the mesh",
    ),
    "unsupported": Quantity(
        "check_unsupported_force_max_bw_percent",
        _BW,
        "the {where} carries {value} % of body weight although it does not stand",
        "let a site carry at a node only where it stands before and after it",
    ),
    "force": Quantity(
        "check_site_force_max_n",
        "N",
        "the {where} carries {value} N",
        "share the load among more sites, land more softly, or allow more",
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
        f"{_REFINE}, give the motion more time, or allow a greater speed",
    ),
    "torque": Quantity(
        "check_torque_limit_use_max_percent",
        "% of its limit",
        "{where} needs {value} {unit}",
        f"{_REFINE}, give the motion more time, or take a stronger joint",
    ),
    "velocity_mismatch": Quantity(
        "check_velocity_mismatch_max_percent",
        "% of its greatest speed",
        "the velocity of {where} is not the rate of its position: off by {value} % of its "
        "greatest speed",
        "evaluate qvel from the same spline as qpos, and check on a finer grid",
    ),
    "acceleration_mismatch": Quantity(
        "check_acceleration_mismatch_max_percent",
        "% of its greatest acceleration",
        "the acceleration of {where} does not belong to its positions: off by {value} % of its "
        "greatest acceleration",
        "evaluate qacc from the same spline as qpos, and check on a finer grid",
    ),
    "momentum": Quantity(
        "check_momentum_force_max_bw_percent",
        _BW,
        "momentum changes by {value} % of body weight more or less than the forces say",
        "see that qvel, qacc and the forces belong to one motion, and check on a finer grid",
    ),
    "energy": Quantity(
        "check_energy_power_max_percent",
        "% of the greatest power",
        "energy changes by {value} % of the greatest power more or less than the joints work",
        "see that qvel and qacc belong to one motion, and check on a finer grid",
    ),
}
QUANTITIES = tuple(QUANTITY)
"""Everything that is looked at."""

OF_JOINTS = ("coordinate", "velocity", "torque")
"""Quantities that each joint has for itself."""

_OF_COORDINATES = (*OF_JOINTS, "velocity_mismatch", "acceleration_mismatch")


def _place(quantity: str, name: str, side: str) -> str:
    """Return a place in words."""
    if quantity in (*_OF_COORDINATES, "pressure"):
        return name
    plain = name.removesuffix(f"_{side}") if side else name
    foot = {"r": "right ", "l": "left "}.get(side, "")
    return foot + plain.replace("_", " ")


def _number(value: float) -> str:
    """Return a number with three figures."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def _spaced(unit: str) -> str:
    return f" {unit}" if unit else ""
