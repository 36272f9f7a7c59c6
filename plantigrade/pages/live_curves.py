"""Second panel of a live session: the virtual contact plate, and curves of the last seconds."""

from typing import Any

import numpy as np

from plantigrade.charts import theme
from plantigrade.constants import SIDES
from plantigrade.live.frame import HISTORY_DURATION, Frame
from plantigrade.live.session import Session
from plantigrade.pages.contact_plate import Sole, plate_svg

MAX_POINTS = 125  # of a curve
FIRST_JOINT = "ankle_angle_r"
"""Joint whose curves are shown at first, with that of the other side."""
PLOT_HEIGHT = 150  # [px]


class LiveCurves:
    """The second panel of a live session.

    Args:
        server: The viser server.
        session: The session.
    """

    def __init__(self, server: Any, session: Session):
        self.server, self.session = server, session
        gui = server.gui
        self._panel = gui.add_panel()
        with self._panel.add_tab("Feet and curves"):
            self._plate = gui.add_html("")
            joints = session.world.human.coordinates
            self._joint = gui.add_dropdown("Joint", [*joints], initial_value=FIRST_JOINT)
            self._angle = self._plot("angle [°]", ("right", "left"))
            self._torque = self._plot("torque [N m]", ("right", "left"))
            self._force = self._plot("vertical force [BW]", ("right", "left"))
            self._cop = self._plot("centre of pressure [cm]", ("forward", "left"))
        self._panel.dock_left()
        self._panel.set_width(330)

    def begin(self) -> None:
        """Use the soles and joints of another world."""
        human = self.session.world.human
        self._soles = [Sole.of(human, self.session.world.sites, side) for side in SIDES]
        before = self._joint.value
        self._joint.options = human.coordinates
        self._joint.value = before if before in human.coordinates else FIRST_JOINT

    def update(self, frame: Frame) -> None:
        """Draw the contact plate and the curves."""
        world, past = frame.world, frame.history
        if world is not self.session.world or len(past.time) < 2:
            return
        weight = world.human.mass * float(-world.model.opt.gravity[2])
        plate = plate_svg(self._soles, frame.force[:, 2] / weight)
        self._plate.content = f'<div style="padding:0 .6em">{plate}</div>'
        rows = np.unique(np.linspace(0, len(past.time) - 1, MAX_POINTS).astype(int))
        time = past.time[rows]
        joint = self._joint.value
        pair = _pair(joint, world.human.coordinates)
        own = [world.human.hinge(name) for name in pair]
        self._curve(self._angle, time, np.rad2deg(past.angles[rows][:, own]))
        self._curve(self._torque, time, past.torques[rows][:, own])
        self._curve(self._force, time, past.vertical[rows] / weight)
        self._curve(self._cop, time, 100.0 * past.cop[rows])

    def _plot(self, label: str, names: tuple[str, str]) -> Any:
        colours = theme.BY_SIDE[:2] if names == ("right", "left") else (theme.RECORDED, theme.FORCE)
        return self.server.gui.add_uplot(
            (np.array([0.0, HISTORY_DURATION]), np.zeros(2), np.zeros(2)),
            (
                {"label": "s"},
                *(
                    {"label": n, "stroke": c, "width": 1.5}
                    for n, c in zip(names, colours, strict=True)
                ),
            ),
            title=label,
            scales={"x": {"time": False}},
            legend={"show": False},
            height=PLOT_HEIGHT,
        )

    def _curve(self, plot: Any, time: np.ndarray, values: np.ndarray) -> None:
        values = values.round(3)  # so that noise at rest does not scale the axis
        columns = [values[:, min(i, values.shape[1] - 1)] for i in range(2)]
        plot.data = (time, *(np.ascontiguousarray(column) for column in columns))


def _pair(joint: str, names: tuple[str, ...]) -> list[str]:
    """Return the names of a coordinate on both sides, or its own name without sides."""
    if joint[-2:] not in ("_r", "_l"):
        return [joint]
    return [name for name in (f"{joint[:-2]}_{side}" for side in SIDES) if name in names]
