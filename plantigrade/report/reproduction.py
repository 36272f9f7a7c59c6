"""The report of a gait rebuilt from tasks: against the recorded one, and how it came about."""

import io
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np

from plantigrade.analyze.gait_study import PAPER_TABLE
from plantigrade.analyze.reproduction import ROTATIONS
from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.errors import FileError
from plantigrade.report import theme
from plantigrade.charts import (
    LEFT,
    MIDDLE,
    RIGHT,
    Band,
    Bar,
    Series,
    line_plot,
    timeline_plot,
)
from plantigrade.report.sections import Figure, Section, mean_sd, signed
from plantigrade.report.theme import SIDE_NAMES, side_of, title_of

FILE = "reproduction.npz"  # in the run folder
RECORDED = f"var(--recorded, {theme.REFERENCE})"
SIDES = ("r", "l")
COLOURS = {"r": RIGHT, "l": LEFT}
REGIONS = ("heel", "ball", "toes")
SHOWN = (
    *(name for _, name in ROTATIONS),
    *("mtp_angle_r", "mtp_angle_l", "pelvis_tilt", "pelvis_list", "pelvis_rotation"),
    *("lumbar_extension", "lumbar_bending", "lumbar_rotation"),
    *("arm_flex_r", "arm_flex_l", "elbow_flex_r", "elbow_flex_l"),
)
PALETTE = ("#6b7280", "#009e73", "#0072b2", "#e0a100", "#cc79a7", "#d55e00", "#56b4e9", "#7e57c2")
TINY = 1e-8  # residuals below this are drawn here: they are zero but for rounding
AXES = ("forward", "sideways (left positive)", "vertical")
LONGEST = 60  # bars of one row of the timeline beyond which only its beginning is drawn


@dataclass(frozen=True)
class Reproduction:
    """What the report draws of a reproduced gait beyond its Record; kept in the run folder.

    Attributes:
        tasks: Name of the set of tasks.
        names: Names of the tasks, in order.
        level: Level of each task; 1 is the most important below the limits of the joints.
        meanings: What each task does, one sentence each.
        time: Time of each tick [s].
        active: Whether each task asked for anything.
        residual: By how much each task's acceleration was missed [its unit per s²].
        phase: Start and stop of each phase [s].
        phase_kind: ``"double"`` or ``"single"``, by phase.
        phase_swing: The foot that swings, or will next.
        posture_end: When each posture is to be reached [s].
        contact: Start and stop of each planned contact [s].
        contact_place: ``heel_r``, ``ball_r``, …, by contact.
        percent: Percent of the gait cycle.
        coordinates: Names of the coordinates below.
        simulated: Angles of each cycle, reproduced [°]; NaN where a coordinate has fewer.
        recorded: Likewise, recorded.
        rom: Range of motion, reproduced and recorded [°].
        rmse: Root mean square difference [°].
        correlation: Pearson's r.
        com_error: Distance of the centre of mass from its path [m].
        sole: Height of the lowest point of each foot, right and left [m].
        sole_recorded: Likewise, of the recorded motion on the same soles.
        force_time: Time of each tick of the forces [s]; empty where there are none.
        force: Ground reaction on each foot, right and left [body weights].
        force_measured: Likewise, measured; NaN where not known. Empty where nothing was measured.
        moment_names: Joints below.
        moment: Joint moments [N m/kg].
        moment_measured: Likewise, from the measured forces and the recorded motion.
    """

    tasks: str
    names: tuple[str, ...]
    level: Int[Array, " n_tasks"]
    meanings: tuple[str, ...]
    time: Float[Array, " n"]
    active: Bool[Array, "n n_tasks"]
    residual: Float[Array, "n n_tasks"]
    phase: Float[Array, "n_phases 2"]
    phase_kind: tuple[str, ...]
    phase_swing: tuple[str, ...]
    posture_end: Float[Array, " n_ends"]
    contact: Float[Array, "n_contacts 2"]
    contact_place: tuple[str, ...]
    percent: Float[Array, " n_percent"]
    coordinates: tuple[str, ...]
    simulated: Float[Array, "n_coordinates n_cycles n_percent"]
    recorded: Float[Array, "n_coordinates n_cycles n_percent"]
    rom: Float[Array, "n_coordinates 2"]
    rmse: Float[Array, " n_coordinates"]
    correlation: Float[Array, " n_coordinates"]
    com_error: Float[Array, " n"]
    sole: Float[Array, "n 2"]
    sole_recorded: Float[Array, "n 2"]
    force_time: Float[Array, " n_forces"] = field(default_factory=lambda: np.zeros(0))
    force: Float[Array, "n_forces 2 3"] = field(default_factory=lambda: np.zeros((0, 2, 3)))
    force_measured: Float[Array, "n_forces_measured 2 3"] = field(
        default_factory=lambda: np.zeros((0, 2, 3))
    )
    moment_names: tuple[str, ...] = ()
    moment: Float[Array, "n_forces n_moments"] = field(default_factory=lambda: np.zeros((0, 0)))
    moment_measured: Float[Array, "n_forces_measured n_moments"] = field(
        default_factory=lambda: np.zeros((0, 0))
    )

    def to_npz(self) -> bytes:
        """Return all of it as the run folder keeps it."""
        stream = io.BytesIO()
        np.savez_compressed(stream, **{f.name: getattr(self, f.name) for f in fields(self)})
        return stream.getvalue()


def read_reproduction(folder: Path) -> Reproduction | None:
    """Return what a run folder keeps of a reproduced gait; None where it is of none.

    Raises:
        FileError: If the file is broken.
    """
    path = folder / FILE
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as held:
            found = {f.name: held[f.name] for f in fields(Reproduction)}
        words = ("names", "meanings", "phase_kind", "phase_swing", "contact_place", "coordinates")
        for name in (*words, "moment_names"):
            found[name] = tuple(str(word) for word in found[name])
        return Reproduction(**{**found, "tasks": str(found["tasks"])})
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise FileError(
            path, f"holds no reproduced gait ({error})", remedy="make the run anew"
        ) from error


def reproduction_sections(found: Reproduction) -> list[Section]:
    """Return the sections of the report, the most telling first."""
    return [
        curve_section(found),
        rom_section(found),
        task_section(found),
        residual_section(found),
        foot_section(found),
        force_section(found),
        moment_section(found),
    ]


def curve_section(found: Reproduction) -> Section:
    """Return reproduced and recorded angles over the gait cycle."""
    title = "Reproduced against recorded angles"
    shown = [found.coordinates.index(name) for name in SHOWN if name in found.coordinates]
    if not found.simulated.shape[1]:
        return Section(title, missing="the walk holds no whole gait cycle to draw them over.")
    figures = [
        Figure(
            pair_plot(
                found.percent,
                found.simulated[i],
                found.recorded[i],
                title=_sided(found.coordinates[i]),
                colour=COLOURS.get(side_of(found.coordinates[i]) or "", MIDDLE),
                y_label=signed(_plain(found.coordinates[i]), "°"),
                note=f"RMSE {found.rmse[i]:.1f}°, r {_r(found.correlation[i])}",
            )
        )
        for i in shown
    ]
    text = (
        "Full line: reproduced from the tasks; violet dashes: recorded. Of these angles the tasks "
        "know only the posture at the end of each phase. Curves are cut at the recorded heel "
        "strikes of their own side (pelvis and trunk: right); where there are several cycles, "
        "bands are one standard deviation."
    )
    return Section(title, figures, text=text)


def pair_plot(
    percent: Float[Array, " n_percent"],
    simulated: Float[Array, "n_cycles n_percent"],
    recorded: Float[Array, "n_cycles n_percent"],
    *,
    title: str,
    colour: str,
    y_label: str,
    note: str = "",
    least: float = 10.0,
    width: int = 330,
    height: int = 210,
    words: tuple[str, str] = ("", ""),
) -> str:
    """Return a plot of reproduced and recorded curves: mean and standard deviation of rows.

    Args:
        percent: Percent of the gait cycle.
        simulated: Reproduced; NaN where not known.
        recorded: Likewise, recorded.
        title: Above the plot.
        colour: Of the reproduced curve.
        y_label: With its unit.
        note: At the right of the title.
        least: The vertical axis spans at least this much.
        width: Of the drawing [px].
        height: Of the drawing [px].
        words: Names of both curves in the legend; none where empty.
    """
    bands, series = [], []
    for rows, shade, dash, label in (
        (recorded, RECORDED, "5 3", words[1]),
        (simulated, colour, "", words[0]),
    ):
        rows = rows[np.isfinite(rows).any(axis=1)]
        if not len(rows):
            continue
        mean, sd = mean_sd(rows)
        if len(rows) > 1:
            bands.append(Band(percent, mean - sd, mean + sd, shade, 0.15))
        series.append(Series(percent, mean, label, shade, 1.8, 1.0, dash))
    return line_plot(
        series,
        bands=bands,
        title=title,
        x_label=f"gait cycle [%] · {note}" if note else "gait cycle [%]",
        y_label=y_label,
        least=least,
        width=width,
        height=height,
    )


def rom_section(found: Reproduction) -> Section:
    """Return the table of ranges of motion beside the paper's."""
    rows = []
    for label, name in ROTATIONS:
        if name not in found.coordinates:
            continue
        i = found.coordinates.index(name)
        ours, theirs = found.rom[i]
        paper = PAPER_TABLE[name]
        rows.append(
            [
                label,
                f"{ours:.1f}",
                f"{theirs:.1f}",
                difference(ours - theirs),
                f"{found.rmse[i]:.1f}",
                _r(found.correlation[i]),
                str(paper.simulated),
                str(paper.reference),
                difference(-paper.difference, 0),
            ]
        )
    places = [found.coordinates.index(name) for _, name in ROTATIONS if name in found.coordinates]
    errors = np.abs(np.diff(found.rom[places], axis=1))
    text = (
        "Range of motion over the gait cycle in degrees, mean over the cycles, and the root mean "
        "square difference (RMSE) and correlation (r) of the curves. The paper's columns are the "
        "means of nine people (Boukheddimi et al., Table I)."
    )
    if len(errors):
        text += f" Mean difference {np.mean(errors):.1f}°, largest {np.max(errors):.1f}°."
    return Section(
        "Ranges of motion",
        text=text,
        headers=(
            "rotation", "reproduced", "recorded", "difference", "RMSE", "r",
            "paper: simulated", "recorded", "difference",
        ),
        rows=rows,
        missing="" if rows else "the body has none of the rotations of the paper's table.",
    )  # fmt: skip


def task_section(found: Reproduction) -> Section:
    """Return the order of the tasks, and the phases, contacts and tasks over time."""
    last = found.time[-1] if len(found.time) else 0.0
    shown = found.phase[:LONGEST]
    end = float(shown[-1, 1]) if len(shown) < len(found.phase) else last
    rows: list[tuple[str, list[Bar]]] = [("phase", [])]
    for (start, stop), kind, swing in zip(
        found.phase, found.phase_kind, found.phase_swing, strict=True
    ):
        words = "double support" if kind == "double" else f"{SIDE_NAMES[swing]} swings"
        colour = MIDDLE if kind == "double" else COLOURS[swing]
        rows[0][1].append(Bar(start, stop, colour, words, 0.35))
    for side in SIDES:
        for region in REGIONS:
            place = f"{region}_{side}"
            mine = [
                Bar(start, stop, COLOURS[side], opacity=0.6)
                for (start, stop), of in zip(found.contact, found.contact_place, strict=True)
                if of == place
            ]
            rows.append((f"{SIDE_NAMES[side]} {region} on the ground", mine))
    for k, name in enumerate(found.names):
        bars = [Bar(a, b, _tint(found.level[k])) for a, b in _stretches(found, k)]
        rows.append((f"{found.level[k]}  {_words(name)}", bars))
    ends = [float(t) for t in found.posture_end if t <= end]
    cut = [(label, [b for b in (_cut(bar, end) for bar in bars) if b]) for label, bars in rows]
    figure = Figure(
        timeline_plot(cut, title="What is on when", x_label="time [s]", marks=ends),
        "Upright lines: where a phase ends and its posture is to be reached. A numbered row is a "
        "task, with its level; its bar shows when the task asks for anything."
        + (f" The first {end:.1f} s of {last:.1f} s are drawn." if end < last else ""),
        wide=True,
    )
    table = [["0", "limits of the joints", "Range, speed and acceleration of every joint."]]
    table += [
        [str(found.level[k]), _words(name), found.meanings[k]] for k, name in enumerate(found.names)
    ]
    text = (
        f"The tasks of the set “{found.tasks}”, most important first. A task of a lower level is "
        "done as well as the levels above it leave freedom, and never changes what they reach."
    )
    return Section(
        "The tasks and when they act",
        [figure],
        text=text,
        headers=("level", "task", "what it does"),
        rows=table,
    )


def residual_section(found: Reproduction) -> Section:
    """Return by how much each level was missed over time."""
    levels = sorted({int(v) for v in found.level})
    series = []
    for level in levels:
        mine = found.level == level
        missed = np.sqrt(np.sum(np.where(found.active, found.residual, 0.0)[:, mine] ** 2, axis=1))
        missed = np.where(found.active[:, mine].any(axis=1), missed, np.nan)
        names = [_words(name) for name, m in zip(found.names, mine, strict=True) if m]
        names = dict.fromkeys(n.removesuffix(" right").removesuffix(" left") for n in names)
        series.append(
            Series(found.time, missed, f"{level} {', '.join(names)}", _tint(level), 1.3, 0.9)
        )
    figure = Figure(
        line_plot(
            series,
            title="",
            x_label="time [s]",
            y_label="acceleration missed [1/s²]",
            width=1060,
            height=320,
            log=TINY,
        ),
        "Logarithmic; lines at the lower edge are zero but for rounding. A level stands out where "
        "those above it, or a limit of a joint, leave it no freedom.",
        wide=True,
    )
    text = (
        "Norm of the difference between the acceleration each level asks for and the one it gets, "
        "in m/s² (posture: rad/s²)."
    )
    return Section("What each level missed", [figure], text=text)


def foot_section(found: Reproduction) -> Section:
    """Return how far the centre of mass was off, and how high the feet were."""
    figures = [
        Figure(
            line_plot(
                [Series(found.time, 1e3 * found.com_error, "", MIDDLE, 1.8)],
                title="Centre of mass off its path",
                x_label="time [s]",
                y_label="[mm]",
                width=520,
                zero=True,
                least=1.0,
            ),
            f"Largest {1e3 * np.max(found.com_error, initial=0.0):.2f} mm.",
        )
    ]
    for k, side in enumerate(SIDES):
        figures.append(
            Figure(
                line_plot(
                    [
                        Series(found.time, 1e3 * found.sole_recorded[:, k], "recorded", RECORDED,
                               1.6, 1.0, "5 3"),
                        Series(found.time, 1e3 * found.sole[:, k], "reproduced", COLOURS[side]),
                    ],
                    title=f"{SIDE_NAMES[side].capitalize()} sole",
                    x_label="time [s]",
                    y_label="lowest point above ground [mm]",
                    width=520,
                    zero=True,
                    least=20.0,
                )
            )
        )  # fmt: skip
    text = (
        "No task tracks the height of the feet: it follows from the centre of mass, the heels' "
        "paths over the ground, the posture at the end of each phase, and the floor, into which no "
        "point of a sole may go."
    )
    return Section("Centre of mass and soles", figures, text=text)


def force_section(found: Reproduction) -> Section:
    """Return the ground reactions of the dynamic hierarchy beside the measured ones."""
    title = "Ground reactions: computed beside measured"
    if not len(found.force_time):
        return Section(title, missing="the hierarchy of forces was not asked for.")
    measured = found.force_measured if len(found.force_measured) else None
    figures = []
    for axis in (2, 0, 1):
        for k, side in enumerate(SIDES):
            figures.append(
                Figure(
                    line_plot(
                        _beside(
                            found.force_time,
                            found.force[:, k, axis],
                            None if measured is None else measured[:, k, axis],
                            COLOURS[side],
                        ),
                        title=f"{SIDE_NAMES[side].capitalize()}, {AXES[axis]}",
                        x_label="time [s]",
                        y_label="[BW]",
                        width=520,
                        zero=True,
                        least=0.1,
                    )
                )
            )
    text = (
        "Force of the ground on each foot in body weights. Full line: from the hierarchy with "
        "forces and joint torques as unknowns, which knows no measured force"
    )
    text += "; violet dashes: measured." if measured is not None else ". None was measured."
    text += (
        " They belong to a motion of their own (forces.npz): a body that balances cannot follow "
        "the recorded centre of mass to the millimetre. The sections over the gait cycle further "
        "down, and the arrows of the pictures, show the same forces."
    )
    return Section(title, figures, text=text)


def moment_section(found: Reproduction) -> Section:
    """Return the joint moments of the dynamic hierarchy beside those of inverse dynamics."""
    title = "Joint moments: computed beside measured"
    if not len(found.force_time):
        return Section(title, missing="the hierarchy of forces was not asked for.")
    measured = found.moment_measured if len(found.moment_measured) else None
    figures = [
        Figure(
            line_plot(
                _beside(
                    found.force_time,
                    found.moment[:, i],
                    None if measured is None else measured[:, i],
                    COLOURS.get(side_of(name) or "", MIDDLE),
                ),
                title=_sided(name),
                x_label="time [s]",
                y_label=signed(_plain(name), "N m/kg"),
                width=520,
                zero=True,
                least=0.2,
            )
        )
        for i, name in enumerate(found.moment_names)
    ]
    text = "Internal moments per body mass, from the hierarchy of forces"
    if measured is not None:
        text += "; violet dashes: inverse dynamics of the recorded motion and the measured forces"
    return Section(title, figures, text=text + ".")


def facts_of(metrics: dict) -> dict[str, str]:
    """Return the short figures that are shown large."""
    facts = {}
    for label, unit, key, digits in (
        ("range of motion off, mean", "°", "rom_error_mean_deg", 1),
        ("range of motion off, worst", "°", "rom_error_max_deg", 1),
        ("centre of mass off, most", " mm", "com_error_max_mm", 1),
        ("contact drift, most", " mm", "contact_drift_max_mm", 1),
        ("lowest point of the soles", " mm", "sole_lowest_mm", 1),
        ("time per gait cycle", " s", "time_per_cycle_s", 2),
        ("vertical force off, RMSE", " BW", "vertical_force_rmse_bw", 3),
    ):
        if metrics.get(key) is not None:
            facts[label] = f"{metrics[key]:.{digits}f}{unit}".replace("-", "−")
    return facts


def difference(value: float, digits: int = 1) -> str:
    """Return a signed figure with a true minus sign."""
    text = f"{value:+.{digits}f}"
    return (text if float(text) else text[1:]).replace("-", "−")


def _r(correlation: float) -> str:
    return f"{correlation:.2f}".replace("-", "−") if np.isfinite(correlation) else "–"


def _beside(time, ours, theirs, colour) -> list[Series]:
    series = []
    if theirs is not None and np.isfinite(theirs).any():
        series.append(Series(time, theirs, "measured", RECORDED, 1.6, 1.0, "5 3"))
    return [*series, Series(time, ours, "computed", colour, 1.8)]


def _stretches(found: Reproduction, k: int) -> list[tuple[float, float]]:
    """Return when a task is active, as stretches of time."""
    on = np.concatenate([[False], found.active[:, k], [False]])
    edges = np.flatnonzero(np.diff(on.astype(int)))
    time = np.append(found.time, found.time[-1])
    return [(float(time[a]), float(time[b])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _cut(bar: Bar, end: float) -> Bar | None:
    if bar.start >= end:
        return None
    return Bar(bar.start, min(bar.stop, end), bar.colour, bar.label, bar.opacity)


def _tint(level) -> str:
    return PALETTE[int(level) % len(PALETTE)]


def _words(name: str) -> str:
    """Return a task's name with its side written out."""
    stem, _, side = name.rpartition(" ")
    return f"{stem} {SIDE_NAMES[side]}" if side in SIDE_NAMES and stem else name


def _plain(name: str) -> str:
    return name[:-2] if side_of(name) else name


def _sided(name: str) -> str:
    side = side_of(name)
    return f"{title_of(name)}, {SIDE_NAMES[side]}" if side else title_of(name)


def stacked(curves: Sequence[np.ndarray]) -> np.ndarray:
    """Return curves of unlike numbers of cycles in one array, NaN where one has fewer."""
    n = max((len(c) for c in curves), default=0)
    width = max((c.shape[1] for c in curves), default=0)
    whole = np.full((len(curves), n, width), np.nan)
    for i, rows in enumerate(curves):
        whole[i, : len(rows)] = rows
    return whole
