r"""A whole-body walk for a given speed and leg length, from published mean curves.

Joint angles of pelvis, hip, knee, ankle and trunk are Fourier series of six harmonics through the
mean curves of [Schwartz2008]_ at five speeds (83 typically developing children; curves of adults
at the same dimensionless speed have the same shape), interpolated over the dimensionless speed
:math:`v^* = v / \sqrt{g l}`. Toe extension and hindfoot inversion are the mean hallux and hindfoot
curves of the Oxford Foot Model (method: [Stebbins2006]_). The coefficients, in degrees, are in
``textbook_gait.json``: mean, then cosine and sine of each harmonic.

Three conventions are converted. Signs and names are those of OpenSim's Rajagopal model. Plug-in
Gait's pelvic plane leans forward by :data:`plantigrade.models.anatomy.SPINE_PLANE` at zero pelvis
tilt of that model; pelvis tilt and hip flexion are corrected for it. Foot angles are relative to
mid-stance. Pelvis and trunk are symmetrised: tilt keeps the even harmonics, list, rotation and
bending the odd ones.

The mean walk of adults has the means of 42 adults at their comfortable speed [Fukuchi2018]_ in
pelvis, hip, knee and ankle (``textbook_adults.json``, twelve harmonics); at other speeds the
children's dependence on speed is added.

Step length follows the preferred relation of [Kuo2001]_, :math:`s/l = (v^*)^{0.42}`. The pelvis
moves at the mean speed with two small oscillations per stride and one lateral sway, with the
amplitudes of [Zijlstra1997]_. Arm swing follows [Murray1967]_, about 32 degrees in the shoulder at
free speed, opposite to the leg and increasing with speed.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.errors import ParameterError
from plantigrade.models.anatomy import SPINE_PLANE

CLASS_SPEEDS = {
    "very_slow": 0.159,
    "slow": 0.295,
    "free": 0.4315,
    "fast": 0.568,
    "very_fast": 0.704,
}
"""Dimensionless speed at the centre of each class [1]; the outer two by equal spacing."""
FOOT_OFF = {"very_slow": 68.0, "slow": 62.0, "free": 59.0, "fast": 58.0, "very_fast": 56.0}
"""Foot off [% of cycle], Cycle Events of [Schwartz2008]_."""
FREE_SPEED = CLASS_SPEEDS["free"]
ADULT_SPEED = 0.42
"""Dimensionless speed of the adults [1]; 1.24 m/s with a leg length of 0.89 m [Fukuchi2018]_."""
PRONATION = 80.0
"""Forearm pronation [deg]: palms towards the thighs, as in standing."""


@dataclass(frozen=True)
class TextbookGait:
    """A periodic walk; right heel strike at time zero."""

    time: Float[Array, " n_frames"]  #: Time of each frame [s]
    #: Joint coordinates over time [rad] under their names; and ``pelvis_tx`` (forward) and
    #: ``pelvis_tz`` (to the right) [m], in OpenSim's axes. ``pelvis_ty`` is missing because the
    #: height of the pelvis follows from the feet on the ground.
    coordinates: dict[str, np.ndarray]
    heel_strikes: dict[str, np.ndarray]  #: Heel strikes within the time, by side [s]
    toe_offs: dict[str, np.ndarray]  #: Toe offs within the time, by side [s]
    speed: float  #: Walking speed [m/s]
    stride_length: float  #: Length of a stride [m]
    stride_time: float  #: Time of a stride [s]
    foot_off: float  #: Toe off as a fraction of the cycle

    @property
    def cadence(self) -> float:
        """Steps per minute [1/min]."""
        return 120.0 / self.stride_time

    def phase(self, side: str) -> Float[Array, " n_frames"]:
        """Return the phase of a foot's cycle in each frame, 0 to 1 from its heel strike."""
        return _phase(self.time / self.stride_time, side)

    def stance(self, side: str) -> Bool[Array, " n_frames"]:
        """Return the frames in which a foot is in stance."""
        return self.phase(side) < self.foot_off


def textbook_gait(
    speed: float, leg_length: float, *, rate: float = 100.0, cycles: int = 3, adult: bool = False
) -> TextbookGait:
    """Return a whole-body walk.

    Args:
        speed: Walking speed [m/s]; its dimensionless value between 0.1 and 0.8.
        leg_length: Leg length, hip to ground [m].
        rate: Frames per second [Hz].
        cycles: Strides of the right foot.
        adult: Whether the curves of pelvis and legs are those of adults instead of children.

    Returns:
        The walk, including both ends of the last cycle if they fall on a frame.

    Raises:
        ParameterError: If a value is out of range.
    """
    if not 0.2 <= leg_length <= 1.5:
        raise ParameterError(f"{leg_length=} [m] must lie between 0.2 and 1.5")
    slowest, fastest = np.array([0.1, 0.8]) * np.sqrt(GRAVITY * leg_length)
    if not slowest <= speed <= fastest:
        raise ParameterError(
            f"{speed=} [m/s] is not a walking speed for a leg of {leg_length} m: "
            f"{slowest:.2f} to {fastest:.2f} m/s"
        )
    if not (rate >= 10 and cycles >= 1):
        raise ParameterError(f"{rate=} [Hz] must be at least 10 and {cycles=} at least 1")
    relative = float(speed / np.sqrt(GRAVITY * leg_length))
    stride_length = float(2.0 * leg_length * relative**0.42)
    stride_time = stride_length / speed
    time = np.arange(int(np.floor(cycles * stride_time * rate + 1e-9)) + 1) / rate
    classes = list(CLASS_SPEEDS.values())
    foot_off = float(np.interp(relative, classes, list(FOOT_OFF.values())) / 100.0)
    whole = time / stride_time
    degrees = _angles(relative, whole, adult)
    coordinates = {name: np.deg2rad(values) for name, values in degrees.items()}

    # Forward wave: fastest in double support, slowest in single support, amplitude 5 mm at free
    # speed. Sway towards the stance leg: amplitude 2 cm, smaller at higher speed.
    phase = 2 * np.pi * whole
    wave = 0.0055 * leg_length * relative / FREE_SPEED
    sway = 0.022 * leg_length * np.clip(FREE_SPEED / relative, 0.6, 2.0)
    coordinates["pelvis_tx"] = speed * time + wave * np.sin(2 * (phase - 2 * np.pi * 0.05))
    coordinates["pelvis_tz"] = sway * np.cos(phase - 2 * np.pi * 0.30)

    end = time[-1]
    strikes, offs = {}, {}
    for side, start in (("l", 0.5), ("r", 0.0)):
        count = np.arange(-1, cycles + 1)
        for table, fraction in ((strikes, start), (offs, start + foot_off)):
            instants = (count + fraction) * stride_time
            table[side] = instants[(instants >= -1e-9) & (instants <= end + 1e-9)]
    return TextbookGait(
        time, coordinates, strikes, offs, float(speed), stride_length, stride_time, foot_off
    )


def _angles(relative, whole, adult):
    """Return every joint coordinate [deg] at strides `whole` of the right foot."""
    right, left = _phase(whole, "r"), _phase(whole, "l")
    angles = {"pelvis_tilt": _series("pelvis_tilt", relative, right, "even", adult) + SPINE_PLANE}
    for name in ("pelvis_list", "pelvis_rotation", "lumbar_bending", "lumbar_rotation"):
        angles[name] = _series(name, relative, right, "odd", adult)
    # trunk with a constant forward lean of 2 degrees
    angles["lumbar_extension"] = -angles["pelvis_tilt"] - 2.0
    swing = float(np.clip(relative / FREE_SPEED, 0.2, 1.6))
    for side, phase in (("r", right), ("l", left)):
        for name in ("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle"):
            offset = SPINE_PLANE if name == "hip_flexion" else 0.0
            angles[f"{name}_{side}"] = _series(name, relative, phase, adult=adult) - offset
        for name in ("subtalar_angle", "mtp_angle"):
            middle = _series(name, relative, np.array([0.3]))[0]
            angles[f"{name}_{side}"] = _series(name, relative, phase) - middle
        forward = -np.cos(2 * np.pi * phase)  # arm extended at ipsilateral heel strike
        angles[f"arm_flex_{side}"] = -5.0 + 16.0 * swing * forward
        angles[f"arm_add_{side}"] = np.full_like(phase, -8.0)
        angles[f"arm_rot_{side}"] = np.zeros_like(phase)
        angles[f"elbow_flex_{side}"] = 20.0 + 12.0 * swing * (1.0 + forward)
        angles[f"pro_sup_{side}"] = np.full_like(phase, PRONATION)
    return angles


def _series(name, relative, phase, harmonics="all", adult=False):
    """Evaluate a Fourier series [deg], coefficients interpolated over the dimensionless speed."""
    table = _coefficients("textbook_gait")[name]
    if "all" in table:
        c = np.array(table["all"])
    else:
        rows = np.array([table[key] for key in CLASS_SPEEDS])
        speeds = list(CLASS_SPEEDS.values())
        c = np.array([np.interp(relative, speeds, column) for column in rows.T])
        means = _coefficients("textbook_adults") if adult else {}
        if name in means:
            c -= [np.interp(ADULT_SPEED, speeds, column) for column in rows.T]
            c = np.pad(c, (0, len(means[name]) - len(c))) + means[name]
    result = np.full(len(phase), c[0] if harmonics != "odd" else 0.0)
    for h in range(1, (len(c) + 1) // 2):
        if harmonics == "even" and h % 2 or harmonics == "odd" and h % 2 == 0:
            continue
        angle = 2 * np.pi * h * phase
        result += c[2 * h - 1] * np.cos(angle) + c[2 * h] * np.sin(angle)
    return result


def _phase(whole, side):
    if side not in SIDES:
        raise ParameterError(f"{side=} must be 'r' or 'l'")
    return np.mod(whole + (0.5 if side == "l" else 0.0), 1.0)


@cache
def _coefficients(table: str) -> dict:
    text = files("plantigrade.models").joinpath(f"{table}.json").read_text(encoding="utf-8")
    return json.loads(text)
