"""Data of the panels of the live page: status, controls, the last seconds as curves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.charts.labels import MIN_SPANS, title_of
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.live.clock import Clock
from plantigrade.live.frame import HISTORY_DURATION, LiveFrame
from plantigrade.live.session import Session
from plantigrade.pages.contact_plate import SoleOutline, plate_svg
from plantigrade.pages.live_scene import weight_of
from plantigrade.side_names import side_of
from plantigrade.world import Target

MAX_POINTS = 125  # of a curve: one for two pixels of its width


def status_lines(session: Session, clock: Clock, frame: LiveFrame) -> list[str]:
    """Return the lines above the person."""
    speed = "paused" if session.paused else f"{session.speed:g}×"
    reached = "real time" if session.speed == 1.0 else "that speed"
    behind = f", {clock.time_lost:.2f} s behind" if clock.time_lost >= 0.005 else ""
    lines = [
        f"{frame.time:.2f} s, {speed}, {100 * clock.real_time_factor:.0f} % of {reached}{behind}"
    ]
    return lines + [word for word in (frame.end_message, session.message) if word]


def control_values(session: Session) -> dict[str, Any]:
    """Return the values of all controls, under the names of the commands that set them."""
    slope = session.desired_slope
    ahead, left = (0.0, 0.0) if slope is None else np.rad2deg(slope).tolist()
    return {
        "pause": session.paused,
        "speed": session.speed,
        "force": session.hand.max_force,
        "slope": ahead,
        "cross_slope": left,
        "friction": session.friction,
        "load": session.load,
        "controller": session.choice.controller,
        "feet": session.choice.feet,
        "joints": session.choice.joints,
        "targets": [target_value(target) for target in session.targets],
    }


def target_value(target: Target) -> dict[str, Any]:
    """Return a target of a controller as a control."""
    return {
        "name": target.name,
        "unit": target.unit,
        "low": target.low,
        "high": target.high,
        "value": target.value,
        "names": list(target.names),
    }


def soles_of(session: Session) -> list[SoleOutline]:
    """Return both soles of the person."""
    return [SoleOutline.of(session.world.human, session.world.sites, side) for side in SIDES]


def curves_data(frame: LiveFrame, soles: Sequence[SoleOutline], joint: str) -> dict[str, Any]:
    """Return the contact plate and curves of the last seconds.

    Args:
        frame: The state, with its recent history.
        joint: Joint whose angle and torque are shown, with that of the other side.
    """
    world, past, weight = frame.world, frame.history, weight_of(frame.world)
    names = world.human.coordinates
    pair = [n for side in SIDES if (n := f"{joint[:-2]}_{side}") in names and side_of(joint)]
    own = [world.human.hinge(name) for name in pair or [joint]]
    feet = {SIDE_NAMES[s]: theme.SIDE_COLOURS[s] for s in SIDES}
    joints = {SIDE_NAMES[n[-1]]: theme.SIDE_COLOURS[n[-1]] for n in pair} or {"": theme.MIDDLE}
    rows = np.unique(np.linspace(0, len(past.time) - 1, MAX_POINTS).astype(int))
    title = title_of(joint)

    def chart(title: str, unit: str, lines: dict[str, str], values: Float[Array, "n k"]) -> Any:
        return {
            "title": title,
            "unit": unit,
            "span": MIN_SPANS.get(unit, 1.0),
            "lines": [
                {"label": label, "colour": colour, "values": _plain(values[rows, k])}
                for k, (label, colour) in enumerate(lines.items())
            ],
        }

    ways = {"forward": theme.RECORDED, "left": theme.FORCE}
    return {
        "plate": plate_svg(soles, frame.force[:, 2] / weight),
        "seconds": HISTORY_DURATION,
        "time": _plain(past.time[rows] - past.time[-1]),
        "charts": [
            chart(title, "°", joints, np.rad2deg(past.angles[:, own])),
            chart(f"{title}, torque", "N m", joints, past.torques[:, own]),
            chart(title_of("ground_force_up"), "BW", feet, past.vertical / weight),
            chart("Centre of pressure", "cm", ways, 100.0 * past.cop),
        ],
    }


def _plain(values: Array) -> list[float | None]:
    """Return numbers for JSON, rounded so that noise at rest does not scale an axis."""
    return [None if np.isnan(value) else round(float(value), 3) for value in values]
