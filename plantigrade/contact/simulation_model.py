r"""A person as MJCF that can be stepped at once: actuators, sensors, stiffness of sole and ground.

The base is :func:`plantigrade.contact.scene.scene_xml` on level ground: motors with the person's
torque limits, armature, damping, contact between limbs, friction.

**Stiffness.** Soles yield as in :mod:`plantigrade.contact.sole`, with the damping of heel pads.
Sole and ground are in series, :math:`1/K = 1/K_{sole} + 1/K_{ground}`.
"""

from typing import Literal
from xml.etree import ElementTree as ET

import mujoco

from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.scene import scene_xml
from plantigrade.contact.site import GEOM_PREFIX, contact_sites
from plantigrade.contact.sole import SoleSettings, soften
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.mjcf import numbers, read_mjcf

__all__ = ["simulation_xml"]

ACTUATORS = ("torque", "position")
"""Kinds of actuators: a control is a torque [N m], or an angle [rad] that a servo holds."""
SENSORS = ("feet",)
"""Groups of sensors: the ground reaction on each foot."""
SERVO_STIFFNESS = 8.0
"""Stiffness of a position servo per greatest torque of its joint [1/rad]. Every joint set stands on
every foot for as long as it was tried (5 s); with 4, multi-segment feet gave way."""
SERVO_DAMPING = 0.1  #: Damping of a position servo over its stiffness [s]
STIFFNESS_RANGE = (1e3, 1e7)
"""Allowed stiffness of a contact [N/m]: softer than foam, and harder than steel steps can hold."""


def simulation_xml(
    human: Human,
    *,
    actuators: Literal["torque", "position"] = "torque",
    sensors: tuple[str, ...] = (),
    foot_stiffness: float | None = None,
    ground_stiffness: float | None = None,
) -> str:
    """Return the MJCF text of a person on level ground that can be stepped at once.

    The key frame ``standing`` holds the configuration and the controls of quiet standing.

    Args:
        actuators: One of :data:`ACTUATORS`; one for each hinge, with its name and torque limits.
        sensors: Groups of :data:`SENSORS`. ``"feet"``: ``ground_reaction_r`` and ``_l``, force on
            the foot [N], moment [N m] and its point [m], world axes.
        foot_stiffness: Stiffness of the sole at each of its spheres [N/m]; MuJoCo's own if absent.
        ground_stiffness: Stiffness of the ground under each sphere [N/m]; rigid if absent.

    Raises:
        ParameterError: If a value is not allowed.
    """
    if actuators not in ACTUATORS:
        raise ParameterError(f"{actuators=} must be one of {', '.join(ACTUATORS)}")
    for name in sensors:
        if name not in SENSORS:
            raise ParameterError(f"sensors {name!r} are not known; there are {', '.join(SENSORS)}")
    root = ET.fromstring(scene_xml(human, Ground()))
    hinges = human.standing()[7:]
    if actuators == "position":
        _replace_motors(root)
        next(root.iter("key")).set("ctrl", numbers(hinges))
    if "feet" in sensors:
        added = ET.SubElement(root, "sensor")
        for side in SIDES:
            places = {"geom1": "floor", "subtree2": f"foot_{side}"}
            what = {"data": "force torque pos", "reduce": "netforce"}
            name = {"name": f"ground_reaction_{side}"}
            ET.SubElement(added, "contact", {**name, **places, **what})
    stiffness = _in_series(foot_stiffness, ground_stiffness)
    if stiffness is not None:
        _soften(root, human, stiffness)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def _replace_motors(root: ET.Element) -> None:
    """Replace the motor of each hinge by a servo that holds its angle."""
    actuators = next(root.iter("actuator"))
    ranges = {joint.get("name"): joint.get("range", "") for joint in root.iter("joint")}
    for motor in list(actuators):
        name, limits = motor.get("name", ""), motor.get("ctrlrange", "")
        kp = SERVO_STIFFNESS * max(abs(float(x)) for x in limits.split())
        gains = {"kp": numbers([kp]), "kv": numbers([SERVO_DAMPING * kp])}
        actuators.remove(motor)
        servo = {"name": name, "joint": name, "ctrlrange": ranges[name], "forcerange": limits}
        ET.SubElement(actuators, "position", {**servo, **gains})


def _in_series(*values: float | None) -> float | None:
    """Return the stiffness of springs in series [N/m]; None where none is given."""
    given = [value for value in values if value is not None]
    for value in given:
        if not STIFFNESS_RANGE[0] <= value <= STIFFNESS_RANGE[1]:
            low, high = STIFFNESS_RANGE
            raise ParameterError(f"a stiffness of {value:g} N/m; allowed are {low:g} to {high:g}")
    return 1.0 / sum(1.0 / value for value in given) if given else None


def _soften(root: ET.Element, human: Human, stiffness: float) -> None:
    """Give every sphere of the soles a stiffness [N/m]; it rules over that of the floor."""
    model = read_mjcf(mujoco.MjModel.from_xml_string, ET.tostring(root, encoding="unicode"))
    geoms = {geom.get("name", ""): geom for geom in root.iter("geom")}
    for site in contact_sites(human):
        soften(model, site.name, stiffness, SoleSettings.damping_time)
        name = GEOM_PREFIX + site.name
        for key in ("solref", "solimp", "solmix"):
            geoms[name].set(key, numbers(getattr(model.geom(name), key)))
