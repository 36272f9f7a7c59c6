"""The sections of a report, each made from a record and what is known about its gait cycles."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from plantigrade.analyze.curves import known_above
from plantigrade.arrays import Array, Float
from plantigrade.motion import Table
from plantigrade.record import Record
from plantigrade.report.curves import hinge_table, panels_of
from plantigrade.charts import (
    LEFT,
    MIDDLE,
    RIGHT,
    SIDES,
    Band,
    Outline,
    Series,
    bar_plot,
    line_plot,
    path_plot,
)
from plantigrade.report.scene import body_weight, foot_bodies, poses, shapes_of, side_forces
from plantigrade.report.theme import SIDE_NAMES, side_of, title_of, without_side

MAX_PRINTS = 16
MEANINGS = {  # what positive and negative mean, short enough for an axis
    "hip_flexion": ("flex.", "ext."),
    "hip_adduction": ("add.", "abd."),
    "hip_rotation": ("internal", "external"),
    "knee_angle": ("flex.", "ext."),
    "ankle_angle": ("dorsi", "plantar"),
    "subtalar_angle": ("inv.", "ev."),
    "mtp_angle": ("up", "down"),
    "pelvis_tilt": ("back", "forward"),
    "lumbar_extension": ("ext.", "flex."),
    "arm_flex": ("flex.", "ext."),
    "elbow_flex": ("flex.", "ext."),
    "pelvis_list": ("left up", "right up"),
    "pelvis_rotation": ("to left", "to right"),
    "lumbar_bending": ("to right", "to left"),
    "lumbar_rotation": ("to left", "to right"),
    "neck_extension": ("ext.", "flex."),
    "neck_bending": ("to right", "to left"),
    "neck_rotation": ("to left", "to right"),
    "arm_add": ("add.", "abd."),
    "arm_rot": ("internal", "external"),
    "pro_sup": ("pron.", "sup."),
    "wrist_flex": ("flex.", "ext."),
    "wrist_dev": ("ulnar", "radial"),
    "ground_force_forward": ("pushes", "brakes"),
    "ground_force_sideways": ("left", "right"),
}
LEAST = {"°": 10.0, "N m": 10.0, "N m/kg": 0.2, "W/kg": 0.2, "BW": 0.1}
"""What the vertical axis spans at least, by unit: a figure drawn larger would magnify noise."""


@dataclass(frozen=True)
class CycleCurves:
    """One quantity over the gait cycle, one row per cycle.

    Attributes:
        name: Coordinate with its side (``"knee_angle_r"``), as in OpenSim.
        percent: Percent of the gait cycle, 0 at heel strike.
        values: In ``unit``; NaN where unknown.
        unit: Unit as written in the plot (``"°"``, ``"N m/kg"``).
    """

    name: str
    percent: Float[Array, " n_percent"]
    values: Float[Array, "n_cycles n_percent"]
    unit: str = "°"


@dataclass(frozen=True)
class Norm:
    """Published values of one quantity over the gait cycle.

    Attributes:
        percent: Percent of the gait cycle.
        mean: In the unit of the plot it is laid under.
        sd: Standard deviation between people.
        source: Citation, in a few words.
    """

    percent: Float[Array, " n_percent"]
    mean: Float[Array, " n_percent"]
    sd: Float[Array, " n_percent"]
    source: str = ""


@dataclass(frozen=True)
class Figure:
    """A drawing and its caption.

    Attributes:
        svg: The drawing.
        caption: One or two sentences that a student understands; none where empty.
        wide: Whether it takes the full width of the page.
    """

    svg: str
    caption: str = ""
    wide: bool = False


@dataclass(frozen=True)
class Section:
    """One part of a report.

    Attributes:
        title: Its heading.
        figures: Drawings.
        text: Before the drawings.
        headers: Of its table.
        rows: Of its table.
        missing: Why there is nothing to show; then it is one line of the report.
    """

    title: str
    figures: Sequence[Figure] = ()
    text: str = ""
    headers: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = field(default_factory=tuple)
    missing: str = ""


def cycle_section(
    title: str,
    curves: Sequence[CycleCurves],
    norms: dict,
    toe_off: dict[str, float],
    *,
    caption: str,
    missing: str,
) -> Section:
    """Return curves over the gait cycle, one plot per quantity, left and right together."""
    if not curves:
        return Section(title, missing=missing)
    grouped: dict[tuple[str, str], list[CycleCurves]] = {}
    for curve in curves:
        grouped.setdefault((without_side(curve.name), curve.unit), []).append(curve)
    figures, sources, several = [], [], False
    for (base, unit), members in grouped.items():
        series, bands, marks = [], [], []
        norm = as_norm(norms.get(base) or norms.get(members[0].name))
        if norm is not None:
            low, high = norm.mean - norm.sd, norm.mean + norm.sd
            bands.append(Band(norm.percent, low, high, MIDDLE, 0.22))
            series.append(Series(norm.percent, norm.mean, "norm", MIDDLE, 1.0, 0.8, "4 3"))
            if norm.source and norm.source not in sources:
                sources.append(norm.source)
        for curve in sorted(members, key=lambda c: side_of(c.name) != "r"):
            side = side_of(curve.name)
            mean, sd = mean_sd(curve.values)
            if len(curve.values) > 1:
                several = True
                bands.append(Band(curve.percent, mean - sd, mean + sd, SIDES[side], 0.18))
            label = SIDE_NAMES.get(side or "", "")
            series.append(Series(curve.percent, mean, label, SIDES[side], 2.0))
            if side in toe_off:
                marks.append((toe_off[side], SIDES[side]))
        figures.append(
            Figure(
                line_plot(
                    series,
                    bands=bands,
                    marks=marks,
                    title=title_of(base),
                    x_label="gait cycle [%]",
                    y_label=signed(base, unit),
                    least=LEAST.get(unit, 0.0),
                )
            )
        )
    words = caption
    if several:
        counts = ", ".join(
            f"{max(counted)} {SIDE_NAMES.get(side or '', 'middle')}"
            for side in ("r", "l", None)
            if (counted := [len(c.values) for c in curves if side_of(c.name) == side])
        )
        words += f" Line and coloured band: mean and standard deviation over cycles ({counts})."
    if toe_off:
        words += " Dashed upright lines: foot off."
    if any(norms.get(base) for base, _ in grouped):
        words += " Grey band: published mean ± 1 SD of healthy people"
        words += f" ({'; '.join(sources)})." if sources else "."
    return Section(title, figures, text=words)


def time_section(model: mujoco.MjModel, record: Record, curves) -> Section:
    """Return joint angles over time, for motions without whole gait cycles."""
    table = hinge_table(model, record.motion) if curves is None else curves
    panels = panels_of(table, record.motion.n_frames)
    time = record.motion.time
    colours = {"right": RIGHT, "left": LEFT}
    figures = [
        Figure(
            line_plot(
                [
                    Series(time, line.values, line.label, colours.get(line.label, MIDDLE))
                    for line in panel.lines
                ],
                title=panel.title,
                x_label="time [s]",
                y_label=signed(panel.name, panel.unit.strip()),
                least=LEAST.get(panel.unit.strip(), 0.0),
            )
        )
        for panel in panels[:24]
    ]
    text = "Joint angles over time; no whole gait cycle was found or asked for."
    if len(panels) > 24:
        text += f" The first 24 of {len(panels)} are drawn; all are in motion.mot."
    return Section("Joint angles", figures, text=text)


def moments_over_time(model: mujoco.MjModel, record: Record) -> Table | None:
    """Return the joint moments of a record over time [N m]; None where it has none.

    NaN where a force they depend on is not known.
    """
    if record.qfrc_actuator is None:
        return None
    hinge = int(mujoco.mjtJoint.mjJNT_HINGE)
    joints = [j for j in range(model.njnt) if int(model.jnt_type[j]) == hinge]
    names = tuple(model.joint(j).name for j in joints)
    values = record.qfrc_actuator[:, [int(model.jnt_dofadr[j]) for j in joints]]
    where = np.stack([known_above(model, record, name) for name in names], axis=1)
    return Table(names=names, time=record.motion.time, values=values * where)


def force_section(model: mujoco.MjModel, record: Record) -> Section:
    """Return ground reaction over time and the centre of pressure over the foot prints."""
    title = "Ground reaction and centre of pressure"
    weight = body_weight(model)
    total, cop = side_forces(record, weight)
    if total is None or not np.any(total):
        return Section(title, missing="no ground reaction was measured or computed.")
    time = record.motion.time
    names = (("right", RIGHT), ("left", LEFT), ("side unknown", MIDDLE))
    figures = []
    axes = ((2, "Vertical", ""), (0, "Forward", ""), (1, "Sideways (left positive)", ""))
    for axis, name, _ in axes:
        series = [
            Series(time, np.where(np.any(total[:, s], axis=1), total[:, s, axis], np.nan) / weight,
                   label, colour)
            for s, (label, colour) in enumerate(names)
            if np.any(total[:, s])
        ]  # fmt: skip
        figures.append(
            Figure(
                line_plot(
                    series,
                    title=name,
                    x_label="time [s]",
                    y_label="[BW]",
                    zero=True,
                    least=LEAST["BW"],
                )
            )
        )
    text = (
        "Force of the ground on each foot, divided by body weight "
        f"(BW, {weight:.0f} N). Forward is negative while the foot brakes and positive while it "
        "pushes off."
    )
    outlines = foot_prints(model, record, total, weight)
    if cop is not None and np.isfinite(cop).any() and outlines:
        series = [
            Series(cop[:, s, 0], cop[:, s, 1], label, colour, 2.2)
            for s, (label, colour) in enumerate(names)
            if np.isfinite(cop[:, s]).any()
        ]
        caption = (
            "Seen from above. The point where the ground's force acts moves from the heel to the "
            "toes in each step; pale shapes are the bones of the loaded foot at mid-stance."
        )
        figures.append(
            Figure(
                path_plot(
                    series,
                    outlines=outlines,
                    title="Centre of pressure over the foot prints",
                    x_label="forward [m]",
                    y_label="left [m]",
                ),
                caption,
                wide=True,
            )
        )
        figures += _foot_figures(model, record, total, cop, weight)
    return Section(title, figures, text=text)


def _foot_figures(model, record, total, cop, weight) -> list[Figure]:
    """Return, per foot, the centre of pressure of every stance in the frame of that foot."""
    figures = []
    for row, (side, colour) in enumerate((("r", RIGHT), ("l", LEFT))):
        inside = foot_bodies(model, side)
        shapes = [s for s in shapes_of(model) if inside[s.body]]
        stances = stances_of(total[:, row, 2], weight)
        if not shapes or not stances:
            continue
        ankle = int(np.flatnonzero(inside)[0])
        series, outlines = [], []
        for start, stop in stances:
            middle = (start + stop) // 2
            positions, quats, _ = poses(model, record.motion.qpos[middle : middle + 1])
            prints = [_print(s, positions[0], quats[0], colour) for s in shapes]
            tips = np.concatenate([o.points for o in prints])
            origin = positions[0, ankle, :2]
            # the foot points from its ankle to the far end of its outline
            away = tips - origin
            axis = away[np.argmax(np.linalg.norm(away, axis=1))]
            near = away[np.linalg.norm(away, axis=1) > 0.8 * np.linalg.norm(axis)].mean(axis=0)
            forward = near / max(np.linalg.norm(near), 1e-9)
            turn = np.array([[forward[1], -forward[0]], forward])  # right of it, along it
            if not outlines:
                outlines = [
                    Outline(100 * (o.points - origin) @ turn.T, o.colour, 100 * o.width)
                    for o in prints
                ]
            path = 100 * (cop[start:stop, row, :2] - origin) @ turn.T
            series.append(Series(path[:, 0], path[:, 1], "", colour, 1.6, 0.8))
        figures.append(
            Figure(
                path_plot(
                    series,
                    outlines=outlines,
                    title=f"{SIDE_NAMES[side].capitalize()} foot, stances: {len(series)}",
                    x_label="to the right of the ankle [cm]",
                    y_label="ahead of the ankle [cm]",
                    width=520,
                    max_height=380,
                ),
                "Centre of pressure of every stance, in the frame of the foot at mid-stance."
                if row == 0
                else "",
            )
        )
    return figures


def stances_of(vertical: Float[Array, " n"], weight: float) -> list[tuple[int, int]]:
    """Return first and last-plus-one frame of each time a foot bears a tenth of body weight."""
    loaded = np.concatenate([[False], vertical > 0.1 * weight, [False]])
    change = np.flatnonzero(np.diff(loaded.astype(int)))
    return [(int(a), int(b)) for a, b in zip(change[::2], change[1::2], strict=True) if b - a > 3]


def foot_prints(model, record: Record, total, weight: float) -> list[Outline]:
    """Return the bones of each loaded foot at the middle of its stance, seen from above."""
    outlines = []
    for row, side in enumerate("rl"):
        inside = foot_bodies(model, side)
        shapes = [s for s in shapes_of(model) if inside[s.body]]
        stances = stances_of(total[:, row, 2], weight)[: MAX_PRINTS // 2]
        frames = [(start + stop) // 2 for start, stop in stances]
        if not frames or not shapes:
            continue
        positions, quats, _ = poses(model, record.motion.qpos[frames])
        for i in range(len(frames)):
            outlines += [_print(shape, positions[i], quats[i], SIDES[side]) for shape in shapes]
    return outlines


def _print(shape, positions, quats, colour) -> Outline:
    from plantigrade.report.strip import _hull, _surface

    body, own = np.empty(9), np.empty(9)
    mujoco.mju_quat2Mat(body, quats[shape.body])
    mujoco.mju_quat2Mat(own, shape.quat)
    origin = positions[shape.body] + body.reshape(3, 3) @ shape.position
    frame = body.reshape(3, 3) @ own.reshape(3, 3)
    if shape.kind in ("capsule", "sphere"):
        half = shape.size[1] if shape.kind == "capsule" else 1e-4
        ends = np.array([origin - frame[:, 2] * half, origin + frame[:, 2] * half])
        return Outline(ends[:, :2], colour, 2 * float(shape.size[0]))
    return Outline(_hull((origin + _surface(shape) @ frame.T)[:, :2]), colour)


def marker_section(record: Record) -> Section:
    """Return how far the recorded markers lie from those on the body."""
    title = "Marker errors"
    if record.recorded_markers is None or record.fitted_markers is None:
        return Section(title, missing="there were no markers to compare with.")
    gap = 1000 * np.linalg.norm(record.recorded_markers.positions - record.fitted_markers, axis=2)
    seen = np.isfinite(gap)
    if not seen.any():
        return Section(title, missing="no marker was both recorded and fitted.")
    count = seen.sum(axis=0)
    square = np.where(seen, gap, 0.0) ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        rms = np.sqrt(square.sum(axis=0) / count)
        frame_rms = np.sqrt(square.sum(axis=1) / seen.sum(axis=1))
    worst = np.where(count > 0, np.where(seen, gap, -np.inf).max(axis=0), np.nan)
    order = np.argsort(-np.nan_to_num(rms, nan=-1.0), kind="stable")
    names = record.recorded_markers.names
    bars = bar_plot(
        [names[i] for i in order],
        [float(rms[i]) for i in order],
        tips=[float(worst[i]) for i in order],
        colours=[RIGHT] * len(order),
        notes=["never seen" if not count[i] else _share(count[i], len(gap)) for i in order],
        title="Per marker",
        x_label="distance, root mean square (tick: largest) [mm]",
        width=520,
    )
    high = np.where(seen, gap, -np.inf).max(axis=1)
    curve = line_plot(
        [
            Series(record.motion.time, np.where(np.isfinite(high), high, np.nan), "largest",
                   MIDDLE, 1.2, 0.8),
            Series(record.motion.time, frame_rms, "root mean square", RIGHT, 2.0),
        ],
        title="Per frame",
        x_label="time [s]",
        y_label="distance [mm]",
        width=520,
        height=260,
        zero=True,
    )  # fmt: skip
    overall = float(np.sqrt(square.sum() / seen.sum()))
    text = (
        f"Distance between each recorded marker and the same marker on the fitted body: "
        f"{overall:.1f} mm root mean square over all markers and frames. Markers ride on skin, "
        "which slides over the bone by millimetres to centimetres in walking (Leardini et al. "
        "2005, Gait & Posture 21:212), so these distances cannot all vanish."
    )
    return Section(
        title,
        [
            Figure(bars, "The percentage is the share of frames in which the marker was seen."),
            Figure(curve, "A lone peak points to a swapped or flying marker."),
        ],
        text=text,
    )


def path_section(model: mujoco.MjModel, record: Record) -> Section:
    """Return the paths of the centre of mass and of the feet from above and from the side."""
    positions, _, com = poses(model, record.motion.qpos)
    time = record.motion.time
    feet = []
    for side, colour in (("r", RIGHT), ("l", LEFT)):
        bodies = np.flatnonzero(foot_bodies(model, side))
        if len(bodies):
            feet.append((SIDE_NAMES[side] + " foot", colour, positions[:, bodies[0]]))
    above = [Series(p[:, 0], p[:, 1], name, colour, 1.4) for name, colour, p in feet]
    above.append(Series(com[:, 0], com[:, 1], "centre of mass", MIDDLE, 2.2))
    beside = [Series(p[:, 0], p[:, 2], name, colour, 1.4) for name, colour, p in feet]
    beside.append(Series(com[:, 0], com[:, 2], "centre of mass", MIDDLE, 2.2))
    figures = [
        Figure(
            path_plot(above, title="From above", x_label="forward [m]", y_label="left [m]"),
            "In walking, the centre of mass sways towards the standing foot."
            if record.motion.events
            else "",
            wide=True,
        ),
        Figure(
            path_plot(
                beside,
                title="From the right",
                x_label="forward [m]",
                y_label="height [m]",
                ground=True,
            ),
            "Drawn to one scale. The origin of each foot is its ankle.",
            wide=True,
        ),
    ]
    figures.append(
        Figure(
            line_plot(
                [Series(time, 1000 * (com[:, 2] - com[:, 2].mean()), "", MIDDLE, 2.0)],
                title="Centre of mass, height",
                x_label="time [s]",
                y_label="above its mean [mm]",
                width=520,
            )
        )
    )
    if len(time) > 2:
        speed = np.linalg.norm(np.gradient(com[:, :2], time, axis=0), axis=1)
        figures.append(
            Figure(
                line_plot(
                    [Series(time, speed, "", MIDDLE, 2.0)],
                    title="Centre of mass, horizontal speed",
                    x_label="time [s]",
                    y_label="[m/s]",
                    width=520,
                )
            )
        )
    return Section("Paths of the centre of mass and the feet", figures)


def signed(base: str, unit: str) -> str:
    """Return the label of the vertical axis with what its ends mean, where that is known."""
    up, down = MEANINGS.get(base.removesuffix("_moment"), ("", ""))
    if base.endswith("_power"):
        up, down = "gives", "takes"
    return f"{down} ← [{unit}] → {up}" if up else f"[{unit}]"


def as_norm(value) -> Norm | None:
    """Return ``value`` as a :class:`Norm`; a tuple ``(percent, mean, sd)`` will do."""
    if value is None or isinstance(value, Norm):
        return value
    if hasattr(value, "percent") and hasattr(value, "mean") and hasattr(value, "sd"):
        return Norm(value.percent, value.mean, value.sd, str(getattr(value, "source", "")))
    percent, mean, sd, *rest = value
    source = str(rest[0]) if rest else ""
    return Norm(np.asarray(percent, float), np.asarray(mean, float), np.asarray(sd, float), source)


def mean_sd(values):
    """Return mean and standard deviation over rows, NaN left out; NaN where nothing is known."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(known, values, 0.0).sum(axis=0) / count
        spread = np.where(known, values - mean, 0.0) ** 2
        sd = np.sqrt(spread.sum(axis=0) / np.maximum(count - 1, 1))
    return mean, sd


def _share(count, total) -> str:
    """Return the share in percent; one gap in a long trial never reads as all."""
    return "100 %" if count == total else f"{min(99.9, 100 * count / total):.3g} %"
