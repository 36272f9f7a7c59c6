"""The experiment on the likeness of walks: its halves, its measures, and its goals."""

import numpy as np
import pytest

from experiments import human_likeness
from experiments.gait_walks import PEOPLE, TURNS
from experiments.human_likeness import CALIBRATION_PEOPLE, HALVES, walks_of_half
from experiments.walk_measures import differences, vertical_force
from plantigrade import Human
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.site import contact_sites
from plantigrade.motion import GaitEvent, Motion
from plantigrade.record import Record

MOMENT = (-np.sin(np.linspace(0.0, np.pi, 101))).tolist()
RECORDED = {
    "first_peak": 1.1,
    "trough": 0.8,
    "second_peak": 1.1,
    "raw_peak": 1.2,
    "ankle": MOMENT,
    "knee": MOMENT,
    "hip": MOMENT,
    "knee_at_strike": 8.0,
    "least_knee": 2.0,
    "com_height": 0.95,
    "com_excursion": 0.04,
    "trunk": 5.0,
    "head": 2.0,
    "trunk_range": 4.0,
    "head_range": 6.0,
    "double_support": 22.0,
    "step_width": 0.1,
}


def test_every_straight_walk_is_in_one_half_and_no_person_is_in_both():
    halves = [set(walks_of_half(half, quick=False)) for half in HALVES]
    assert not halves[0] & halves[1]
    straight = {name for names in PEOPLE.values() for name in names} - set(TURNS)
    assert halves[0] | halves[1] == straight
    for person, names in PEOPLE.items():
        own = set(names) - set(TURNS)
        assert own <= halves[0 if person in CALIBRATION_PEOPLE else 1]
    for half, every in zip(HALVES, halves, strict=True):
        assert set(walks_of_half(half, quick=True)) < every


def test_a_walk_like_the_recorded_one_has_no_differences():
    found = differences(RECORDED, RECORDED)
    for name, value in found.items():
        if name != "raw_peak":
            same = 1.0 if name.endswith(("_ratio", "_r")) else 0.0
            assert value == pytest.approx(same, abs=1e-9), name


def test_differences_have_the_sign_and_size_of_what_differs():
    own = {**RECORDED, "first_peak": 1.32, "knee_at_strike": 14.0, "com_height": 0.93}
    own["ankle"] = (1.1 * np.array(MOMENT)).tolist()
    found = differences(own, RECORDED)
    assert found["first_peak_ratio"] == pytest.approx(1.2)
    assert found["knee_at_strike"] == pytest.approx(6.0)
    assert found["com_height"] == pytest.approx(-0.02)
    assert found["ankle_moment_peak_ratio"] == pytest.approx(1.1)
    assert found["ankle_moment_r"] == pytest.approx(1.0)
    assert found["knee_at_strike_sd"] > 0.0 and found["ankle_moment_sd"] > 0.0


def test_the_force_of_a_stance_has_its_two_peaks_and_the_trough():
    human = Human.create()
    time = np.arange(0.0, 4.0, 0.01)
    qpos = np.tile(human.standing(), (len(time), 1))
    sites = contact_sites(human)
    force = np.zeros((len(time), len(sites), 3))
    events = []
    for k, side in enumerate(SIDES):
        phase = time - 0.5 * k
        stance = np.mod(phase, 1.0) < 0.6
        up = 0.9 - 0.2 * np.cos(2 * np.pi * np.mod(phase, 1.0) / 0.3)
        site = [s.side for s in sites].index(side)
        force[:, site, 2] = np.where(stance, up * human.mass * GRAVITY, 0.0)
        for start in np.arange(0.5 * k, 3.9, 1.0):
            events.append(GaitEvent(start, side, "heel_strike"))
            if start + 0.6 < 4.0:
                events.append(GaitEvent(start + 0.6, side, "toe_off"))
    events = tuple(sorted(events, key=lambda e: e.time))
    velocity = np.zeros((len(time), human.model.nv))
    motion = Motion(time, qpos, velocity, human.joint_names, events=events)
    record = Record(human, motion, sites=sites, contact_force=force)
    found = vertical_force(record)
    assert found["first_peak"] == pytest.approx(1.1, abs=0.01)
    assert found["trough"] == pytest.approx(0.7, abs=0.01)
    assert found["second_peak"] == pytest.approx(1.1, abs=0.01)


def test_goals_count_on_the_validation_half_alone(monkeypatch, tmp_path):
    def likeness(controller, data, name):
        own = {**RECORDED, "raw_peak": 2.0, "peak_20_hz": 1.2}
        if name.startswith("c3d"):
            own["com_height"] += 0.05
        found = differences(own, RECORDED)
        return {"survived": True, "own": own, "recorded": RECORDED, "differences": found}

    monkeypatch.setattr(human_likeness, "likeness", likeness)
    for names in PEOPLE.values():
        for name in names:
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).touch()
    table = human_likeness.run(tmp_path, out=tmp_path / "out")
    judged = {r.subject for r in table.rows if r.met is not None}
    assert judged == {"pendulum, validation"}
    figures = table.metrics()
    assert figures["pendulum_calibration_height_of_the_centre_of_mass_cm"] == pytest.approx(0.0)
    assert figures["goals_met"] == figures["goals"]
    assert "16_15.amc" in (tmp_path / "out" / "human-likeness.html").read_text("utf-8")


def test_a_fall_is_counted_and_reported(monkeypatch, tmp_path):
    monkeypatch.setattr(
        human_likeness, "likeness", lambda *_: {"survived": False, "end": "fell at 2.0 s"}
    )
    name = walks_of_half(HALVES[0], quick=True)[0]
    (tmp_path / name).parent.mkdir(parents=True)
    (tmp_path / name).touch()
    table = human_likeness.run(tmp_path, quick=True)
    assert table.metrics()["pendulum_calibration_walks_that_fell"] == 1.0
    assert "fell at 2.0 s" in table.text()
