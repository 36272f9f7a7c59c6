"""Generated walks beside people: the halves of the norms, and what is judged."""

import numpy as np
import pytest

from experiments.cached_results import CachedResults
from experiments.walk_norms import (
    EXPERIMENT,
    HALVES,
    LEG,
    SHAPES,
    beside,
    curve,
    peak_moment,
    rows,
)
from plantigrade.analyze import norms
from plantigrade.models.textbook_gait import ADULT_SPEED, CLASS_SPEEDS

SPEED = 1.3


def walk_of_people(half: str) -> dict:
    """Return the result of a walk whose curves and peak moments are those of a half."""
    relative = 0.435
    figures = {
        "ankle_plantarflexor_nm_kg": peak_moment("ankle", half, SPEED)[0],
        "knee_extensor_early_nm_kg": peak_moment("knee", half, SPEED)[0],
        "arm_swing_deg": 32.0,
        "elbow_range_deg": 20.0,
        "head_forward_deg": 1.0,
        "com_up_down_mm": 40.0,
    }
    usual = {"arm_swing_deg": [16.0, 48.0], "com_up_down_mm": [33.0, 49.0]}
    angles = {name: curve(name, half, relative)[0].tolist() for name in (*LEG, *SHAPES)}
    return {
        "good": True, "cpu": 1.0, "wall": 1.0, "speed": SPEED, "relative": relative,
        "angles": angles, "figures": figures, "usual": usual,
    }  # fmt: skip


def test_halves_share_no_angles():
    for name in LEG:
        free, adult = CLASS_SPEEDS["free"], norms.norm(name, population=norms.ADULTS)
        np.testing.assert_allclose(curve(name, "settling", free)[0], norms.norm(name).mean)
        np.testing.assert_allclose(curve(name, "reporting", ADULT_SPEED)[0], adult.mean)
    used = {c: norms.norm("knee_angle", c).mean for c in norms.SPEED_CLASSES}
    for half, own in (("settling", ("slow", "fast")), ("reporting", ("free", "very_slow"))):
        for c in own:
            difference = curve("knee_angle", half, CLASS_SPEEDS[c])[0] - used[c]
            assert np.abs(difference).max() > 1.0


def test_adults_walk_faster_as_children_do():
    slow, fast = (curve("knee_angle", "reporting", CLASS_SPEEDS[c])[0] for c in ("slow", "fast"))
    theirs = norms.norm("knee_angle", "fast").mean - norms.norm("knee_angle", "slow").mean
    np.testing.assert_allclose(fast - slow, theirs)


def test_people_of_the_reporting_half_differ_from_themselves_by_nothing():
    found = beside(walk_of_people("reporting"), "reporting")
    for name in LEG:
        assert found[f"{name} RMS deg"][0] == pytest.approx(0.0, abs=1e-9)
    assert all(found[f"{name} r"][0] == pytest.approx(1.0) for name in SHAPES)
    own, mean, sd = found["pelvis turn ± deg"]
    assert own == pytest.approx(mean) and sd is not None and sd > 0
    assert beside(walk_of_people("settling"), "reporting")["knee_angle RMS deg"][0] > 3.0


def test_only_the_reporting_half_is_judged(tmp_path):
    cached = CachedResults(tmp_path / "walks.json")
    cached.get("walks/1.3 m/s", lambda: walk_of_people("reporting"))
    short = {r.quantity for r in rows(cached) if r.met is False}
    assert short <= {"knee at loading"}  # adults yield by 14 degrees
    table, _ = EXPERIMENT.tables(cached)
    assert all(half in table.text() for half in HALVES)


def test_a_walk_with_a_stiff_pelvis_is_short_of_its_goals(tmp_path):
    result = walk_of_people("reporting")
    mirrored = (-np.array(result["angles"]["pelvis_tilt"])).tolist()
    result["angles"] |= {"pelvis_tilt": mirrored, "pelvis_rotation": [0.0, 0.1] * 25 + [0.0]}
    cached = CachedResults(tmp_path / "walks.json")
    cached.get("walks/1.3 m/s", lambda: result)
    short = {r.quantity for r in rows(cached) if r.met is False}
    assert {"pelvis_tilt r", "pelvis_rotation r", "pelvis turn ±"} <= short
