"""The person of a run as an OpenSim model, with the markers that the run was fitted to."""

from pathlib import Path

import numpy as np

from plantigrade.arrays import spread
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.writing import write_text
from plantigrade.kinematics.state import PointSet
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import marker_set_of, places_of
from plantigrade.models.osim import to_osim
from plantigrade.record import Record, Run

MAX_FRAMES = 200  # of a motion in which the body of a marker is found; more show nothing new


def write_model(run: Run, path: Path, marker_set: str | None = None) -> tuple[str, ...]:
    """Write the person of a run as an OpenSim model.

    Args:
        marker_set: Name of a marker set, or path of a TOML file; by default the recorded markers
            where the run was fitted to some, none otherwise.

    Raises:
        ParameterError: If there is no such set.
        FileError: If the file cannot be written, or the marker set cannot be read.
    """
    human = run.record.human
    if isinstance(human, OsimHuman):
        write_text(path, human.text)
        return ("the model is the one of the fit, without its muscles, other forces and shapes",)
    if marker_set is None:
        places = fitted_places(run.record)
    else:
        places = places_of(marker_set_of(marker_set), human)
    write_text(path, to_osim(human, places) + "\n")
    return () if places else ("the model has no markers; --marker-set NAME adds those of a set",)


def fitted_places(record: Record) -> dict[str, Attachment]:
    """Return the place on the body of every marker that the record was fitted to, by name.

    The body of a marker is the one in whose frame it moves least.
    """
    recorded, fitted, human = record.recorded_markers, record.fitted_markers, record.human
    if recorded is None or fitted is None:
        return {}
    every = spread(len(fitted), MAX_FRAMES)
    corners = np.vstack([np.zeros(3), np.eye(3)])
    bodies = [name for name in human.body_names for _ in corners]
    points = PointSet(human, bodies, np.tile(corners, (len(human.body_names), 1)))
    paths = points.path(record.motion.qpos[every]).reshape(len(every), -1, 4, 3)
    origins, axes = paths[:, :, 0], paths[:, :, 1:] - paths[:, :, :1]
    places: dict[str, Attachment] = {}
    for name, path in zip(recorded.names, np.moveaxis(fitted[every], 1, 0), strict=True):
        seen = np.isfinite(path).all(axis=1)
        if not seen.any():
            continue
        local = np.einsum("nbij,nbj->nbi", axes[seen], path[seen][:, None] - origins[seen])
        moved = local.std(axis=0).max(axis=1)
        body = int(moved.argmin())
        place = local[:, body].mean(axis=0)
        places[name] = Attachment(human.body_names[body], place, float(moved[body]))
    return places
