"""Films: frames that show the person, at true speed, in formats that others play."""

import sys

import numpy as np
import pytest

from plantigrade.errors import FileError, MissingExtra, ParameterError
from plantigrade.exchange import film
from plantigrade.models import Human
from tests.exchange.moving import moving

Image = pytest.importorskip("PIL.Image")


def pictures(path) -> list[np.ndarray]:
    """Return the frames of a GIF, red, green and blue in 0–255."""
    found = []
    with Image.open(path) as film:
        for k in range(film.n_frames):
            film.seek(k)
            found.append(np.asarray(film.convert("RGB")).astype(int))
    return found


def test_a_gif_shows_the_person_in_motion(tmp_path):
    run, path = moving(Human.create(), n=11), tmp_path / "run.gif"
    assert run.export(path, rate=10, height_px=120, view="front") == ()
    frames = pictures(path)
    assert len(frames) == 3 and frames[0].shape == (120, 214, 3)
    with Image.open(path) as film:
        assert film.info["duration"] == 100  # [ms]
    for frame in frames:
        middle = frame[30:90, 60:154]
        skin = (middle[..., 0] > middle[..., 2] + 15).mean()
        assert 0.02 < skin < 0.8
        assert not np.ptp(frame[:5, :5], axis=(0, 1)).max() > 40  # nothing but ground far away
    assert np.abs(frames[0] - frames[-1]).max() > 50


def test_a_person_high_above_the_ground_stays_in_the_picture(tmp_path):
    run = moving(Human.create(), n=6)
    run.record.motion.qpos[:, 2] += 1.5  # [m], as on a vaulting table
    run.export(tmp_path / "run.gif", rate=10, height_px=120)
    for frame in pictures(tmp_path / "run.gif"):
        empty = np.abs(frame - frame[0, 0]).max(axis=2) < 30
        assert empty[0].all() and empty[-1].all() and not empty.all()


def test_ground_reactions_are_drawn(walk, tmp_path):
    walk.export(tmp_path / "walk.gif", rate=2, height_px=120)
    blue = [(f[..., 2] > f[..., 0] + 90).sum() for f in pictures(tmp_path / "walk.gif")]
    assert max(blue) > 5  # the right foot's arrow


def test_an_mp4_plays(tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    run = moving(Human.create(), n=6)
    run.export(tmp_path / "run.mp4", height_px=120)
    reader = ffmpeg.read_frames(str(tmp_path / "run.mp4"))
    facts = next(reader)
    assert facts["codec"] == "h264" and facts["size"] == (214, 120)
    assert facts["fps"] == pytest.approx(25)
    assert len(list(reader)) == 3


def test_a_film_that_could_not_be_completed_leaves_nothing(tmp_path, monkeypatch):
    pytest.importorskip("imageio_ffmpeg")

    def stopped(*_, **__):
        raise InterruptedError

    monkeypatch.setattr(film, "gaussian_filter1d", stopped)
    (tmp_path / "run.mp4").write_text("the film before")
    with pytest.raises((InterruptedError, FileError)):
        moving(Human.create(), n=6).export(tmp_path / "run.mp4", height_px=120)
    assert [p.read_text() for p in tmp_path.iterdir()] == ["the film before"]


def test_a_missing_library_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtra, match=r"pip install '.*\[video\]'"):
        moving(Human.create()).export(tmp_path / "run.mp4", height_px=120)
    assert not list(tmp_path.iterdir())


def test_options_are_checked(tmp_path):
    run = moving(Human.create())
    for options, words in (
        ({"view": "above"}, "view is 'above'; allowed are side"),
        ({"height_px": 10}, "must lie between 120 and 2160"),
        ({"rate": 0.0}, "must lie between 1 and 1000"),
    ):
        with pytest.raises(ParameterError, match=words):
            run.export(tmp_path / "run.gif", **options)
