"""Tasks that are solved again while they are changed, with the solver itself."""

from threading import Event, Thread

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.pages.scene import build_scene
from plantigrade.pages.task_handles import handles_of
from plantigrade.workflows.live_task import live_task, prepare

pytest.importorskip("casadi")

# task, its parameters, and the change of the parameter that is dragged
DRAGGED = [
    ("reach", {}, "target", (0.0, 0.1, 0.1)),
    ("sit-to-stand", {}, "chair_height", 0.05),
    ("squat", {}, "depth", 0.05),
    ("lift", {}, "table_height", 0.1),
    ("side-step", {"side": "l"}, "distance", 0.1),
    ("jump", {}, "jump_height", 0.05),
    ("jump", {}, "distance", 0.2),
    ("hop", {}, "hop_height", 0.03),
    ("walk", {"steps": 2, "step_height": 0.1}, "step_height", 0.05),
    ("walk", {"periodic": True}, "step_length", -0.05),
]


def solved(session):
    """Solve what is asked for."""
    while not session.advance():
        pass
    assert session.message == "", session.message
    return session.shown


def handle(task, shown, name):
    record = shown.run.record
    handles = handles_of(task, record, build_scene(record), shown.values)
    (found,) = (each for each in handles if each.parameter == name)
    return found


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize("task, options, name, change", DRAGGED, ids=lambda x: str(x))
def test_a_handle_moves_with_its_parameter(task, options, name, change):
    base, session = prepare(task, options)
    before = handle(base, solved(session), name)
    if before.axis is None:
        value = tuple(float(x) for x in np.add(before.position, change))
        expected = np.asarray(change)
    else:
        value = before.value + change
        expected = np.asarray(before.axis) * change / before.per_metre
    session.set(name, value)
    after = handle(base, solved(session), name)
    moved = np.subtract(after.position, before.position)
    off = moved - expected if before.axis is None else (moved - expected) @ np.asarray(before.axis)
    assert np.abs(off).max() < 0.02, (moved, expected)


@pytest.mark.slow
@pytest.mark.solver
def test_a_page_is_opened_and_what_is_shown_at_the_end_is_returned(tmp_path):
    stop, opened, made = Event(), [], []

    def session():
        made.append(live_task("reach", show=opened.append, stop=stop, port=8490, duration=1.2))

    thread = Thread(target=session)
    thread.start()
    while not opened:
        assert thread.is_alive()
        stop.wait(0.05)
    stop.set()
    thread.join()
    (run,) = made
    assert run.status == "ok" and run.record.motion.duration == pytest.approx(1.2)
    assert opened[0].startswith("http://localhost:")


def test_strengths_of_the_start_are_those_of_sliders(tmp_path):
    task = tmp_path / "weak.toml"
    task.write_text(
        '[task]\nbase = "squat"\n[impairments]\njoint_strength = ["knee_r=0.5", "hip=0.8"]\n'
    )
    for session in (
        prepare(task, {})[1],
        prepare("squat", {"joint_strength": ("knee_r=0.5", "hip=0.8")})[1],
    ):
        assert session.values["strength of knee_r"] == 50.0
        assert session.values["strength of knee_l"] == 100.0


def test_what_cannot_be_changed_live_is_refused():
    with pytest.raises(ParameterError, match="joint_strength"):
        prepare("walk", {"joint_strength": ("knee_r=weak",)})
    with pytest.raises(ParameterError, match="sped"):
        prepare("walk", {"sped": 1.0})
    with pytest.raises(ParameterError, match="live"):
        prepare("track", {})
    with pytest.raises(ParameterError, match="speed"):
        live_task("walk", speed=-3.0)
