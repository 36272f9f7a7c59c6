"""Gait cycles of many runs: one table, or one Dataset, with the curves that each run has."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plantigrade import export
from plantigrade.commands import main as cli
from plantigrade.errors import FileError, ParameterError
from plantigrade.exchange.tables import side_curves
from plantigrade.record import Run

FOLDERS = ("anna/walk", "bert/walk")


@pytest.fixture(scope="module")
def trials(walk, tmp_path_factory):
    """Two runs of one name in a folder, and one without gait cycles."""
    above = tmp_path_factory.mktemp("trials")
    for folder, name in zip(FOLDERS, ("Anna", "Bert"), strict=True):
        replace(walk, figures={**walk.figures, "subject_name": name}).save(above / folder)
    record = walk.record
    still = replace(record, motion=replace(record.motion, events=()))
    replace(walk, record=still).save(above / "still")
    return above


def paths(above: Path) -> list[str]:
    return [str(above / folder) for folder in FOLDERS]


def curves(above: Path):
    """Yield trial, side, and the curves of the run itself."""
    for folder in FOLDERS:
        run = Run.load(above / folder)
        for side in "rl":
            yield folder, side, *side_curves(run, side)[1:]


def test_parquet_holds_every_curve_of_every_cycle(trials, tmp_path, capsys):
    pytest.importorskip("pyarrow")
    import pyarrow.parquet as pq

    out = tmp_path / "all.parquet"
    assert cli.main(["convert", *paths(trials), str(trials / "still"), str(out)]) == 0
    assert "still shows no complete gait cycle" in capsys.readouterr().err
    table = pq.read_table(out)
    columns = {name: np.array(table[name].to_pylist()) for name in table.column_names if
               name != "value"}  # fmt: skip
    value = table["value"].to_numpy(zero_copy_only=False)
    assert set(columns["subject"]) == {"Anna", "Bert"}
    for trial, side, cycles, found in curves(trials):
        mine = (columns["trial"] == trial) & (columns["side"] == side)
        knee = mine & (columns["signal"] == "knee_angle_moment")
        assert set(columns["unit"][knee]) == {"N m/kg"}
        assert columns["cycle"][knee].max() == len(cycles)
        assert columns["percent"][knee][:101] == pytest.approx(np.arange(101))
        np.testing.assert_allclose(value[knee], found["knee_angle_moment_nm_kg"].ravel())
        assert len(set(columns["signal"][mine])) == len(found)


@pytest.mark.parametrize("ending", ["nc", "zarr"])
def test_a_dataset_comes_back_as_it_was(ending, trials, tmp_path):
    xarray = pytest.importorskip("xarray")
    out = tmp_path / f"all.{ending}"
    if ending == "zarr":
        pytest.importorskip("zarr")
    export(paths(trials), out)
    data = xarray.open_zarr(out) if ending == "zarr" else xarray.open_dataset(out)
    data = data.load()
    assert set(data.sizes) == {"stride", "percent"}
    for trial, side, cycles, found in curves(trials):
        mine = data.isel(stride=(data.trial.values == trial) & (data.side.values == side))
        assert list(mine.cycle.values) == list(range(1, len(cycles) + 1))
        np.testing.assert_allclose(mine.hip_flexion, found["hip_flexion_deg"])
        assert mine.start.values == pytest.approx([cycle.start for cycle in cycles])
    assert data.hip_flexion_power.units == "W/kg"
    assert data.hip_flexion.sel(percent=50).mean("stride").size == 1
    data.close()


def test_a_zarr_is_replaced_when_asked(trials, tmp_path, capsys):
    pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    words = ["convert", *paths(trials)[:1], str(tmp_path / "all.zarr")]
    assert cli.main(words) == 0
    assert cli.main(words) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert cli.main([*words, "--overwrite"]) == 0
    (tmp_path / "mine.zarr").mkdir()
    assert cli.main([*words[:-1], str(tmp_path / "mine.zarr"), "--overwrite"]) == 2
    assert {path.name for path in tmp_path.iterdir()} == {"all.zarr", "mine.zarr"}


def test_the_folder_of_a_batch_stands_for_its_runs(trials, tmp_path):
    pq = pytest.importorskip("pyarrow.parquet")
    batch = {"kind": "batch", "format": 1, "status": "ok", "folders": [*FOLDERS, "still", "failed"]}
    (trials / "metrics.json").write_text(json.dumps(batch))
    export(trials, tmp_path / "all.parquet")
    assert set(pq.read_table(tmp_path / "all.parquet")["trial"].to_pylist()) == set(FOLDERS)


def test_what_cannot_be_one_table_is_refused(trials, walk, tmp_path):
    pytest.importorskip("pyarrow")
    out = tmp_path / "all.parquet"
    with pytest.raises(FileError, match="no complete gait cycle|no run shows"):
        export(trials / "still", out)
    with pytest.raises(ParameterError, match="two runs are called 'walk'"):
        export([walk, walk], out)
    with pytest.raises(FileError, match="CSV holds one run"):
        export(paths(trials), tmp_path / "all.csv")
    figures_alone = tmp_path / "batch"
    figures_alone.mkdir()
    (figures_alone / "metrics.json").write_text(json.dumps({"kind": "batch", "folders": ["a"]}))
    with pytest.raises(FileError, match="kept no runs"):
        export(figures_alone, out)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["walk.trc"], "the file to write"),
        (["walk.trc", "other.trc", "all.c3d"], "one of several files"),
        (["none", "all.parquet"], "no such file"),
    ],
)
def test_what_the_command_refuses(words, said, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("walk.trc", "other.trc"):
        Path(name).write_text("")
    assert cli.main(["convert", *words]) == 2
    assert said in capsys.readouterr().err
