"""Changed walks: what changes against the plain one, beside people, and in which order."""

from collections.abc import Mapping
from typing import Any

import pytest

from experiments.cached_results import CachedResults, Result
from experiments.changed_walks import (
    EXPERIMENT,
    JOINTS,
    LEVEL_SHARES,
    MAX_CHANGE,
    PLAIN,
    STRIDES,
    WORK_SHARES,
    Change,
    cases,
    changes,
    changes_of,
    rows,
)


def walk(
    change: Change | None = None, effort: float = 100.0, other: Mapping[str, Any] | None = None
) -> Result:
    """Return a walk with these figures; by default those of the plain one."""
    change = change or Change()
    wave = [1.0, 2.0, 4.0, 1.0]
    return {
        "place": change.place, "mass": change.mass, "effort": effort,
        "swing_moment": 10.0 + change.mass, "good": True, "cpu": 1.0, "wall": 1.0,
        "peaks": dict.fromkeys(JOINTS, 1.0), **dict.fromkeys(WORK_SHARES, list(LEVEL_SHARES)),
        "angles": dict.fromkeys((*JOINTS, "pelvis_tilt"), wave), "stride": 1.4, "stance": 60.0,
        **(other or {}),
    }  # fmt: skip


def kept(part: str, **walks: Result) -> CachedResults:
    cached = CachedResults()
    cached.results[f"{part}/{PLAIN}"] = walk()
    for name, each in walks.items():
        cached.results[f"{part}/{name}"] = each
    return cached


def loaded(place: str, effort: float, bend: float = 0.0) -> Result:
    wave = [x + bend for x in (1.0, 2.0, 4.0, 1.0)]
    angles = dict.fromkeys((*JOINTS, "pelvis_tilt"), wave)
    return walk(Change(place=place, mass=4.0), effort, {"angles": angles})


def test_changes_are_those_against_the_plain_walk_of_their_part():
    found = changes(kept("loads", feet=loaded("feet", 150.0, 2.0)))
    assert found["feet"]["effort"] == pytest.approx(50.0)
    assert found["feet"]["swing_moment"] == pytest.approx(40.0)
    assert found["feet"]["angles"] == pytest.approx(2.0)
    alone = CachedResults()
    alone.results["loads/feet"] = loaded("feet", 150.0)
    assert not changes(alone)


def test_loads_that_cost_less_further_down_and_other_kinematics_are_short():
    good = kept("loads", waist=loaded("waist", 104.0, 1.0), feet=loaded("feet", 130.0, 9.0))
    assert all(row.met is not False for row in rows(good))
    far = MAX_CHANGE + 1.0
    bad = kept("loads", waist=loaded("waist", 130.0, far), feet=loaded("feet", 104.0))
    short = [(row.subject, row.quantity) for row in rows(bad) if row.met is False]
    assert short == [("feet", "effort for each kilogram"), ("waist", "RMS of leg angles")]
    assert "+30 %" in EXPERIMENT.tables(bad)[0].text()


def test_strides_and_shares_of_people_are_goals():
    longer = 1.4 * (1.0 + STRIDES["1.75 m/s"] / 100.0)
    good = kept("speeds", **{"1.75 m/s": walk(other={"stride": longer})})
    assert all(row.met is not False for row in rows(good))
    other = {"stride": 1.0, WORK_SHARES[0]: [10.0, 0.0, 90.0]}
    bad = kept("speeds", **{"1.75 m/s": walk(other=other)})
    assert len([row for row in rows(bad) if row.met is False]) == 4


def test_bent_knees_that_take_less_effort_are_short():
    bent = walk(effort=90.0, other={"peaks": dict(zip(JOINTS, (1.0, 2.0, 1.0), strict=True))})
    short = [row.quantity for row in rows(kept("bent knees", bent=bent)) if row.met is False]
    assert short == ["effort"]


def test_the_short_form_is_a_part_of_the_whole():
    for part in ("loads", "slopes"):
        assert {f"{part}/{PLAIN}"} < set(cases(part, True)) <= set(cases(part, False))
        assert len(cases(part, False)) == len(changes_of(part))
