"""Equal runs give equal bytes: every file, but for the computing times in one field."""

import json
import re
from pathlib import Path

import pytest

import plantigrade as pg
from plantigrade.workflows.save import save
from tests.textbook import walk_file

pytestmark = pytest.mark.solver

ENGINES = {
    "fit": lambda walk: pg.fit(walk),
    "reproduce": lambda walk: pg.reproduce(walk),
    "simulate": lambda _: pg.simulate(duration=0.4, push=("80,0.1,90,0.1",)),
    "synthesize": lambda _: pg.synthesize("squat", nodes_per_second=8.0, restarts=2, seed=5),
    "track": lambda walk: pg.synthesize("track", recording=walk, stop=1.3, refinements=0),
    "zhakatayev2023": lambda _: pg.synthesize("zhakatayev2023", motion="sit-to-stand"),
}
SLOW = ("reproduce", "simulate", "synthesize", "track", "zhakatayev2023")


@pytest.fixture(scope="module")
def walk(tmp_path_factory) -> Path:
    return walk_file(tmp_path_factory.mktemp("equal") / "walk.c3d", cycles=2)


@pytest.mark.parametrize(
    "engine",
    [pytest.param(n, marks=[pytest.mark.slow] if n in SLOW else []) for n in ENGINES],
)
def test_two_runs_differ_in_their_seconds_alone(engine, walk, tmp_path):
    made = [save(ENGINES[engine](walk), tmp_path / name) for name in ("one", "another")]
    first, second = ({p.name: p for p in run.folder.iterdir()} for run in made)
    assert set(first) == set(second) and "report.html" in first
    for name in set(first) - {"metrics.json"}:
        assert first[name].read_bytes() == second[name].read_bytes(), name
    texts = [files["metrics.json"].read_text("utf-8") for files in (first, second)]
    spent = [json.loads(text)["seconds"] for text in texts]
    assert spent[0].keys() == spent[1].keys() and all(s >= 0 for s in spent[0].values())
    rest = [re.sub(r'"seconds": \{[^}]*\}', "", text) for text in texts]
    assert rest[0] == rest[1]
    # the times stand nowhere else, and no page names the folder it was written to
    sentences = [run.sentence.replace(str(run.folder), "") for run in made]
    assert sentences[0] == sentences[1]
    for run, files in zip(made, (first, second), strict=True):
        assert str(run.folder).encode() not in files["report.html"].read_bytes()
