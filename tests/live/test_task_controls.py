"""Controls of tasks: within what a task accepts, and back to its parameters."""

import pytest

from plantigrade.live.task_controls import STRENGTH, Control, controls_of, options_from
from plantigrade.trajopt import TASKS
from plantigrade.trajopt.tasks.gait_settings import WalkSettings
from plantigrade.trajopt.tasks.settings import ReachSettings

KINDS = [*(kind() for kind in TASKS.values()), WalkSettings(periodic=True), WalkSettings(slope=0.1)]


def values_of(controls):
    return {control.name: control.value for control in controls}


@pytest.mark.parametrize(
    "parameters", KINDS, ids=lambda p: "-".join([type(p).__name__, *p.changed])
)
def test_untouched_controls_change_nothing(parameters):
    controls = {c.name: c for c in controls_of(parameters)}
    options = options_from(controls, values_of(controls.values()))
    for name, value in options.items():
        given = getattr(parameters, name)
        assert value == (pytest.approx(given) if isinstance(given, float) else given), name


@pytest.mark.parametrize(
    "parameters", KINDS, ids=lambda p: "-".join([type(p).__name__, *p.changed])
)
def test_a_task_accepts_both_ends_of_every_slider(parameters):
    controls = {c.name: c for c in controls_of(parameters)}
    sliders = [c for c in controls.values() if c.is_number and not c.name.startswith(STRENGTH)]
    for control in sliders:
        for end in (control.low, control.high):
            assert control.allows(end)
            option = options_from(controls, {control.name: end})
            fixed = {"periodic": True} if getattr(parameters, "periodic", False) else {}
            type(parameters)(**fixed, **option)


def test_a_value_beyond_the_usual_widens_its_slider():
    (speed,) = (c for c in controls_of(WalkSettings(speed=0.35)) if c.name == "speed")
    assert speed.low == 0.35


def test_what_a_control_allows():
    number = Control(name="n", label="n", low=0.0, high=2.0, value=1.0)
    default = Control(name="d", label="d", low=0.0, high=2.0)
    whole = Control(name="w", label="w", low=1, high=5, whole=True, value=2)
    switch = Control(name="s", label="s", value=False)
    side = Control(name="side", label="side", value="r", options=("r", "l"))
    (target,) = (c for c in controls_of(ReachSettings()) if c.is_point)
    allowed = [(number, 2), (default, None), (whole, 3.0), (switch, True), (side, "l")]
    allowed += [(target, None), (target, (0.5, 0.1, 1))]
    refused = [(number, 2.1), (number, None), (number, True), (number, float("nan")), (whole, 2.5)]
    refused += [(switch, 1.0), (side, "x"), (side, ["r"]), (target, (0.1, 0.2)), (target, "here")]
    refused += [(target, (0.1, 0.2, float("inf"))), (number, "1")]
    assert all(control.allows(value) for control, value in allowed)
    assert not any(control.allows(value) for control, value in refused)


def test_degrees_and_strengths_become_options():
    controls = {c.name: c for c in controls_of(WalkSettings())}
    values = {"turn": 90.0, "steps": 6.0, f"{STRENGTH}knee_r": 50.0, f"{STRENGTH}hip_l": 100.0}
    options = options_from(controls, values)
    assert options["turn"] == pytest.approx(1.5707963)
    assert options["steps"] == 6 and isinstance(options["steps"], int)
    assert options["joint_strength"] == ("knee_r=0.5",)


def test_a_weak_joint_of_the_start_stays_weak():
    controls = {c.name: c for c in controls_of(WalkSettings(), {"knee_r": 50.0})}
    options = options_from(controls, values_of(controls.values()))
    assert options["joint_strength"] == ("knee_r=0.5",)
