"""Experiments on synthesised motions: what is kept, what is judged, and one motion end to end."""

import json
from dataclasses import replace

import numpy as np
import pytest

from experiments import synthesis_bench as bench
from experiments import synthesis_cases as cases
from experiments import synthesis_fidelity as fidelity
from experiments.cached_results import CachedResults, code_version
from experiments.random_requests import random_request
from experiments.synthesis_planes import growth_row
from experiments.synthesis_trial import crude, task_of, why
from plantigrade.analyze import agreement_with_norm, norms
from plantigrade.analyze.movement import movement_figures
from plantigrade.errors import FileError, ParameterError
from plantigrade.trajopt.transcription.mesh import nodes_of

STAGE = {
    "name": "first try",
    "solver": "interior-point",
    "nodes": 61,
    "status": "solved",
    "end": [],
}
GOOD = {
    "success": True, "ok": True, "good": True, "status": "solved", "verdict": "ok", "cpu": 2.0,
    "wall": 3.0, "nodes": 61, "duration": 3.0, "iterations": 30, "objective": 1.0,
    "violation": 1e-9, "worst": "", "stages": [{**STAGE, "seconds": 2.0, "iterations": 30}],
}  # fmt: skip
FAILED = GOOD | {
    "success": False, "good": False, "status": "stalled", "violation": 0.2,
    "worst": "z of toe_r is off by 200 mm",
    "stages": [{**STAGE, "status": "stalled", "seconds": 2.0, "iterations": 30, "end": ["30: …"]}],
}  # fmt: skip
PEOPLE = 5 * 3 * 3


# What is kept -------------------------------------------------------------------------------------


def test_results_are_made_once_and_found_again(tmp_path):
    path, made = tmp_path / "below" / "results.json", []

    def make():
        made.append(1)
        return {"x": np.float64(2.5), "bad": float("nan"), "curve": np.arange(3.0), "ok": np.True_}

    first = CachedResults(path).get("a/b", make)
    again = CachedResults(path).get("a/b", make)
    assert made == [1] and first == again
    assert again["x"] == 2.5 and again["bad"] is None and again["curve"] == [0.0, 1.0, 2.0]
    assert again["ok"] is True and again["code"] == code_version()
    assert CachedResults(path).notes() == []


def test_a_run_that_stops_keeps_what_is_done(tmp_path):
    path = tmp_path / "results.json"
    kept = CachedResults(path)
    kept.get("one", lambda: {"x": 1})
    with pytest.raises(KeyboardInterrupt):
        kept.get("two", lambda: (_ for _ in ()).throw(KeyboardInterrupt))
    assert list(CachedResults(path).results) == ["one"]


def test_results_of_other_code_are_named(tmp_path):
    path = tmp_path / "results.json"
    path.write_text(json.dumps({"a": {"x": 1, "code": "old"}, "b": {"code": code_version()}}))
    assert "1 of 2 results" in CachedResults(path).notes()[0]


def test_a_broken_file_is_refused(tmp_path):
    path = tmp_path / "results.json"
    path.write_text("[1, 2")
    with pytest.raises(FileError, match="delete it to start again"):
        CachedResults(path)
    assert CachedResults(path, overwrite=True).results == {}


def test_a_refused_task_is_a_result():
    assert "stalled; z of toe_r is off by 200 mm" in why(FAILED)
    assert why(GOOD | {"verdict": ["it slips"], "good": False}) == "it slips"


# Time and success ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def human():
    return cases.person()


def test_the_walk_takes_three_seconds_on_enough_nodes(human):
    task = cases.walk_of(human, cases.Extent())
    assert task.plan.duration == pytest.approx(3.0, abs=1e-3)
    assert len(nodes_of(task.plan, task.nodes_per_second)) >= cases.N_NODES
    fine = cases.with_nodes(task, cases.N_FINE_NODES)
    assert 301 <= len(nodes_of(fine.plan, fine.nodes_per_second)) < 330


def test_the_crude_guess_knows_nothing_of_walking(human):
    from plantigrade.trajopt import ContactBody

    task = crude(cases.walk_of(human, cases.Extent()))
    body = ContactBody.for_plan(human, task.plan)
    q = task.guess(body, task.plan, np.linspace(0.0, 3.0, 7))
    assert np.ptp(q[:, 6:], axis=0).max() < 1e-9, "no joint moves"
    assert np.ptp(q[:, 3]) > 1.5, "but the body does"


def test_random_requests_repeat_and_are_ones_that_every_task_takes():
    asked = [random_request(seed) for seed in range(24)]
    assert {r.task for r in asked} >= {"walk", "sit-to-stand", "squat", "reach", "jump", "take-off"}
    assert len({(r.joints, r.feet) for r in asked}) > 6
    assert random_request(7) == asked[7] != asked[19]
    for r in asked[:12]:
        assert 45.0 <= r.mass <= 110.0 and 1.45 <= r.height <= 1.95
        assert task_of(r.task, r.human, r.options).plan.duration > 0.3
        assert r.task in r.title and f"{r.height:.2f} m" in r.title


def test_random_walks_are_in_range_and_repeat():
    drawn = np.array([cases.random_walk(seed) for seed in range(50)])
    assert drawn[:, 0].min() >= 0.3 and drawn[:, 0].max() <= 0.75
    assert drawn[:, 1].min() >= 0.4 and drawn[:, 1].max() <= 1.6
    assert np.all(np.ptp(drawn, axis=0) > [0.4, 1.1])
    assert cases.random_walk(7) == cases.random_walk(7)


def test_stairs_go_up_and_down_with_every_number_of_treads():
    keys = [key for key, _ in cases.stairs(cases.Extent())]
    assert len(set(keys)) == 40
    for treads in range(2, 7):
        own = [key for key in keys if f"/{treads} treads" in key]
        assert len(own) == 8 and sum("+" in key for key in own) == 4
    assert len(list(cases.stairs(cases.QUICK_EXTENT))) == 2


def test_goals_are_those_that_were_set():
    goals = {n: (p.seconds, p.share) for n, p in cases.PARTS.items()}
    assert goals["crude walk"] == (4.0, 0.95) and goals["ipopt"][0] == 20.0
    assert goals["warm"][0] == 0.5 and goals["fine"][0] == 12.0
    assert goals["random"] == (4.0, 1.0)
    assert {goals[n][0] for n in ("sit-to-stand", "side-step", "jump")} == {4.0}


def test_one_failure_of_twenty_is_allowed(tmp_path):
    def table(good):
        results = {f"walk/noise 0.1/{k}": GOOD if k < good else FAILED for k in range(20)}
        path = tmp_path / bench.EXPERIMENT.file
        path.write_text(json.dumps(results))
        kept = CachedResults(path)
        return {r.quantity: r for r in bench.part_rows(cases.PARTS["walk"], kept.results)}

    assert table(19)["made, share"].met and not table(18)["made, share"].met
    assert table(19)["time, median"].met and table(19)["time, median"].value == 2.0


def test_every_size_of_noise_has_its_figures():
    cached = CachedResults()
    cached.results = {f"walk/noise {s}/{k}": GOOD for s in (0.1, 0.2) for k in range(3)}
    cached.results |= {"walk/no noise": GOOD, "walk/noise 0.1/3": {"error": "no such step"}}
    rows = {row.subject: row for row in bench.rows(cached) if row.quantity == "made, share"}
    assert {name: row.value for name, row in rows.items()} == {
        "walk": 7 / 8, "walk, noise 0.1 rad": 3 / 4, "walk, noise 0.2 rad": 1.0
    }  # fmt: skip
    assert rows["walk"].met is False and rows["walk, noise 0.1 rad"].met is None


def test_different_minima_are_counted():
    assert bench.minima(np.array([1.0, 1.0004, 1.02])) == 2
    assert bench.minima(np.array([3.0])) == 1 and bench.minima(np.array([])) == 0


@pytest.mark.slow
def test_a_motion_is_timed_judged_kept_and_drawn(tmp_path):
    extent = cases.Extent(guesses=1, sizes=(), nodes_per_second=10.0)
    said = []
    how = {"parts": ("sit-to-stand",), "out": tmp_path}
    table = bench.experiment(extent).run(**how, say=said.append)
    results = json.loads((tmp_path / bench.EXPERIMENT.file).read_text())
    assert set(results) == {"loading/sit-to-stand", "sit-to-stand/no noise"}
    result = results["sit-to-stand/no noise"]
    assert result["success"] and 0 < result["cpu"] < 60 and result["iterations"] > 3
    assert "sit-to-stand/no noise" in table.text() and "loading, sit-to-stand" in table.text()
    page = (tmp_path / bench.EXPERIMENT.page).read_text()
    assert "time and success" in page and "://" not in page.replace("http://www.w3.org", "")
    before, said = len(said), []
    bench.experiment(extent).run(**how, say=said.append)
    assert before > len(said) == 1, "nothing is measured twice"


def test_the_short_form_is_a_part_of_the_whole(monkeypatch):
    assert set(bench.QUICK_PARTS) < set(cases.PARTS)
    assert set(fidelity.QUICK_PARTS) < set(fidelity.PARTS)
    asked = []
    part = replace(cases.PARTS["walk"], cases=lambda extent: asked.append(extent) or ())
    monkeypatch.setattr(bench, "PARTS", {"walk": part, "ipopt": part})
    monkeypatch.setattr(bench, "QUICK_PARTS", ("walk",))
    bench.experiment().run(quick=True)
    assert asked == [bench.QUICK_EXTENT]
    bench.experiment().run(quick=True, parts=("ipopt", "walk"))
    assert len(asked) == 3, "what is named is done"


def test_an_unknown_part_is_refused():
    for module in (bench, fidelity):
        with pytest.raises(ParameterError, match="no part 'hop'; there are"):
            module.EXPERIMENT.run(parts=("hop",))


# Physics and likeness -----------------------------------------------------------------------------


def test_everybody_walks():
    extent = fidelity.Extent()
    cases = {name: list(make(extent)) for name, make in fidelity.PARTS.items()}
    assert len(cases["speeds"]) == 10 and len(cases["feet"]) == 18
    assert len(cases["people"]) == PEOPLE and len(cases["tasks"]) == 6
    keys = [f"{part}/{case[0]}" for part, found in cases.items() for case in found]
    assert len(set(keys)) == len(keys)
    people = [case[1] for case in cases["people"]]
    assert {p.height for p in people} >= {1.5, 1.95} and {p.mass for p in people} >= {45.0, 110.0}
    assert {case[1].feet for case in cases["feet"]} == {"rigid", "two-segment", "multi-segment"}


@pytest.mark.slow
def test_a_walk_is_described_and_held_against_goals(synthesized):
    run = synthesized.run
    found = fidelity.shape_of(run)
    gait = found["gait"]
    assert found["speed_class"] in ("slow", "free")
    assert set(found["curves"]) == {*fidelity.CURVES, *fidelity.FORCES}
    assert gait["stance"] == pytest.approx(run.figures["stance_r_pct"], abs=0.5)
    assert 0 < gait["muscle_cost_of_transport"] < 1
    for name in fidelity.CURVES:
        assert gait["agreement"][name]["rmse"] > 0  # beside children, as PredSim's walks are
        own = np.asarray(found["curves"][name])
        adults = agreement_with_norm(found["percent"], own, name, population=norms.ADULTS)
        assert run.figures[f"norm_rmse_{name}_deg"] == pytest.approx(adults.rmse, rel=1e-6)
    assert run.figures["norm_population"] == "adults"
    child = movement_figures(run.record, {"age_years": 9.0})
    assert child["norm_population"] == "children"
    assert child["norm_rmse_mean_deg"] != pytest.approx(run.figures["norm_rmse_mean_deg"], rel=0.01)
    rows = list(fidelity.gait_rows("walk", gait))
    assert len([r for r in rows if r.met is not None]) == 14

    result = GOOD | found | {"check": run.figures, "options": {"speed": 1.3}}
    cached = CachedResults()
    cached.results = {
        f"speeds/{fidelity.FREE_SPEED:g} m/s periodic": result,
        "tasks/jump": FAILED | {"check": run.figures, "options": {}},
    }
    text = fidelity.EXPERIMENT.tables(cached)[0].text()
    assert "push-off" in text and "tasks/jump: first try" in text and "z of toe_r" in text
    assert "94 to 156 min" in text
    (section,) = fidelity.curve_sections(cached.results)
    assert len(section.figures) == 5 and all("<svg" in f.svg for f in section.figures)


@pytest.mark.parametrize(
    ("excursions", "met"), [((20.0, 26.0, 31.0), True), ((20.0, 26.0, 25.0), False)]
)
def test_the_centre_of_mass_is_to_move_the_more_the_faster_the_walk(excursions, met):
    results = {
        f"speeds/{v:g} m/s periodic": {
            "options": {"speed": v},
            "planes": {"figures": {"com_up_down_mm": up}},
        }
        for v, up in zip((1.0, 1.3, 1.6), excursions, strict=True)
    }
    (row,) = growth_row(results)
    assert row.met is met
    assert not list(growth_row(dict(list(results.items())[:1])))


def test_other_tasks_are_measured_end_to_end(tmp_path):
    extent = fidelity.Extent(others=("reach",), nodes_per_second=10.0)
    table = fidelity.experiment(extent).run(parts=("tasks",), out=tmp_path)
    result = json.loads((tmp_path / fidelity.EXPERIMENT.file).read_text())["tasks/reach"]
    assert result["success"] and result["check"]["check_slip_max_mm"] < 10
    assert "tasks/reach" in table.text() and (tmp_path / fidelity.EXPERIMENT.page).exists()
