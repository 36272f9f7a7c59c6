"""Walks with loads: what changes against the walk without one, and in which order."""

import pytest

from experiments.cached_results import CachedResults, Result
from experiments.loaded_walks import ANGLES, EXPERIMENT, LOADS, MAX_CHANGE, cases, changes, rows


def walk(place: str, mass: float, effort: float, bend: float = 0.0) -> Result:
    """Return a walk whose leg angles are all so large."""
    return {
        "place": place, "mass": mass, "effort": effort, "swing_moment": 10.0 + mass, "good": True,
        "angles": {name: [bend] * 51 for name in ANGLES}, "cpu": 1.0, "wall": 1.0,
    }  # fmt: skip


def kept(*walks: Result) -> CachedResults:
    cached = CachedResults()
    for each in walks:
        cached.results[f"walks/{each['place'] or 'none'} {each['mass']:g} kg"] = each
    return cached


def test_changes_are_those_against_the_walk_without_load():
    found = changes(kept(walk("", 0, 100.0), walk("feet", 4, 150.0, 2.0)))
    assert found == {("feet", 4): pytest.approx({"effort": 0.5, "swing_moment": 0.4, "angles": 2})}
    assert not changes(kept(walk("feet", 4, 150.0)))


def test_loads_that_cost_less_further_down_and_other_kinematics_are_short():
    bare = walk("", 0, 100.0)
    good = kept(bare, walk("waist", 4, 104.0, 1.0), walk("feet", 4, 130.0, 9.0))
    assert all(row.met is not False for row in rows(good))
    bad = kept(bare, walk("waist", 4, 130.0, MAX_CHANGE + 1.0), walk("feet", 4, 104.0))
    short = [(row.subject, row.quantity) for row in rows(bad) if row.met is False]
    assert short == [("feet", "effort for each kilogram"), ("waist 4 kg", "RMS of leg angles")]
    assert "+30 %" in EXPERIMENT.tables(bad)[0].text()


def test_the_short_form_is_a_part_of_the_whole():
    assert set(cases(True)) < set(cases(False))
    assert len(cases(False)) == 1 + sum(map(len, LOADS.values()))
