"""A run as BIDS Motion: time series, channels and their description, events.

The file is named as in BIDS, ``sub-01_task-walk_tracksys-plantigrade_motion.tsv``; its companions
``…_motion.json``, ``…_channels.tsv``, ``…_channels.json`` and ``…_events.tsv`` lie beside it.
Channels are position and orientation of the pelvis, the joint angles, and the recorded markers.
"""

import json
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from plantigrade import __version__
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES
from plantigrade.errors import FileError
from plantigrade.exchange.clock import at_rate
from plantigrade.io.writing import write_text
from plantigrade.motion.filters import interpolate
from plantigrade.motion.recording import rate_of
from plantigrade.record import Record, Run

ENDING = "_motion.tsv"
_NAME = re.compile(
    r"sub-[0-9A-Za-z]+(_ses-[0-9A-Za-z]+)?_task-(?P<task>[0-9A-Za-z]+)_tracksys-[0-9A-Za-z]+"
    r"(_acq-[0-9A-Za-z]+)?(_run-[0-9]+)?_motion\.tsv"
)
_WORLD = {
    "SpatialAxes": "ALS",
    "RotationRule": "right-hand",
    "Description": "x forward, y to the left, z up; quaternions turn body axes to these",
}
_JOINTS = {
    "Description": "angles between neighbouring segments, signs as in OpenSim: flexion, adduction, "
    "internal rotation and dorsiflexion are positive"
}


class Channel(NamedTuple):
    """A column of the time series."""

    name: str
    component: str
    type: str
    tracked_point: str
    units: str
    reference_frame: str


def write_motion(run: Run, path: Path, rate: float | None = None) -> tuple[str, ...]:
    """Write a run as BIDS Motion; the companions of the file go beside it.

    Args:
        path: The file, named as BIDS does, with the ending ``_motion.tsv``.
        rate: Frames per second [Hz]; those of the motion if absent.

    Raises:
        ParameterError: If the rate is not allowed.
        FileError: If the file is not named as in BIDS, or cannot be written.
    """
    found = _NAME.fullmatch(path.name)
    if found is None:
        raise FileError(
            path,
            "is not the name of a motion file of BIDS",
            remedy="write sub-LABEL_task-LABEL_tracksys-LABEL_motion.tsv",
        )
    stem = path.name.removesuffix(ENDING)
    channels, time, values = channels_of(run.record, rate)
    rows = ("\t".join("n/a" if np.isnan(v) else f"{v:.7g}" for v in row) for row in values)
    table = [Channel._fields, *channels]
    events = run.record.motion.events
    files = {
        path.name: "\n".join(rows) + "\n",
        f"{stem}_motion.json": _text(_sidecar(run, found["task"], channels, time)),
        f"{stem}_channels.tsv": "\n".join("\t".join(row) for row in table) + "\n",
        f"{stem}_channels.json": _text(
            {"reference_frame": {"Levels": {"world": _WORLD, "joint": _JOINTS}}}
        ),
    }
    if events:
        lines = ["onset\tduration\ttrial_type"]
        for event in sorted(events, key=lambda each: each.time):
            kind = f"{event.kind}_{SIDE_NAMES[event.side]}"
            lines.append(f"{event.time - time[0]:.4f}\t0\t{kind}")
        files[f"{stem}_events.tsv"] = "\n".join(lines) + "\n"
    for name, content in files.items():
        write_text(path.with_name(name), content)
    return ("ground reactions and moments have no channel type in BIDS: left out",)


def channels_of(
    record: Record, rate: float | None = None
) -> tuple[list[Channel], Float[Array, " n"], Float[Array, "n n_channels"]]:
    """Return the channels of a record, its clock and the values [m, deg]; NaN where unknown.

    Raises:
        ParameterError: If the rate is not allowed.
    """
    motion, human = at_rate(record.motion, rate), record.human
    channels = [Channel(f"pelvis_{a}", a, "POS", "pelvis", "m", "world") for a in "xyz"]
    parts = [f"quat_{a}" for a in "wxyz"]
    channels += [Channel(f"pelvis_{p}", p, "ORNT", "pelvis", "n/a", "world") for p in parts]
    columns = [motion.qpos[:, :7]]
    for name in human.coordinates:
        body = human.body_names[int(human.model.joint(name).bodyid[0]) - 1]
        channels.append(Channel(name, "n/a", "JNTANG", body, "deg", "joint"))
        columns.append(np.rad2deg(motion[name])[:, None])
    markers = record.recorded_markers
    for k, name in enumerate(() if markers is None else markers.names):
        assert markers is not None
        point = re.sub(r"\s+", "_", name)
        channels += [Channel(f"{point}_{a}", a, "POS", point, "m", "world") for a in "xyz"]
        path = markers.positions[:, k]
        if motion.n_frames != len(path):
            path = interpolate(motion.time, markers.time, path)
        columns.append(path)
    return channels, motion.time, np.hstack(columns)


def _sidecar(run: Run, task: str, channels: list[Channel], time: np.ndarray) -> dict:
    kinds = [channel.type for channel in channels]
    rate = rate_of(time) if len(time) > 1 else 1.0
    return {
        "TaskName": task,
        "TaskDescription": run.sentence or run.title or task,
        "SamplingFrequency": round(rate, 6),
        "SamplingFrequencyEffective": round(rate, 6),
        "TrackingSystemName": f"plantigrade {run.kind}",
        "SoftwareVersions": f"plantigrade {__version__}",
        "RecordingDuration": round(float(time[-1] - time[0]), 6),
        "MotionChannelCount": len(channels),
        **{f"{kind}ChannelCount": kinds.count(kind) for kind in ("POS", "ORNT", "JNTANG")},
        "TrackedPointsCount": len({c.tracked_point for c in channels if c.type == "POS"}),
        "MissingValues": "n/a",
        "SpatialAxes": _WORLD["SpatialAxes"],
        "RotationRule": _WORLD["RotationRule"],
    }


def _text(content: dict) -> str:
    return json.dumps(content, indent=2) + "\n"
