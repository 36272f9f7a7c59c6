"""The table of generated running beside a recorded runner."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.running_table import Gait, landing_speed, rows_beside
from plantigrade.analyze.feet import foot_path
from plantigrade.models import Human
from plantigrade.motion import GaitEvent, Motion
from plantigrade.record import Record


def gait() -> Gait:
    s = np.linspace(0.0, 2.0 * np.pi, 101)
    angles = {"hip_flexion": np.cos(s), "knee_angle": 15.0 - 20.0 * np.cos(s)}
    force = np.maximum(np.sin(2.0 * s), 0.0)
    curves = {**angles, "ankle_angle": np.sin(s), "up": 2.3 * force, "forward": 0.3 * np.sin(s)}
    return Gait(165.0, 0.30, 0.8, curves)


def test_a_gait_compared_with_itself_misses_only_the_knee_at_strike():
    rows = {r.quantity: r for r in rows_beside("3 m/s", gait(), gait())}
    assert {q for q, r in rows.items() if r.met is False} == {"knee at strike"}  # -5 degrees
    assert rows["peak vertical force"].note == "+0 %"
    assert rows["knee_angle, r"].value == pytest.approx(1.0)


def test_a_flat_force_and_a_long_contact_miss_their_goals():
    low = {**gait().curves, "up": 0.8 * gait().curves["up"]}
    made = replace(gait(), contact=0.36, curves=low)
    rows = {r.quantity: r for r in rows_beside("3 m/s", made, gait())}
    assert rows["peak vertical force"].note == "-20 %" and not rows["peak vertical force"].met
    assert rows["contact time"].note == "+20 %" and not rows["contact time"].met


def test_the_heel_comes_down_as_fast_as_the_body_falls():
    human, time = Human.create(1.7, 70.0), np.linspace(0.0, 0.5, 51)
    qpos = np.repeat(human.standing()[None], len(time), axis=0)
    qpos[:, 2] -= 0.7 * time
    events = [GaitEvent(0.3, "r", "heel_strike"), GaitEvent(0.0, "l", "heel_strike")]
    still = np.zeros((len(time), human.model.nv))
    motion = Motion(time, qpos, still, human.joint_names, events=tuple(events))
    heel = foot_path(human, motion.qpos).heel
    assert landing_speed(Record(human, motion), heel) == pytest.approx(0.7)
