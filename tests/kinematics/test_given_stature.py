"""A stature that the markers contradict is refused or named; one that people may have is not."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import FitError
from plantigrade.kinematics.fit import fit_markers
from plantigrade.models import Person
from plantigrade.models.markers import landmark_names
from tests.kinematics.test_fit import NAMES, markers_of, recording, walker

LEGS = ("asis", "psis", "thigh", "knee", "shank", "ankle", "heel", "meta", "toe")
TRUE = 1.68  # of the walker [m]


@pytest.fixture(scope="module")
def markers():
    """Markers of a walker of usual lengths."""
    return markers_of(*walker(60))


def fitted(markers, height: float, *, legs: bool = False):
    """Fit markers, of the whole body or of the legs alone, with a stature."""
    marks = landmark_names(NAMES)
    kept = [n for n in NAMES if not legs or str(marks[n]).startswith(LEGS)]
    return fit_markers(recording(markers.select(kept)), Person(height=height))


@pytest.mark.parametrize(
    ("height", "legs"), [(TRUE - 0.3, False), (TRUE + 0.3, False), (0.5, False), (TRUE - 0.3, True)]
)
def test_a_stature_of_somebody_else_is_refused(markers, height, legs):
    """The message says both, and what to do."""
    with pytest.raises(FitError, match=rf"is {height:.2f} m, but .* suggest 1\.[67].*--height"):
        fitted(markers, height, legs=legs)


def test_a_doubtful_stature_is_the_first_note(markers):
    fit = fitted(markers, TRUE - 0.12)
    assert "given is 1.56 m, but the markers suggest 1.6" in fit.warnings[0]
    assert len(fit.warnings[0]) < 400
    assert fit.human.height == fit.metrics["height_m"] == pytest.approx(TRUE - 0.12)


@pytest.mark.parametrize("legs", [False, True])
def test_the_right_stature_is_not_doubted(markers, legs):
    fit = fitted(markers, TRUE, legs=legs)
    assert not any("suggest" in w for w in fit.warnings)
    assert fit.human.height == pytest.approx(TRUE)


@pytest.mark.parametrize(
    ("name", "height"),
    [
        ("c3d/HC032A03.c3d", 1.58),
        ("c3d/HC038A11.c3d", 1.74),
        ("opensim/running_subject04/run200.trc", 1.772),
    ],
)
def test_statures_of_known_people_are_not_doubted(data, name, height):
    from plantigrade import io

    whole = io.read(data / name)
    assert whole.markers is not None
    few = np.arange(0, whole.markers.n_frames, 4)
    cut = replace(
        whole.markers, time=whole.markers.time[few], positions=whole.markers.positions[few]
    )
    fit = fit_markers(replace(whole, markers=cut, plates=(), outputs={}), Person(height=height))
    assert not any("suggest" in w for w in fit.warnings)
