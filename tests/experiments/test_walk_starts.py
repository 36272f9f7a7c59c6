"""The experiment on strides as starts: which strides there are, what counts, and its table."""

import numpy as np
import pytest

from experiments import walk_starts
from plantigrade import Human
from plantigrade.control.gait.reference import period_of
from plantigrade.control.pendulum import walk_of
from plantigrade.motion import GaitEvent, Motion
from plantigrade.motion.cycles import cut_cycles
from plantigrade.record import Record

WALKED = {"survived": True, "end": "", "seconds": 30.0, "speed": 1.0, "asked": 1.0, "rms_deg": 3.0,
          "forward": True}  # fmt: skip
NAME = "cmu_asfamc/07_01.amc"


@pytest.fixture
def record():
    """A person who stands for three seconds, with strikes of feet in turn."""
    human, time = Human.create(), np.linspace(0.0, 3.0, 301)
    qpos, qvel = np.tile(human.standing(), (301, 1)), np.zeros((301, human.model.nv))
    events = tuple(GaitEvent(0.1 + 0.5 * k, "rl"[k % 2], "heel_strike") for k in range(6))
    return Record(human, Motion(time, qpos, qvel, human.joint_names, events=events))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / NAME).parent.mkdir(parents=True)
    (tmp_path / NAME).touch()
    return tmp_path


def test_every_cycle_of_both_feet_is_a_stride_of_its_own(record):
    cycles = cut_cycles(record.motion.events)
    found = [cut_cycles(stride.motion.events) for stride in walk_starts.strides(record)]
    assert len(cycles) == 4 and {c.side for c in cycles} == {"r", "l"}
    assert [(c.start, c.stop) for (c,) in found] == [(c.start, c.stop) for c in cycles]


def test_a_stride_that_is_no_walk_is_left_out(record, folder, monkeypatch):
    monkeypatch.setattr(walk_starts, "recorded", lambda _: record)
    assert "left_out" in walk_starts.start("pendulum", folder, NAME, 0, 1.0)


def test_strides_that_are_left_out_do_not_count_and_falls_do(record, folder, monkeypatch):
    asked = []

    def start(controller, data, name, number, seconds):
        asked.append((number, seconds))
        fell = {**WALKED, "survived": False, "end": "fell at 3 s", "forward": False}
        return [WALKED, fell, {"left_out": "slow"}, WALKED][number]

    monkeypatch.setattr(walk_starts, "recorded", lambda _: record)
    monkeypatch.setattr(walk_starts, "start", start)
    out = folder / "out"
    walk_starts.run(folder, quick=True, out=out)
    assert asked == [(0, walk_starts.QUICK_DURATION)]
    table = walk_starts.run(folder, out=out)
    figures = table.metrics()
    assert figures["pendulum_people_strides"] == 4.0
    assert figures["pendulum_people_left_out"] == 1.0
    assert figures["pendulum_people_lasted_pct"] == pytest.approx(200.0 / 3.0)
    assert figures["pendulum_all_lasted_forward_pct"] == 100.0
    assert figures["goals_met"] == 0 and "fell at 3 s" in table.text()
    asked.clear()
    assert walk_starts.run(folder, out=out).metrics() == figures and asked == []


@pytest.mark.slow
def test_strides_of_a_recording_begin_at_other_instants_and_walk(data):
    name = walk_starts.QUICK_WALKS["people"][0]
    every = [walk_of(each) for each in walk_starts.strides(walk_starts.recorded(data / name))]
    assert all(period_of(walk)[0] is not None for walk in every)
    assert len({float(walk.motion.qpos[0, 2]) for walk in every}) == len(every) > 1
    assert walk_starts.start("pendulum", data, name, 1, walk_starts.QUICK_DURATION)["survived"]


@pytest.mark.slow
def test_a_person_walks_backward_on_and_on(data):
    """Where left is follows from the body: legs crossed after a second where it was of the walk."""
    found = walk_starts.start("pendulum", data, "cmu_bvh/09_12.bvh", 20, 10.0)
    assert not found["forward"] and found["survived"]
    assert found["speed"] == pytest.approx(found["asked"], rel=0.15)
