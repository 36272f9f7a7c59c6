"""The experiments on walking: what they do, keep and print, without a step walked."""

import sys
from typing import cast

import numpy as np
import pytest

from experiments import (
    feet_while_walking,
    human_pushes,
    landing_laws,
    push_any_controller,
    push_map,
    push_shares,
    walk_battery,
)
from experiments.cached_results import CachedResults
from experiments.human_pushes import COLUMNS, FILE, aside, pushes
from experiments.walk_outcome import Landing, WalkOutcome
from experiments.walkers import make_named, walks_as
from experiments.walking import recorded, refusal
from plantigrade.errors import FileError, ParameterError, PlantigradeError
from plantigrade.record import Record

WALKED = {
    "survived": True,
    "end": "",
    "seconds": 60.0,
    "speed": 1.05,
    "asked": 1.1,
    "rms_deg": 3.0,
    "far": 63.0,
    "aside": -0.1,
    "steps": 100,
    "back": 1.0,
}


@pytest.fixture
def made(monkeypatch):
    """Calls of the walks and pushes."""
    done = []

    def does(module, name, result):
        def work(*item, **how):
            done.append((name, *item, *how.values()))
            return result(*item) if callable(result) else result

        monkeypatch.setattr(module, name, work)

    for name in ("flat", "kerb", "legs", "body", "recording"):
        does(walk_battery, name, WALKED)
    does(walk_battery, "hill", {**WALKED, "level": 1.1, "reached": True})
    does(walk_battery, "uneven", lambda *item: {**WALKED, "survived": item[3] % 2 == 0})
    one = {"gaps": [], "tried": 5, "open": False}
    does(push_map, "limit", lambda *item: {**one, "force": item[3] * 100 + 200, "on_feet": 500.0,
                                           "impacts": {"200": 4.0, "300": item[3] * 10, "400": 9.0},
                                           "bends": {"200": 20.0, "300": item[3] * 30, "400": 70.0},
                                           "leans": {"200": 10.0, "400": 80.0},
                                           "grid": item[5]})  # fmt: skip
    does(push_map, "standing", {"force": 100.0, "gaps": [60.0], "grid": 20.0})
    given = {"survived": True, "withstood": True, "end": "", "detour": 0.4, "first": 0.2,
             "step": 2.0, "people": [0.5, 0.1, 2.0], "speed": [1.0, 1.1]}  # fmt: skip
    does(human_pushes, "give", given)
    toured = {"completed": False, "reached": 3, "of": 12, "end": "fell", "seconds": 17.0,
              "straight": True, "punches": []}  # fmt: skip
    does(push_any_controller, "toured", lambda *item: {**toured, "of": item[3]})
    curve = list(np.linspace(0.0, -1.5, feet_while_walking.N_CURVE_POINTS))
    heel = {"heel": [9, 10]}
    does(feet_while_walking, "level", {**WALKED, **heel, "moment": curve, "cycles": 8})
    does(feet_while_walking, "bumps", {**WALKED, **heel})
    does(feet_while_walking, "pushed", {**WALKED, "withstood": True})
    return done


def test_the_battery_is_walked_once_and_its_short_form_gives_way(made, tmp_path):
    walk_battery.run(out=tmp_path, quick=True)
    short = len(made)
    assert short < 10
    table = walk_battery.run(out=tmp_path, parts=("all tiles", "flat", "slopes"))
    assert len(made) == short + 5 * 10 + 1 + 6
    figures = table.metrics()
    assert figures["pendulum_tiles_3_cm_walked_pct"] == 50.0  # every other seed, of the long ones
    assert figures["pendulum_flat_speed_by_the_recorded"] == pytest.approx(1.05 / 1.1)
    assert figures["pendulum_flat_drift_aside_in_a_minute_m"] == pytest.approx(0.1)
    made.clear()
    again = walk_battery.run(out=tmp_path, parts=("all tiles", "flat"), controllers=("pendulum",))
    assert made == [] and again.metrics() == figures
    assert "5 of 10" in (tmp_path / "walk-battery.html").read_text("utf-8")


def test_standing_and_walks_on_uneven_ground_are_noted_and_not_counted(made, tmp_path, monkeypatch):
    def recording(controller, data, name, seconds):
        found = {"left_out": "stands, no walk"} if "A01" in name else WALKED
        return {**found, "survived": "07" not in name} if found is WALKED else found

    monkeypatch.setattr(walk_battery, "recording", recording)
    for name in ("HC032A01.c3d", "07_01.amc", "16_15.amc"):
        (tmp_path / name).touch()
    monkeypatch.setattr(
        walk_battery, "RECORDINGS", ("HC032A01.c3d", "07_01.amc", "16_15.amc", "none")
    )
    table = walk_battery.run(tmp_path, parts=("recordings",))
    assert table.metrics()["pendulum_recordings_walked_pct"] == 50.0
    assert "stands, no walk" in table.text()


def test_every_controller_that_is_named_walks(made, tmp_path):
    table = walk_battery.run(parts=("flat",), controllers=("pendulum", "pendulum:energy"))
    assert [item[1] for item in made] == ["pendulum", "pendulum:energy"]
    assert "pendulum_energy_flat_falls" in table.metrics()


def test_landing_laws_are_compared_on_one_battery_and_stay_out_of_the_others(
    made, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        landing_laws,
        "on_ground",
        lambda law, *item: {**WALKED, "fine": not law.endswith("energy"), "survived": True},
    )
    fell = {**WALKED, "survived": False, "fine": False, "end": "fell"}
    monkeypatch.setattr(
        landing_laws,
        "pushed",
        lambda law, *item: {**WALKED, "fine": True} if law.endswith("divergent") else fell,
    )
    table = walk_battery.run(out=tmp_path, parts=("flat", "laws"))
    figures = table.metrics()
    assert figures["pendulum_divergent_laws_walked_pct"] == 100.0
    assert figures["pendulum_energy_laws_walked_pct"] == 0.0
    assert figures["pendulum_energy_both_laws_walked_pct"] == 50.0
    assert "pendulum_energy_flat_falls" not in figures
    page = (tmp_path / "walk-battery.html").read_text("utf-8")
    assert "Landing laws" in page and "16 of 16" in page and "8 of 16" in page


def test_the_map_has_every_direction_at_every_phase_and_the_finest_grid_counts(
    made, tmp_path, monkeypatch
):
    assert (push_map.N_DIRECTIONS_FULL, push_map.N_PHASES_FULL) == (16, 10)
    few = {"N_DIRECTIONS_FULL": 6, "N_PHASES_FULL": 5, "N_DIRECTIONS": 4, "N_PHASES": 2}
    for name, number in few.items():
        monkeypatch.setattr(push_map, name, number)
    push_map.run(out=tmp_path, parts=("force",))
    assert len(made) == 8
    assert [item[4] for item in made[:2]] == [0.0, 0.0], "one phase after the other"
    table = push_map.run(out=tmp_path, parts=("full", "standing"))
    assert len(made) == 8 + 30 + 6
    figures = table.metrics()  # of forces that the fixture makes
    assert figures["pendulum_force_worst_n"] == 200.0 and figures["pendulum_force_best_n"] == 280.0
    assert figures["pendulum_force_cases"] == 30, "none of the coarse map"
    assert figures["pendulum_force_hardest_landing_pushes_up_to_300_n_bw"] == pytest.approx(8.0)
    assert figures["pendulum_force_back_bent_at_most_pushes_up_to_300_n_deg"] == pytest.approx(24.0)
    assert figures["pendulum_force_trunk_leans_at_most_pushes_up_to_300_n_deg"] == 10.0
    (hard,) = push_map.hard_landings(CachedResults(tmp_path / "push-map.json"))
    assert {line[2] for line in hard.lines} == {"300", "400"}
    assert all(float(line[3]) > push_map.MAX_IMPACT for line in hard.lines)
    assert any("fails at 60 N" in note for note in table.notes)
    page = (tmp_path / "push-map.html").read_text("utf-8")
    assert "Map of pushes: pendulum, force" in page and page.count("% of the cycle") >= 5


def test_half_of_the_pushes_of_a_force_are_withstood_where_the_shares_cross(tmp_path, monkeypatch):
    def outcome(controller, data, duration, phase, degrees, force):
        hard = force == 275.0 and degrees == 90.0
        held = force < 400.0 and not hard
        return {"withstood": held, "survived": True, "impact": 7.0 if hard else 3.0}

    monkeypatch.setattr(push_shares, "outcome", outcome)
    figures = push_map.run(out=tmp_path, parts=("shares",)).metrics()
    assert figures["pendulum_shares_cases"] == 7 * 4 * 8
    assert figures["pendulum_shares_withstood_275_n_pct"] == pytest.approx(87.5)
    assert figures["pendulum_shares_withstood_425_n_pct"] == 0.0
    half = figures["pendulum_shares_force_at_which_half_are_withstood_n"]
    assert half == pytest.approx(375.0 + 50.0 * 0.375 / 0.875)  # never more than of a lighter one
    assert figures["pendulum_shares_hardest_landing_pushes_up_to_300_n_bw"] == 7.0
    share = figures["pendulum_shares_landings_beyond_6_bw_pushes_up_to_300_n_pct"]
    assert share == pytest.approx(100.0 * 4 / 64)
    weak = {"withstood": False, "survived": False, "impact": 0.0}
    monkeypatch.setattr(push_shares, "outcome", lambda *item: weak)
    figures = push_map.run(out=tmp_path / "weak", parts=("shares",)).metrics()
    assert not any("half" in name for name in figures), "it is below every force that was tried"


def test_people_are_pushed_at_their_phase_with_their_force(made, tmp_path):
    folder = tmp_path / "pushes"
    folder.mkdir()
    row = dict.fromkeys(COLUMNS, "0")
    row |= {"height": "170", "weight": "60", "sex": "2", "actual_speed": "1100",
            "push_force_not_normalized": "34", "push_duration": "0.2", "push_direction": "1",
            "push_start": "-10", "maximal_detour_distance": "430"}  # fmt: skip
    lines = [",".join(["", *row]), ",".join(["Subject01", *row.values()])]
    (tmp_path / FILE).write_text("\n".join([*lines, lines[1]]) + "\n", encoding="utf-8")
    one = pushes(tmp_path / FILE)[0]
    assert (one.height, one.mass, one.sex, one.speed) == (1.7, 60.0, "female", 1.1)
    assert one.force == pytest.approx(170.0) and one.side == "l" and one.detour == 0.43
    assert one.phase == pytest.approx(0.95)  # before the strike: late in the cycle before
    table = push_map.run(tmp_path, parts=("people",), quick=True)
    assert len(made) == 2
    assert table.metrics()["pendulum_pushes_of_people_survived_pct"] == 100.0
    bad = tmp_path / "bad.csv"
    bad.write_text("height\n1\n", encoding="utf-8")
    with pytest.raises(FileError, match="no table of pushes"):
        pushes(bad)


def test_the_published_pushes_are_those_of_the_publication(data):
    every = pushes(data / FILE)
    assert len(every) == 626
    assert np.mean([p.force for p in every]) == pytest.approx(172.0, rel=0.02)
    assert np.mean([p.force * p.duration for p in every]) == pytest.approx(34.2, rel=0.01)
    assert np.mean([p.force * p.duration / p.mass for p in every]) == pytest.approx(0.52, abs=0.01)
    assert np.mean([p.detour for p in every]) == pytest.approx(0.43, abs=0.01)


def test_lateral_offsets_are_relative_to_the_stride_before_and_by_steps():
    time = 0.01 * np.arange(1, 601)
    com = np.zeros((600, 3))
    com[:, 1] = 0.05 - 0.3 * np.exp(-(((time - 3.5) / 0.3) ** 2))
    landings = tuple(Landing(t, "r", (0.0, 0.0), True) for t in (2.0, 3.2, 3.7))
    none = np.full(600, np.nan)
    found = WalkOutcome(True, "", time, com, none, landings, (2.4, 2.6), 1.0, 1.0, 1.0)
    far, first, step = aside(found, -1.0)
    assert far == pytest.approx(0.3, abs=0.002) and step == 2.0
    assert first == pytest.approx(0.3 * np.exp(-1.0), abs=0.01)


OUTSIDE = """
class Mine:
    def __init__(self, record): raise RuntimeError("boom")
"""


@pytest.mark.parametrize(
    ("word", "text", "said"),
    [
        ("mine.py:Other", OUTSIDE, "mine.py has no function or class 'Other'"),
        ("mine.py:__name__", OUTSIDE, "no function or class"),
        ("mine.py:Mine", "def (", "mine.py:Mine: SyntaxError"),
        ("mine.py:Mine", "raise SystemExit(0)", "SystemExit"),
        ("their.py:Mine", OUTSIDE, "there is no file 'their.py'"),
        ("mine.py", OUTSIDE, "FILE.py:NAME"),
        ("nothing.npz", OUTSIDE, "no such file"),
    ],
)
def test_a_controller_that_is_not_there_is_refused_before_anything_is_measured(
    made, tmp_path, monkeypatch, word, text, said
):
    monkeypatch.chdir(tmp_path)
    for name in list(sys.modules):
        if name.startswith("plantigrade_outside"):
            monkeypatch.delitem(sys.modules, name)
    (tmp_path / "mine.py").write_text(text)
    with pytest.raises(PlantigradeError, match=said):
        push_any_controller.run(controllers=("pendulum", word), out=tmp_path / "out")
    assert not made and not (tmp_path / "out").exists()


def test_without_a_measurable_case_the_first_reason_is_reported(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "boom.py").write_text(OUTSIDE)
    monkeypatch.setattr(
        push_any_controller, "toured", lambda word, *_: make_named(word)(cast(Record, None))
    )
    with pytest.raises(ParameterError, match="none of 1 cases could be .*boom.py:Mine: Runtime"):
        push_any_controller.run(parts=("tour",), quick=True, controllers=("boom.py:Mine",))


def test_any_controller_has_its_own_table(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(OUTSIDE)
    words = ("pendulum", "mine.py:Mine")
    table = push_any_controller.run(out=tmp_path, parts=("tour",), controllers=words)
    assert sum(item[0] == "toured" for item in made) == 20
    assert len(table.sheets) == 2  # figures of both controllers, and the torque limits
    figures = table.metrics()
    assert figures["mine_py_mine_waypoints_reached_pct"] == 25.0
    assert figures["pendulum_tours_completed_pct"] == 0.0


def test_feet_are_compared_on_the_level_on_bumps_and_pushed(made, tmp_path):
    table = feet_while_walking.run(out=tmp_path)
    assert len(made) == 3 + 15 + 24
    figures = table.metrics()
    assert figures["pendulum_rigid_withstood_80_n_pct"] == 100.0
    assert figures["pendulum_multi_segment_ankle_moment_peak_n_m_kg"] == 1.5
    assert figures["pendulum_two_segment_landings_on_the_heel_pct"] == 90.0
    assert "Ankle moment" in (tmp_path / "feet-while-walking.html").read_text("utf-8")


def test_a_curve_is_cut_at_the_strikes_of_a_foot():
    time = np.linspace(0.0, 6.0, 601)
    landings = [Landing(t, "r", (0.0, 0.0), True) for t in (1.0, 2.5, 3.5, 5.0)]
    curves = feet_while_walking.cut(time, time, landings)  # not from the one at 1 s on
    assert [c[0] for c in curves] == [2.5, 3.5] and curves[1][-1] == pytest.approx(5.0)


def test_the_short_forms_are_few(made, tmp_path):
    for module in (push_map, push_any_controller, feet_while_walking):
        module.run(quick=True)
    assert len(made) < 10


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("deepmimic/humanoid3d_stealthy_walk.txt", ""),
        ("cmu_asfamc/131_12.amc", "spins on one foot"),
    ],
)
def test_spins_are_refused_and_feet_on_their_toes_are_none(data, name, why):
    """A foot whose sole is upright has no heading along its length."""
    assert refusal(walks_as("pendulum", recorded(data / name))) == why
