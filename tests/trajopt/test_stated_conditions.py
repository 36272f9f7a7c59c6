"""Demands of terms reach the checker, terms of one's own and one-sided ones included."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from plantigrade.trajopt import ContactBody, Term, make_task
from plantigrade.trajopt.terms.contact import Contact
from plantigrade.trajopt.terms.limits import Limits
from tests.trajopt.coarse_walk import body, person, solved, task

pytestmark = pytest.mark.solver


@dataclass(frozen=True)
class Brace(Term):
    """A knee that bends no further for a while, and a trunk that turns slowly."""

    most: float
    until: float = np.inf

    def add_to(self, b):
        """Limit a coordinate and a rate."""
        nodes = b.during(0.0, self.until)
        columns = [b.column("knee_angle_r")]
        b.limit(b.family("coordinates"), upper=self.most, columns=columns, nodes=nodes)
        b.limit(b.family("speeds"), -1.0, 1.0, columns=[b.column("lumbar_rotation")])


def stated(motion, of):
    """Return the conditions of a task on a coordinate."""
    given = ContactBody.for_plan(person(), motion.plan)
    return [c for c in motion.conditions(given) if c.of == of]


def test_limits_of_a_term_of_ones_own_are_conditions():
    squat = make_task("squat", person())
    braced = squat.with_terms(Brace(0.4))
    more = set(braced.conditions(body())) - set(squat.conditions(body()))
    found = {c.quantity: c for c in more}
    assert set(found) == {"coordinate", "speed"}
    assert found["coordinate"].upper == (0.4, 0.4)
    assert found["coordinate"].time == (0.0, np.inf)
    assert (found["speed"].lower[0], found["speed"].upper[0]) == (-1.0, 1.0)


def test_a_condition_for_a_while_is_judged_for_that_while():
    squat = make_task("squat", person()).with_terms(Brace(0.4, until=1.0))
    (knee,) = (c for c in stated(squat, "knee_angle_r") if len(c.time) > 1)
    assert knee.time[0] == 0.0
    assert knee.time[-1] == pytest.approx(1.0, abs=0.06)
    assert set(knee.upper) == {0.4}


def test_a_brace_on_one_side_of_a_periodic_walk_makes_a_whole_stride_and_is_judged_there():
    braced = task().with_terms(Limits(ranges={"knee_angle_r": (0.0, 0.2)}))
    assert not braced.plan.mirrored
    made = replace(solved(), task=braced)
    knees = [person().hinge(f"knee_angle_{s}") for s in "rl"]
    assert made.limits.coordinate is not None
    assert made.limits.coordinate[1, knees[0]] == 0.2
    assert made.limits.coordinate[1, knees[1]] > 1.0


def test_of_two_limits_the_narrower_holds():
    weak = task().with_terms(Limits(strength=0.5), Contact(friction=0.4))
    made = replace(solved(), task=weak)
    torque = made.limits.torque
    assert torque is not None
    np.testing.assert_allclose(torque, 0.5 * person().model.jnt_actfrcrange[1:].T)
    assert made.friction == 0.4
