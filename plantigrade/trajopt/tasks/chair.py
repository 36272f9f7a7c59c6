"""Rising from a chair and sitting down on it."""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.limb_sites import (
    HIP_ABOVE_SEAT,
    REFERENCE_HEIGHT,
    SEATED_PELVIS_TILT,
    limb_site,
    seat_sites,
)
from plantigrade.contact.plan import ContactPlan, Footprint, PointSupport
from plantigrade.contact.site import ContactSite
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.models import Human
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD, about_axis
from plantigrade.trajopt.guess.hands import palms, reached
from plantigrade.trajopt.guess.postures import (
    KeyPostures,
    body_at,
    posture,
    standing_feet,
    standing_on,
    standing_stances,
)
from plantigrade.trajopt.problem.contact import ACROSS
from plantigrade.trajopt.tasks.gait_parameters import TOE_OUT
from plantigrade.trajopt.tasks.mechanics import check_support, check_time
from plantigrade.trajopt.tasks.settings import SitToStandSettings, StandToSitSettings
from plantigrade.trajopt.tasks.standing import at_rest, basics, bent
from plantigrade.trajopt.tasks.supported import with_supports
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.terms.contact import Above
from plantigrade.trajopt.terms.posture import Symmetry

CHAIR_HEIGHT_SHARE = 0.9  # [1] chair height relative to knee height; a chair of 45 cm for an adult
HALF_RISE_TIME = 0.235  # [1] time of half the rise relative to the time after seat-off
ARMREST_HEIGHT = 0.22  # [m] above the seat; 20 to 25 cm on office chairs
ARMREST_AHEAD = 0.14  # [stature] hands ahead of the hips, where armrests end. Estimate.
ARMREST_ASIDE = 0.155  # [stature] hands from the middle; seats are 50 to 55 cm between armrests
HANDS_SHARE = 0.45  # [1] time until the hands leave, from seat-off to the end. Estimate.
SHANK_LEAN = float(np.deg2rad(15.0))  # [rad] forward lean of the shanks in sitting


def resting_place(
    human: Human, site: ContactSite, q: Float[Array, " nv"], pitch: float = 0.0
) -> tuple[float, float, float]:
    """Return where a site rests in a posture, as rows of contact have it [m].

    Args:
        pitch: Forward pitch of its body from which it rolls [rad].
    """
    state = body_at(human, q)
    centre = state.position(SitePoints(human, (site,)))[0]
    R = state.rotation(site.body) @ about_axis(ACROSS, np.array([-pitch]))[0]
    rho = site.radius
    x = centre[0] + rho * np.arctan2(R[2, 0], R[0, 0])
    y = centre[1] + rho * np.arctan2(R[2, 1], R[1, 1])
    return float(x), float(y), float(centre[2] - rho)


def seated_posture(human: Human, chair_height: float) -> Float[Array, " nv"]:
    """Return the coordinates of sitting upright on a seat [m], feet where they are in standing.

    Raises:
        ParameterError: If the seat is too high or too low.
    """
    d = human.dimensions
    feet = turned_out(human)
    ankle = feet["r"].position[0]
    hip = chair_height + HIP_ABOVE_SEAT * human.height
    knee = d.ankle_height + d.shank * np.cos(SHANK_LEAN)
    rise = (hip - knee) / d.thigh
    low, high = (knee + k * d.thigh - HIP_ABOVE_SEAT * human.height for k in (-0.5, 0.75))
    number("chair_height", chair_height, low, high, "m", f"a person of {human.height:.2f} m")
    x = ankle + d.shank * np.sin(SHANK_LEAN) - d.thigh * np.sqrt(1 - rise**2)
    joints = bent(human, -SEATED_PELVIS_TILT)
    return posture(human, feet, hip=(float(x), hip), tilt=SEATED_PELVIS_TILT, joints=joints)


def sit_to_stand(human: Human, parameters: SitToStandSettings) -> MotionTask:
    """Return the task of rising from a chair, or of sitting down on it.

    The pelvis rests on two points below the hip joints, which roll on the seat without slipping
    and carry force until seat-off, or from seat contact on.

    Raises:
        ParameterError: If the chair is too high or too low for this person, or there is too little
            time.
    """
    d, chair_height, duration = human.dimensions, parameters.chair_height, parameters.duration
    if chair_height is None:
        chair_height = CHAIR_HEIGHT_SHARE * (d.ankle_height + d.shank)
    reverse, rests = isinstance(parameters, StandToSitSettings), ()
    feet, sites = turned_out(human), seat_sites(human)
    seated, standing = seated_posture(human, chair_height), standing_on(human, feet)
    off = parameters.seat_off * duration
    rising = np.array([0.0, off, off + HALF_RISE_TIME * (duration - off), duration])
    lean = _leaning(human, seated)
    middle = (lean + standing) / 2
    keys = [seated, lean, middle, standing]
    span = (-1.0, off)
    if reverse:
        rising, keys = duration - rising[::-1], keys[::-1]
        span = (duration - off, duration + 1.0)
    supports = tuple(PointSupport(s, resting_place(human, s, seated), *span) for s in sites)
    if parameters.armrests:
        hands = off + HANDS_SHARE * (duration - off)
        until = (duration - hands, duration + 1.0) if reverse else (-1.0, hands)
        keys, rests = _on_armrests(human, chair_height, keys, until, reverse=reverse)
    plan = ContactPlan(duration, standing_stances(feet, duration), supports=supports)
    places = [_centre_of_mass(human, q) for q in (keys[0], keys[-1])]
    check_time(
        human,
        duration - off,
        abs(places[1][2] - places[0][2]),
        "to sit down" if reverse else "to rise",
    )
    check_support(human, plan, (places[0], places[1]))
    terms = (
        *basics(human),
        *at_rest(human, 0.0, keys[0]),
        *at_rest(human, duration, keys[-1]),
        *(Above(s.name, chair_height) for s in sites),
        Symmetry(),
    )
    name = "stand-to-sit" if reverse else "sit-to-stand"
    guess = KeyPostures(tuple(map(float, rising)), tuple(keys))
    return with_supports(MotionTask(name, plan, terms, guess), rests)


def _on_armrests(
    human: Human,
    chair_height: float,
    keys: list[Float[Array, " nv"]],
    span: tuple[float, float],
    *,
    reverse: bool,
) -> tuple[list[Float[Array, " nv"]], tuple[PointSupport, ...]]:
    """Return key postures whose seated one has its hands on armrests, and the armrests."""
    index = -1 if reverse else 0
    seated, rests = keys[index], []
    hips, size = seated[3:6] @ OPENSIM_TO_WORLD.T, human.height
    for side, left in (("r", -1.0), ("l", 1.0)):
        ahead, aside = hips[0] + ARMREST_AHEAD * size, left * ARMREST_ASIDE * size
        target = np.array([ahead, aside, chair_height + ARMREST_HEIGHT * size / REFERENCE_HEIGHT])
        seated = reached(human, side, seated[None], target)[0]
        x, y, z = map(float, palms(human, seated[None], side)[0])
        rests.append(PointSupport(limb_site(human, f"hand_{side}"), (x, y, z), *span))
    out = list(keys)
    out[index] = seated
    return out, tuple(rests)


def _centre_of_mass(human: Human, q: Float[Array, " nv"]) -> tuple[float, float, float]:
    """Return where it is in a posture, world [m]."""
    x, y, z = body_at(human, q).com
    return float(x), float(y), float(z)


def turned_out(human: Human) -> dict[str, Footprint]:
    """Return where the feet are: as in standing, turned out as in walking.

    On parallel feet the knees of a seated person meet, because of the axis of the knee.
    """
    turned = {"r": -TOE_OUT, "l": TOE_OUT}
    return {s: replace(foot, heading=turned[s]) for s, foot in standing_feet(human).items()}


def _leaning(human: Human, seated: Float[Array, " nv"]) -> Float[Array, " nv"]:
    """Return the posture just before seat-off: pelvis rolled forward, trunk bent."""
    out = seated.copy()
    out[0] -= np.deg2rad(35.0)
    if "lumbar_extension" in human.coordinates:
        out[6 + human.hinge("lumbar_extension")] -= np.deg2rad(10.0)
    return out
