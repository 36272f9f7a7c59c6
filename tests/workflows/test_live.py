"""A live session from beginning to end: threads, saving, errors; without a browser."""

from threading import Event

import pytest

from plantigrade.errors import FileError, ParameterError
from plantigrade.pages.live_world import LiveWorld
from plantigrade.workflows import live as module
from plantigrade.workflows.live import live, prepare
from plantigrade.world import Controller, StablePD, Summary

SMALL = {"joints": "42", "feet": "rigid", "rate": 300.0, "control_rate": 50.0}


class Standing(Controller):
    """Holds the posture and ends the session after a while of its time."""

    def __init__(self, stop: Event, until: float = 0.2):
        self.stop, self.until = stop, until

    def __call__(self, state):
        if state.time > self.until:
            self.stop.set()
        return StablePD(state.human.standing()[7:])


def test_a_session_runs_until_it_is_stopped_and_is_a_run():
    stop, said = Event(), []
    run = live(
        controller=Standing(stop), open=False, port=8470, stop=stop, tell=said.append, **SMALL
    )
    assert said[0].startswith("Live at http://localhost:84") and "behind real time" in said[1]
    assert run.status == "ok" and run.kind == "simulate" and run.figures["controller"] == "Standing"
    assert run.record.motion.duration >= 0.2
    assert any("live session" in note for note in run.record.notes)
    assert not any("ground moved" in note for note in run.record.notes)  # it lay still


class Telling(Controller):
    """Holds the posture, and has something to say of it."""

    def __call__(self, state):
        return StablePD(state.human.standing()[7:])

    def summary(self):
        return Summary(("Held the posture.",), {"held_s": 0.2})


def test_a_saved_session_has_what_its_controller_says():
    at = prepare(controller=Telling(), **SMALL)
    at.session.advance(0.2)
    run = at.run()
    assert "Held the posture." in run.record.notes and run.figures["held_s"] == 0.2


def test_the_button_saves_the_run_so_far(monkeypatch):
    class Pressed(LiveWorld):
        """A page whose button is pressed at once, until something was saved."""

        def show(self, stop):
            if len(saved) < 2:
                self.save_requested.set()
            else:
                said.append(self.session.message)
                moved.append(not self.session.paused or bool(self.session.pending))
                stop.set()

    monkeypatch.setattr(module, "LiveWorld", Pressed)

    def save(run):
        saved.append(run)
        if len(saved) == 2:
            raise FileError("there", "is full")
        return run

    stop, saved, said, moved = Event(), [], [], []
    live(open=False, port=8471, stop=stop, tell=lambda _: None, save=save, **SMALL)
    run, _ = saved
    assert "is full" in said[0] and moved[0]  # and the session went on
    assert run.kind == "simulate" and run.record.motion.n_frames >= 1


def test_what_a_controller_raises_ends_the_session():
    def broken(state):
        raise ZeroDivisionError("of the user's own")

    with pytest.raises(ZeroDivisionError, match="own"):
        live(controller=broken, open=False, port=8472, tell=lambda _: None, **SMALL)


def test_what_was_simulated_before_a_fault_is_not_lost(monkeypatch):
    """A controller that raises, a page that raises: the run says so, and is there."""

    def breaks_late(state):
        if state.time > 0.1:
            raise ZeroDivisionError("of the user's own")
        return StablePD(state.human.standing()[7:])

    run = live(controller=breaks_late, open=False, port=8473, tell=lambda _: None, **SMALL)
    assert "ended with a fault (ZeroDivisionError" in run.status and not run.ok
    assert run.record.motion.duration > 0.05

    def show(page, stop):
        while page.session.world.time < 0.1:
            stop.wait(0.01)
        raise IndexError("of the page")

    monkeypatch.setattr(LiveWorld, "show", show)
    run = live(open=False, port=8474, tell=lambda _: None, **SMALL)
    assert "IndexError: of the page" in run.status and run.record.motion.duration > 0.05


def test_bad_input_starts_no_page():
    with pytest.raises(ParameterError, match="stable-pd needs a motion"):
        live(controller="stable-pd", open=False, tell=lambda _: None, **SMALL)
    with pytest.raises(ParameterError, match="not a valid port"):
        live(open=False, port=0, tell=lambda _: None, **SMALL)
