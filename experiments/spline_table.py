"""The four motions of [Zhakatayev2023]_, solved as the paper sets them, its numbers beside ours.

Both bases, stage by stage; then every motion is looked at between its sample times. Figures 5 to 8
are drawn again, the walk's knee beside measured ones.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from scipy.signal import find_peaks

from experiments.table import ResultTable, Row, at_most, equal, sheet, sheets_of
from plantigrade.analyze.norms import CHILDREN, norm
from plantigrade.charts import LEFT, MIDDLE, RIGHT, Ribbon, Series, line_plot
from plantigrade.constants import GRAVITY
from plantigrade.trajopt.zhakatayev2023 import (
    BASES,
    MOTIONS,
    PaperSolution,
    paper_human,
    paper_motion,
)

Solutions = Mapping[tuple[str, str], PaperSolution]
"""Task and basis → what was found."""

MAX_MOTION_TIME = 2.0  # goal for a motion
WALKS = ("cmu_asfamc/02_01.amc", "cmu_asfamc/07_01.amc", "cmu_asfamc/16_15.amc")
QUICK_TASKS = ("walk", "jump")
FIGURES = {"walk": 5, "sit-to-stand": 6, "side-step": 7, "jump": 8}

NOTES = (
    "",
    "How to read it: constraints are counted as the paper does (equations twice, boundary "
    "conditions not). Ours of the jump are fewer: the paper's contact matrix has five columns for "
    "four sample times, and the feet leave at the last. Iterations and times are those of all "
    "stages, setting up included; 'processor' is the time the one thread was given a processor "
    "for, which does not depend on what else runs. The paper's times were measured on a notebook "
    "with MATLAB's fmincon, and its tolerance on constraints is 4e-2; ours is 1e-5, with 0.04 m/s "
    "for the speed of standing feet. Times do not compare method with method. 'effort' is Eq. "
    "15 at the solution.",
    "Between the samples, on a grid ten times as fine, by MuJoCo's inverse dynamics: how far the "
    "zero-moment point is outside the hull of the standing feet, the root moment that no contact "
    "can therefore explain (of body weight times metre), how far the vertical force exceeds 1.4 "
    "body weights, the friction coefficient the motion would need, how deep feet are in the "
    "ground, how far standing feet are off their places, and by how much limits of angles, rates "
    "and joint torques are exceeded. The paper looks at its samples only, where all of this is "
    "zero; so these motions are not dynamically valid, on either basis.",
    "The joint torques are those of a body held at the pelvis, as in the paper: no force acts on "
    "the feet, and the legs' torques are not those of legs that carry.",
)


def run(
    data: Path | None = None,
    *,
    out: Path | None = None,
    quick: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> ResultTable:
    """Return the table; with measured knees where there are recordings."""
    human = paper_human()
    found: dict[tuple[str, str], PaperSolution] = {}
    for task in QUICK_TASKS if quick else MOTIONS:
        for basis in BASES:
            prefix = f"{task}, {basis}: "
            found[task, basis] = paper_motion(
                human, task, basis, say=lambda line, prefix=prefix: say(prefix + line)
            )
    knees = measured_knees(data) if data is not None else {}
    rows: list[Row] = []
    for (task, basis), solution in found.items():
        rows += solution_rows(f"{task} {basis}", solution)
    sheets = [
        solved_sheet(found),
        stage_sheet(found),
        *sheets_of("At the samples, and between them at worst", rows),
        motion_sheet(found, knees),
    ]
    notes: list[str] = list(NOTES)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        for name, drawing in figures(found, knees).items():
            (out / name).write_text(drawing, encoding="utf-8")
        notes.append(f"The figures are in {out}.")
    return ResultTable("Motions of the spline paper", rows, notes, sheets)


def solution_rows(subject: str, solution: PaperSolution) -> list[Row]:
    """Return what one motion is held against, and what was found between its samples."""
    r, b = solution.result, solution.between
    printed = solution.paper.motion.printed
    return [
        equal(subject, "variables", r.c.size, printed.variables),
        Row(subject, "constraints", solution.paper.n_constraints),
        equal(subject, "solved", float(r.success), 1),
        Row(subject, "iterations", r.iterations),
        Row(subject, "time", r.seconds, "s"),
        at_most(subject, "processor time", r.cpu_seconds, MAX_MOTION_TIME, "s"),
        at_most(subject, "violation", r.violation, 2e-5),
        Row(subject, "effort", solution.effort),
        Row(subject, "zero-moment point outside", 1e3 * b.zmp, "mm"),
        Row(subject, "unexplained moment", 100 * b.moment, "%"),
        Row(subject, "penetration", 1e3 * b.penetration, "mm"),
        Row(subject, "drift", 1e3 * b.drift, "mm"),
        Row(subject, "pull", 100 * b.pull, "%"),
        Row(subject, "load above the limit", 100 * b.load, "%"),
        Row(subject, "friction", b.friction),
        Row(subject, "angle beyond its limits", np.degrees(b.angle), "deg"),
        Row(subject, "rate beyond its limits", b.rate, "rad/s"),
        Row(subject, "torque beyond its limits", b.torque, "N m"),
    ]


def solved_sheet(found: Solutions) -> str:
    """Return size, time and end of every solution, the paper's beside."""
    header = ("", "basis", "variables", "paper", "constraints", "paper", "iterations", "s")
    header += ("processor", "paper s", "effort", "violation", "solved")
    lines = []
    for (_, basis), s in found.items():
        p, r = s.paper.motion.printed, s.result
        counts = (r.c.size, p.variables, s.paper.n_constraints, p.constraints, r.iterations)
        cells = [s.paper.motion.title, basis, *map(str, counts)]
        cells += [f"{r.seconds:.2f}", f"{r.cpu_seconds:.2f}", f"{p.seconds:g}"]
        cells += [f"{s.effort:.3f}", f"{r.violation:.0e}", "yes" if r.success else "no"]
        lines.append(cells)
    return sheet("Solutions", header, lines)


def stage_sheet(found: Solutions) -> str:
    """Return every try of every stage."""
    header = ("", "stage", "solver", "iterations", "s", "processor", "violation", "ended")
    lines = []
    for (_, basis), s in found.items():
        for stage in s.result.stages:
            cells = [f"{s.paper.motion.title}, {basis}", stage.name, stage.solver]
            cells += [f"{stage.iterations}", f"{stage.seconds:.2f}", f"{stage.cpu_seconds:.2f}"]
            lines.append([*cells, f"{stage.violation:.0e}", stage.status])
    return sheet("Stage by stage", header, lines)


def motion_sheet(found: Solutions, knees: Mapping[str, np.ndarray]) -> str:
    """Return how the pelvis and the right knee move, the paper's figures beside."""
    header = ("", "basis", "forward", "to the right", "up", "down", "peak speed up", "knee from")
    header += ("to", "paper")
    lines: list[tuple[str, ...]] = [("", "", "cm", "cm", "cm", "cm", "m/s", "deg", "deg", "")]
    said = {
        "walk": "120 cm forward",
        "sit-to-stand": "44 cm forward and up",
        "side-step": "30 cm to the right, at most 1.6 cm up or down",
        "jump": "1.8 m/s, 16 cm of height",
    }
    for (task, basis), s in found.items():
        forward, up, right = (s.coordinate(f"pelvis_t{axis}") for axis in "xyz")
        knee = np.degrees(s.coordinate("knee_angle_r"))
        speed = float(s.rate("pelvis_ty").max())
        note = said[task]
        if task == "jump":
            height = 100 * float(s.rate("pelvis_ty")[-1]) ** 2 / (2 * GRAVITY)
            note += f"; ours reaches {height:.0f} cm"
        ways = (forward[-1] - forward[0], right[-1] - right[0], up.max() - up[0], up[0] - up.min())
        cells = [s.paper.motion.title, basis, *(f"{100 * way:.1f}" for way in ways)]
        lines.append((*cells, f"{speed:.2f}", f"{knee.min():.0f}", f"{knee.max():.0f}", note))
    band = norm("knee_angle", "free")
    text = [sheet("Pelvis and right knee", header, lines)]
    text.append(
        f"Specification knees of walking: {band.mean.min():.0f} to {band.mean.max():.0f} deg on "
        f"average, {CHILDREN.people}, {CHILDREN.citation}"
    )
    text += [f"  {n}: {k.min():.0f} to {k.max():.0f} deg" for n, k in knees.items()]
    return "\n".join(text)


def stride_knee(solution: PaperSolution) -> tuple[np.ndarray, np.ndarray]:
    """Return percent of the stride and right knee angle [deg] of the walk's one full stride.

    It goes from where the right foot lands after its half step to where it lands again.
    """
    motion, times = solution.paper.motion, solution.course.times
    landed = [
        k
        for k in range(1, motion.n_samples)
        if motion.right_places[k] != motion.right_places[k - 1]
    ]
    start, stop = motion.times[landed[0]], motion.times[landed[1]]
    inside = (times >= start - 1e-9) & (times <= stop + 1e-9)
    percent = 100 * (times[inside] - start) / (stop - start)
    return percent, np.degrees(solution.coordinate("knee_angle_r")[inside])


def measured_knees(data: Path) -> dict[str, np.ndarray]:
    """Return right knee angles [deg] of recorded strides in percent, by recording."""
    knees = {name: acclaim_knee(data / name) for name in WALKS if (data / name).exists()}
    return {name: knee for name, knee in knees.items() if knee is not None}


def acclaim_knee(path: Path) -> np.ndarray | None:
    """Return the mean stride of the right knee in an Acclaim motion [deg]; None without strides.

    It is the knee's own channel, which needs no fit; a stride is taken from one deepest swing to
    the next and turned so that the swing comes where it does in the norms.
    """
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    angle = np.array([float(x.split()[1]) for x in lines if x.startswith("rtibia ")])
    peaks = find_peaks(angle, height=45.0, distance=80)[0]  # 120 frames a second
    strides = [
        np.interp(np.linspace(a, b, 101), np.arange(len(angle)), angle)
        for a, b in zip(peaks[:-1], peaks[1:], strict=True)
        if b - a < 200
    ]
    if not strides:
        return None
    percent = norm("knee_angle", "free").percent
    swing = float(percent[np.argmax(norm("knee_angle", "free").mean)])
    return np.roll(np.mean(strides, axis=0)[:100], round(swing))


def figures(found: Solutions, knees: Mapping[str, np.ndarray]) -> dict[str, str]:
    """Return Figs. 5 to 8 as drawings by file name: pelvis in three directions, right knee."""
    drawings = {}
    colours: dict[str, str] = dict(zip(BASES, (RIGHT, LEFT), strict=True))
    for task, number in FIGURES.items():
        pair = {basis: found[task, basis] for basis in BASES if (task, basis) in found}
        if not pair:
            continue
        panels = (("up", "pelvis_ty"), ("forward", "pelvis_tx"), ("to the right", "pelvis_tz"))
        for letter, (direction, name) in zip("abc", panels, strict=True):
            series = [
                Series(
                    s.course.times,
                    100 * (s.coordinate(name) - s.coordinate(name)[0]),
                    basis,
                    colours[basis],
                )
                for basis, s in pair.items()
            ]
            series += [_samples(s, name, 100.0, colours[basis]) for basis, s in pair.items()]
            drawings[f"figure{number}{letter}.svg"] = line_plot(
                series, title=f"{task}: pelvis {direction}", y_label="displacement [cm]"
            )
        knee, bands = [], []
        for basis, s in pair.items():
            x, y = (
                stride_knee(s)
                if task == "walk"
                else (s.course.times, np.degrees(s.coordinate("knee_angle_r")))
            )
            knee.append(Series(x, y, basis, colours[basis]))
        if task == "walk":
            b = norm("knee_angle", "free")
            bands.append(Ribbon(b.percent, b.mean - b.sd, b.mean + b.sd))
            knee += [
                Series(np.linspace(0, 99, 100), k, "" if i else "recorded", MIDDLE, 1.2, 0.7, "3 3")
                for i, k in enumerate(knees.values())
            ]
        drawings[f"figure{number}d.svg"] = line_plot(
            knee,
            bands=bands,
            title=f"{task}: right knee",
            x_label="gait cycle [%]" if task == "walk" else "time [s]",
            y_label="flexion [°]",
        )
        if task == "jump":
            series = [
                Series(s.course.times, s.rate("pelvis_ty"), basis, colours[basis])
                for basis, s in pair.items()
            ]
            drawings["figure8e.svg"] = line_plot(
                series, title="jump: pelvis, speed up", y_label="speed [m/s]"
            )
    return drawings


def _samples(solution: PaperSolution, name: str, scale: float, colour: str) -> Series:
    """Return the samples alone, as a dashed line through them: what the constraints see."""
    times = solution.paper.motion.times
    values = np.interp(times, solution.course.times, solution.coordinate(name))
    return Series(times, scale * (values - values[0]), "", colour, 1.0, 0.5, "2 3")
