"""From a recording to a motion on a person's own OpenSim model."""

import time
from dataclasses import replace
from pathlib import Path

from plantigrade.analyze.osim_trial import analyse_osim
from plantigrade.errors import FitError
from plantigrade.io.osim import MAX_BYTES
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.text import read_text
from plantigrade.kinematics.osim_inverse import fit_osim, take_coordinates
from plantigrade.kinematics.plausibility import verdict
from plantigrade.motion import Recording
from plantigrade.record import Provenance, Run
from plantigrade.record.provenance import source_files
from plantigrade.workflows.settings import FitSettings

USELESS = (
    "joints", "feet", "mass", "age", "norms", "static", "skeleton", "marker_set", "ground", "rate",
    "without_plates",
)  # fmt: skip
"""Options of a scaled human, which a model of the person's own takes the place of."""


def fit_own_model(recording: Recording, how: FitSettings, *, command: str = "") -> Run:
    """Return the run of a recording on the model that the settings name.

    Raises:
        ParameterError: If settings of a scaled human are given too.
        FileError: If the model cannot be read.
        FitError: If recording and model do not fit together.
    """
    assert how.model is not None
    began = time.perf_counter()
    how.refuse(USELESS, "with a model of your own")
    model = Path(how.model)
    human = OsimHuman.of(read_text(model, MAX_BYTES), model, height=how.height, sex=how.sex)
    if recording.markers is not None and recording.markers.names:
        fit = fit_osim(human, recording.markers)
    elif recording.coordinates is not None:
        fit = take_coordinates(human, recording.coordinates)
    else:
        raise FitError(
            f"{recording.source.name} holds neither markers nor joint angles, which a model of "
            "your own could follow"
        )
    fit = replace(fit, notes=(*recording.warnings, *fit.notes))
    trial = analyse_osim(fit, recording.plates, how.cutoff)
    figures = trial.figures
    error = figures.get("marker_rms_mean_mm")
    followed = "joint angles"
    if fit.markers is not None and error is not None:
        followed = f"{len(fit.markers.names)} markers, RMS error {error:.1f} mm"
    return Run(
        trial.record,
        "fit",
        title=recording.source.name,
        sentence=f"{recording.source.name} on the model {model.name}: {followed}.",
        status=verdict(None if error is None else 1e-3 * error, "marker"),
        figures=figures,
        provenance=Provenance(
            command, how.plain(), source_files([recording.source, model, *recording.companions])
        ),
        seconds={"fit": time.perf_counter() - began},
        name=f"fit-{recording.source.stem}",
    )
