"""Terms by the name that a task file has for them."""

import re

from plantigrade.trajopt.terms import (
    contact,
    device,
    effort,
    external,
    impairment,
    limits,
    momentum,
    posture,
    solid,
    targets,
)
from plantigrade.trajopt.terms.term import Term

_KINDS: tuple[type[Term], ...] = (
    *(contact.Dynamics, contact.Contact, contact.Above, contact.Clearance, contact.Forces),
    *(limits.Limits, limits.Within, limits.PowerLimit),
    *(impairment.Weakness, impairment.Brace, external.Wrench, external.Hold, device.Device),
    *(effort.Torque, effort.Work, effort.AnklePower, effort.Acceleration, effort.Jerk),
    *(posture.Pose, posture.Rest, posture.Quiet, posture.Posture, posture.LumbopelvicRhythm),
    *(posture.Upright, posture.Facing, posture.Symmetry, targets.Reach, targets.CentreOfMass),
    *(momentum.AngularMomentum, solid.SolidLimbs, effort.Endurance),
)
TERMS = {re.sub(r"\B([A-Z])", r"-\1", kind.__name__).lower(): kind for kind in _KINDS}
"""Name of a term in a file → its class, whose fields are the keys."""

RENAMED = {"head-stability": "upright"}  #: Former name of a term → today's
