"""What a device adds at a joint, and what is left to the person."""

import numpy as np

from plantigrade.charts import Figure, Series, line_plot
from plantigrade.charts.theme import REFERENCE, STROKE_MIDDLE, STROKE_RIGHT
from plantigrade.pages.section import ReportedRun, Section, needs

TITLE = "Device"
SIGNAL, WITHOUT_SIGNAL = "device.torque", "device.without"


@needs(SIGNAL)
def device_section(subject: ReportedRun) -> list[Section]:
    """Return the torque at every joint with a device: of the device, of the person, without it."""
    record, time = subject.record, subject.record.motion.time
    if record.qfrc_actuator is None:
        return []
    device, before = record.device_torque, record.signals.get(WITHOUT_SIGNAL)
    figures = []
    for i in np.flatnonzero(device.any(axis=0)):
        series = [
            Series(time, record.qfrc_actuator[:, i] - device[:, i], "person", STROKE_RIGHT),
            Series(time, device[:, i], "device", STROKE_MIDDLE),
        ]
        if before is not None:
            series.append(Series(time, np.asarray(before)[:, i], "without device", REFERENCE))
        name = record.human.coordinates[i - 6].replace("_", " ")
        figures.append(
            Figure(line_plot(series, title=name, y_label="torque [N m]", zero=True, width=520))
        )
    return [Section(TITLE, figures=figures)] if figures else []
