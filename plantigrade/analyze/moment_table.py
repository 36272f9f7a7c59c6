"""Generalised forces of a person's own OpenSim model, in the coordinates of that model."""

import numpy as np

from plantigrade.dynamics.osim_moments import moment_names
from plantigrade.io.osim_body import OsimHuman
from plantigrade.motion import Table
from plantigrade.record import Record


def moment_table(record: Record) -> Table | None:
    """Return the generalised forces of the model's coordinates with OpenSim's names and signs.

    None where the person is no model of their own, or no forces were measured.
    """
    human, torque = record.human, record.qfrc_actuator
    if not isinstance(human, OsimHuman) or torque is None:
        return None
    _, u = human.file_coordinates(record.motion.qpos)
    root = len(human.root.coordinates)
    values = np.zeros_like(u)
    for k, c in enumerate(human.every_coordinate[root:], start=root):
        if c.name in human.coordinates:
            values[:, k] = human.signs[k] * torque[:, 6 + human.hinge(c.name)]
    for f, now in enumerate(u):
        values[f, :root] = human.slopes(now)[:6, :root].T @ torque[f, :6]
    return Table(moment_names(human), record.motion.time, values)
