"""The table of forces without plates: its noise, its means, and one walk."""

import mujoco
import numpy as np
import pytest

from experiments import ground_forces
from experiments.given_ground import GROUNDS, on_ground
from experiments.ground_forces import (
    GIVEN_GROUND_PREFIX,
    NOISY_PREFIX,
    ONE_PLATE_PREFIX,
    QUICK_TRIALS,
    with_noise,
)
from experiments.recording_ends import COVERAGE_PREFIX, ERROR_PREFIX, PHASES, cuts, part
from experiments.table import Row
from plantigrade.analyze.gait_forces import STANCE_LOAD
from plantigrade.models import Human
from tests.analyze.plated_walk import analyse, plated_walk, standing_fit


def test_noise_has_the_given_size_and_is_reproducible():
    fit = standing_fit(Human.create(1.7, 70.0), (), 400)
    noisy = with_noise(fit, "a")
    np.testing.assert_array_equal(noisy.qpos, with_noise(fit, "a").qpos)
    assert not np.array_equal(noisy.qpos, with_noise(fit, "b").qpos)
    model, n = fit.human.model, len(fit.time)
    off = np.empty((n, model.nv))
    for f in range(n):
        mujoco.mj_differentiatePos(model, off[f], 1.0, fit.qpos[f], noisy.qpos[f])
    size = np.sqrt(np.mean(off**2, axis=0))
    np.testing.assert_allclose(1e3 * size[:3], 1.0, rtol=1e-6)
    np.testing.assert_allclose(np.rad2deg(size[6:]), 0.3, rtol=1e-6)
    power = np.abs(np.fft.rfft(off[:, 6:], axis=0)) ** 2
    slow = np.fft.rfftfreq(n, fit.time[1]) < 8.0
    assert power[slow].sum() > 0.9 * power.sum()


def test_means_are_of_halves_of_the_people_and_judged(monkeypatch, tmp_path):
    """Settled recordings of r .99, others of r .95: goals of the mean are met, and missed."""

    def rows(path, name):
        r = 0.99 if any(part in name for part in ground_forces.SETTLING_PEOPLE) else 0.95
        return [
            Row(name, prefix + "vertical force, r", r)
            for prefix in ("", NOISY_PREFIX, ONE_PLATE_PREFIX)
        ]

    names = (*ground_forces.WALKS, *ground_forces.MOVEMENTS)
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.setattr(ground_forces, "trial_rows", rows)
    walked = [Row("slope 8° up", GIVEN_GROUND_PREFIX + "vertical force, r", 0.987)]
    monkeypatch.setattr(ground_forces, "given_rows", lambda say: walked)
    monkeypatch.setattr(ground_forces, "walks", lambda data: {})
    table = ground_forces.run(tmp_path)
    means = {(r.subject, r.quantity): r for r in table.rows if r.goal}
    assert len(means) == 8
    settled = means["settled half", "vertical force, r"]
    other = means["other half", NOISY_PREFIX + "vertical force, r"]
    assert settled.value == pytest.approx(0.99) and settled.met
    assert other.value == pytest.approx(0.95) and other.met is False
    assert "of generated walks" in table.text() and "0.987" in table.text()
    assert "OpenGRF" in table.text() and table.metrics()["goals_met"] == 5, "two of the least r"


def test_recordings_are_cut_where_plates_tell_how_the_load_goes_over():
    trial = analyse(plated_walk().fit(), without_plates=True)
    load = trial.withheld[0].force[..., 2] / trial.record().weight
    last = len(load) - 1
    found = cuts(trial)
    edges = [int(f[-1] if f[0] == 0 else f[0]) for f in found]
    assert len(found) >= 6 and all(0 < edge < last for edge in edges)
    assert any(f[0] == 0 for f in found) and any(f[-1] == last for f in found)
    assert np.mean([(load[edge] > STANCE_LOAD).all() for edge in edges]) > 0.8
    short = part(trial.fit, found[0])
    np.testing.assert_array_equal(short.qpos, trial.fit.qpos[found[0]])
    assert short.recording.plates == ()


@pytest.mark.slow
def test_the_pressure_under_a_runner_rolls_like_that_of_a_walker(data):
    """Without its usual path it crept from heel to toes: 22 mm off, ankle moment .40 N m/kg."""
    name = "opensim/running_subject04/run300.trc"
    rows = {row.quantity: row.value for row in ground_forces.trial_rows(data / name, name)}
    assert rows["centre of pressure x, median error"] < 12.0
    assert rows["ankle moment, RMSE"] < 0.25 and rows["knee moment, RMSE"] < 0.30
    assert rows["centre of pressure x in the 90 % band"] > 80.0
    assert rows["ankle moment in the 90 % band"] > 80.0


@pytest.mark.slow
def test_a_walk_over_plates_without_them(data):
    name = min(QUICK_TRIALS, key=lambda name: (data / name).stat().st_size)
    rows = {row.quantity: row.value for row in ground_forces.trial_rows(data / name, name)}
    assert rows["vertical force, r"] > 0.97 and rows["forward force, nRMSE"] < 8.0
    assert rows["centre of pressure x, median error"] < 20.0 and rows["knee moment, r"] > 0.9
    assert rows["vertical force in the 90 % band"] > 75.0
    assert rows[ONE_PLATE_PREFIX + "vertical force, RMSE"] < 0.04
    assert rows[ERROR_PREFIX + PHASES[2]] < 0.13 and rows[COVERAGE_PREFIX + PHASES[2]] > 85.0
    assert rows[NOISY_PREFIX + "noise of the motion"] > 2.0 > rows["noise of the motion"]


@pytest.mark.slow
def test_a_walk_up_a_slope_is_estimated_as_well_as_a_level_one():
    """Its forces are exact; a marker recording of it is fitted with the slope as given."""
    found = on_ground(*GROUNDS["slope 8° up"])
    assert found.vertical_r > 0.95 and found.vertical_rmse < 0.08
    assert found.forward_r > 0.95 and found.moment_r["ankle_angle"] > 0.95
