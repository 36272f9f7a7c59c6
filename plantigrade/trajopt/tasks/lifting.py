"""Lifting a box from the floor onto a table with both hands.

The box goes on a given way, up and then forward onto the table; how the body lifts it, is for the
optimiser to find. Hands hold the box at the middle of its sides, so that it does not turn; knees,
pelvis, breastbone and forehead stay behind it.
"""

import numpy as np

from plantigrade.contact.limb_sites import REFERENCE_HEIGHT, palm
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.scene import SceneObject
from plantigrade.contact.site import Point
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.trajopt.guess.hands import reached
from plantigrade.trajopt.guess.postures import (
    KeyPostures,
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.trajopt.tasks.settings import LiftSettings
from plantigrade.trajopt.tasks.standing import at_rest, basics, crouch
from plantigrade.trajopt.tasks.task import MotionTask, ObjectPath
from plantigrade.trajopt.terms.carrying import (
    BehindTrajectory,
    Carried,
    CarryingPath,
    FollowTrajectory,
)
from plantigrade.trajopt.terms.posture import Symmetry, Upright
from plantigrade.trajopt.terms.term import Term

BOX = (0.28, 0.38, 0.30)  # [m] depth, width and height of the box
BOX_AHEAD = 0.50  # [m] middle of the box ahead of the middle of standing at 1.75 m; toes clear it
HANDS_HEIGHT = 0.22  # [m] hands above the bottom of the box
OVER_TABLE = 0.05  # [m] how high above the table the box passes its edge
ONTO_TABLE = 0.17  # [m] how far forward the box goes, its middle 3 cm behind the table's edge
TABLE_DEPTH = 0.60  # [m] of the table that is drawn
TABLE_WIDTH = 1.20  # [m] of the table that is drawn
TABLE_THICKNESS = 0.03  # [m] of the table that is drawn
REST_SHARES = (0.34, 0.74)  # [1] from when to when the box moves, of the duration
WAY_SHARES = ((0.0, 0.0, 0.0), (0.6, 0.6, 0.7), (1.0, 1.0, 1.0))
"""When the box is on the floor, above the edge of the table and on it [1]: x moves after 0.6."""
HEAD_WEIGHT = 1.0  # [1/s] weight of a head that stays up, so that the eyes see the box. Chosen.
GUESS_DEPTH = 0.24  # [stature] crouch of the guess
BEHIND = {"patella": 0.01, "asis": 0.01, "sternum": 0.01, "forehead": 0.01}
"""Landmarks that stay behind the box, and how thick the body is before them [m]. Estimate."""


def lift(human: Human, parameters: LiftSettings) -> MotionTask:
    """Return the task of lifting a box from the floor onto a table, from standing to standing.

    Raises:
        ParameterError: If a value is out of range.
    """
    duration, size = parameters.duration, human.height / REFERENCE_HEIGHT
    start, stop = (share * duration for share in REST_SHARES)
    ahead, top = BOX_AHEAD * size, parameters.table_height + HANDS_HEIGHT
    places = (
        (ahead, 0.0, HANDS_HEIGHT),
        (ahead, 0.0, top + OVER_TABLE),
        (ahead + ONTO_TABLE, 0.0, top),
    )
    way = CarryingPath(start, stop, places, WAY_SHARES)
    feet, standing = standing_feet(human), standing_posture(human)
    plan = ContactPlan(duration, standing_stances(feet, duration))
    terms: list[Term] = [
        *basics(human),
        *at_rest(human, 0.0, standing),
        *at_rest(human, duration, standing),
        Symmetry(),
        Upright("head", forward=HEAD_WEIGHT),
    ]
    low, high = crouch(human, feet, GUESS_DEPTH * human.height), standing
    for side, left in (("r", -1.0), ("l", 1.0)):
        point, aside = palm(human, side), (0.0, left * BOX[1] / 2, 0.0)
        terms += [
            FollowTrajectory(point, way, aside),
            Carried(
                point, start=start, stop=stop, mass=parameters.box_mass / 2,
                gravity=human.gravity, way=way,
            ),
        ]  # fmt: skip
        low = reached(human, side, low[None], np.add(places[0], aside))[0]
        high = reached(human, side, high[None], np.add(places[2], aside))[0]
    terms += [
        BehindTrajectory(point, way, BOX[0] / 2, f"{name} behind the box")
        for name, point in _front(human).items()
    ]
    times = (0.0, start - 0.1, start + 0.1, stop - 0.1, stop + 0.1, duration)
    guess = KeyPostures(times, (standing, low, low, high, high, standing))
    return MotionTask("lift", plan, tuple(terms), guess, objects=_drawn(way, parameters, ahead))


def _drawn(
    way: CarryingPath, parameters: LiftSettings, ahead: float
) -> tuple[tuple[SceneObject, ObjectPath], ...]:
    """Return box and table; the table begins where the box rises past its edge."""
    table = (TABLE_DEPTH, TABLE_WIDTH, TABLE_THICKNESS)
    top = (
        ahead + (BOX[0] + TABLE_DEPTH) / 2, 0.0, parameters.table_height - TABLE_THICKNESS / 2
    )  # fmt: skip

    def half(edges: tuple[float, float, float]) -> tuple[float, float, float]:
        return edges[0] / 2, edges[1] / 2, edges[2] / 2

    return (
        (
            SceneObject("box", "box", half(BOX)),
            lambda times: way.at(times) + [0.0, 0.0, BOX[2] / 2 - HANDS_HEIGHT],
        ),
        (SceneObject("table", "box", half(table)), lambda times: np.tile(top, (len(times), 1))),
    )


def _front(human: Human) -> dict[str, Point]:
    """Return points of knees, pelvis and trunk that stay behind the box."""
    known = attachments(human)
    return {
        name: Point(known[name].body, tuple(map(float, known[name].position)), BEHIND[stem])
        for stem in BEHIND
        for name in (stem, f"{stem}_r", f"{stem}_l")
        if name in known
    }
