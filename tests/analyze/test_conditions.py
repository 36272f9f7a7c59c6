"""The conditions of a task, as the judge of motions sees them: at every frame, in every lap."""

import numpy as np
import pytest

from plantigrade import check as examine
from plantigrade.record import Condition, Record
from tests.analyze.bodies import having
from tests.analyze.standing import standing_record


@pytest.fixture(scope="module")
def standing() -> Record:
    """A person who stands still on both feet, weight shared, and swings the arms a little."""
    return having(standing_record(), qfrc_actuator=None, contact_point=None)


def within(name, quantity, lower, upper, time=(0.0, np.inf), **more) -> Condition:
    """A condition with constant bounds."""
    n = len(time)
    return Condition(name, quantity, time, (lower,) * n, (upper,) * n, **more)


def test_conditions_are_judged_at_every_frame(standing):
    arm = within("arm", "coordinate", -0.1, 0.2, of="arm_flex_r")
    check = examine(having(standing, conditions=(arm,)))
    assert {found.quantity for found in check.findings} == {"condition"} and check.conditions[
        "arm"
    ].bad
    peak = check.conditions["arm"]
    assert peak.value == pytest.approx(np.rad2deg(-0.3), rel=1e-3) and peak.below
    assert peak.limit == pytest.approx(np.rad2deg(-0.1)) and peak.unit == "deg"
    assert peak.time == pytest.approx(1.5 * np.pi / 6.0, abs=0.005)
    sentence = next(f for f in check.findings if f.below).sentence()
    assert "arm is -17.2 deg between" in sentence and "at least -5.73 deg" in sentence
    assert check.figures()["check_conditions_broken"] == 1
    assert "arm (at least)" in check.signals()["check.where"]
    wide = within("arm", "coordinate", -0.3, 0.3, of="arm_flex_r")
    assert examine(having(standing, conditions=(wide,))).ok


def test_a_condition_holds_in_every_lap(standing):
    """The worst lap of a condition is the one that is reported."""
    early = within("arm", "coordinate", -1.0, 1.0, (0.0, 0.2), of="arm_flex_r")
    late = within("arm", "coordinate", -0.1, 1.0, (0.6, 1.0), of="arm_flex_r")
    for conditions in ((early, late), (late, early)):
        check = examine(having(standing, conditions=conditions))
        assert check.conditions["arm"].bad and 0.6 <= check.conditions["arm"].time <= 1.0


@pytest.mark.parametrize(
    "condition, holds",
    [
        (within("speed", "speed", -1.81, 1.81, of="arm_flex_r"), True),
        (within("speed", "speed", -1.5, 1.5, of="arm_flex_r"), False),
        (within("rest", "rest", 0.0, 0.0, (0.3, 0.3)), False),
        (within("height", "com", 0.8, 1.2, axis="z"), True),
        (within("height", "com", 1.2, 1.3, axis="z"), False),
        (within("drift", "com speed", -0.05, 0.05, axis="x"), True),
        (within("toe", "point", -0.001, 0.0, (0.1, 0.1), of="foot_r", axis="z"), False),
        (within("way", "displacement", -0.01, 0.01, of="pelvis_tx"), True),
        (within("swing", "displacement", 0.1, 0.2, (0.0, 0.05), of="arm_flex_r"), False),
        (within("power", "power", -1.0, 1.0, of="knee_angle_r"), True),
        (within("power", "power", 3.0, 4.0, of="arm_flex_r"), False),
        (within("tilt", "speed", -0.01, 0.01, of="pelvis_tilt"), True),
        (within("lap two", "com", 0.8, 1.2, (5.0, 6.0), axis="z"), False),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_every_kind_of_condition(standing, condition, holds):
    check = examine(having(standing, conditions=(condition,)))
    assert check.ok == holds, check.status
    if not holds:
        assert check.status.startswith(condition.name)
