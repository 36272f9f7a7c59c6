"""The report of a motion from a task: the verdict, how it was found, and what the feet do."""

import zipfile
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.errors import FileError
from plantigrade.record import Record
from plantigrade.charts import (
    LEFT,
    MIDDLE,
    RIGHT,
    SIDES,
    Bar,
    Outline,
    Series,
    line_plot,
    path_plot,
    timeline_plot,
)
from plantigrade.report.sections import LEAST, Figure, Section
from plantigrade.report.strip import _hull
from plantigrade.report.theme import SIDE_NAMES, side_of, title_of

FILE = "synthesis.npz"  # in the run folder
PREFIX = "drawn_"  # of what the report draws, beside what a warm start needs
TINY = 1e-9  # smaller violations are drawn here
PALETTE = ("#6b7280", "#009e73", "#0072b2", "#e0a100", "#cc79a7", "#d55e00", "#56b4e9", "#7e57c2")
QUANTITIES = {
    "root_force": "unexplained force on the body, most",
    "root_force_rms": "unexplained force on the body, RMS",
    "root_moment": "unexplained moment on the body, most",
    "root_moment_rms": "unexplained moment on the body, RMS",
    "slip": "slip of what stands",
    "slip_speed": "its speed",
    "penetration": "depth in the ground",
    "hover": "height of what stands above the ground",
    "friction": "friction, tangential over normal force",
    "adhesion": "pull of the ground",
    "pressure": "centre of pressure outside of what stands",
    "unsupported": "force where nothing stands",
    "force": "normal force at one place",
    "coordinate": "joint beyond its range",
    "velocity": "joint speed",
    "torque": "joint torque",
    "velocity_mismatch": "velocity against rate of position",
    "acceleration_mismatch": "acceleration against rate of velocity",
    "momentum": "rate of momentum against the forces",
    "energy": "rate of energy against the power of the joints",
}
POWERED = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle", "lumbar_extension")


@dataclass(frozen=True)
class SynthesisDrawing:
    """What the report draws of a motion from a task beyond its Record; kept in the run folder.

    Attributes:
        task: Name of the task.
        stage_names: Runs of a solver.
        stage_solvers: ``"interior-point"`` or ``"ipopt"``, by stage.
        stage_status: How each ended.
        stage_nodes: Nodes of each.
        stage_seconds: How long each took [s].
        history: Stage, iteration, objective, violation, optimality and seconds of every iteration.
        history_worst: The row that was violated most.
        check_quantity: What was looked at.
        check_value: The worst of it, in ``check_unit``.
        check_limit: What is allowed.
        check_time: When it was worst [s]; NaN for a mean over the motion.
        check_where: Site or coordinate; empty for the whole body.
        check_side: ``"r"``, ``"l"`` or empty.
        check_unit: Its unit.
        check_bad: Whether it is out of its limit.
        findings: What is wrong, in words.
        broken: Rows that are not kept, in words.
        time: Time of each frame [s].
        standing: Which site stands when.
        point: Lowest point of each site, world [m].
        force: Force at each site, world [N].
        site_names: Names of the sites.
        site_sides: ``"r"``, ``"l"`` or empty.
        site_segments: The body each one is on.
        pressure: Zero-moment point of the motion, world [m]; NaN in flight.
        com: Centre of mass [m].
        weight: Body weight [N].
        nodes: Times of the nodes of one lap [s].
    """

    task: str
    stage_names: tuple[str, ...]
    stage_solvers: tuple[str, ...]
    stage_status: tuple[str, ...]
    stage_nodes: Int[Array, " n_stages"]
    stage_seconds: Float[Array, " n_stages"]
    history: Float[Array, "n_iterations 6"]
    history_worst: tuple[str, ...]
    check_quantity: tuple[str, ...]
    check_value: Float[Array, " n_quantities"]
    check_limit: Float[Array, " n_quantities"]
    check_time: Float[Array, " n_quantities"]
    check_where: tuple[str, ...]
    check_side: tuple[str, ...]
    check_unit: tuple[str, ...]
    check_bad: Bool[Array, " n_quantities"]
    findings: tuple[str, ...]
    broken: tuple[str, ...]
    time: Float[Array, " n"]
    standing: Bool[Array, "n n_sites"]
    point: Float[Array, "n n_sites 3"]
    force: Float[Array, "n n_sites 3"]
    site_names: tuple[str, ...]
    site_sides: tuple[str, ...]
    site_segments: tuple[str, ...]
    pressure: Float[Array, "n 3"]
    com: Float[Array, "n 3"]
    weight: float
    nodes: Float[Array, " n_nodes"]

    def arrays(self) -> dict[str, Any]:
        """Return all of it as the run folder keeps it."""
        return {PREFIX + f.name: np.asarray(getattr(self, f.name)) for f in fields(self)}


def read_drawing(folder: Path) -> SynthesisDrawing | None:
    """Return what a run folder keeps of a motion from a task; None where it is of none.

    Raises:
        FileError: If the file is broken.
    """
    path = folder / FILE
    if not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as held:
            found: dict[str, Any] = {
                f.name: held[PREFIX + f.name] for f in fields(SynthesisDrawing)
            }
        for f in fields(SynthesisDrawing):
            if f.type == tuple[str, ...]:
                found[f.name] = tuple(str(word) for word in found[f.name])
        return SynthesisDrawing(
            **{**found, "task": str(found["task"]), "weight": float(found["weight"])}
        )
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise FileError(
            path, f"holds no motion from a task ({error})", remedy="make the run anew"
        ) from error


def first_sections(drawn: SynthesisDrawing) -> list[Section]:
    """Return the sections that come before all others: the verdict, and what is wrong if it is."""
    return [check_section(drawn), *fault_sections(drawn)]


def more_sections(model: mujoco.MjModel, record: Record, drawn: SynthesisDrawing) -> list[Section]:
    """Return the sections that come after the usual ones."""
    walk = bool(record.motion.events)
    return [
        *([] if walk else [power_section(model, record)]),
        segment_section(drawn),
        pressure_section(drawn),
        contact_section(drawn),
        use_section(model, record),
        convergence_section(drawn),
    ]


def facts_of(metrics: dict[str, Any], drawn: SynthesisDrawing) -> dict[str, str]:
    """Return the short figures at the top of the report."""
    facts = {"verdict": "passed" if metrics.get("status") == "ok" else "did not pass"}
    for label, unit, key, digits in (
        ("walking speed", " m/s", "walking_speed_m_s", 2),
        ("cadence", " steps/min", "cadence_steps_min", 0),
        ("distance", " m", "displacement_m", 2),
        ("duration", " s", "duration_s", 2),
        ("rise in flight", " m", "flight_rise_m", 2),
        ("take-off speed", " m/s", "take_off_speed_m_s", 2),
        ("knee range", "°", "knee_angle_range_r_deg", 0),
        ("vertical force, most", " BW", "ground_force_max_bw", 2),
        ("cost of transport", "", "cost_of_transport", 2),
        ("unexplained force, RMS", " % BW", "check_root_force_rms_bw_percent", 2),
        ("solved in", " s", "solve_time_s", 1),
    ):
        value = metrics.get(key)
        if value is None or (key == "displacement_m" and "walking_speed_m_s" in metrics):
            continue
        facts[label] = f"{value:.{digits}f}{unit}"
    return facts


# Sections -----------------------------------------------------------------------------------------


def check_section(drawn: SynthesisDrawing) -> Section:
    """Return the table of everything that was looked at: worst value, limit, where and when."""
    rows = []
    for i, quantity in enumerate(drawn.check_quantity):
        value, limit, time = drawn.check_value[i], drawn.check_limit[i], drawn.check_time[i]
        rows.append(
            [
                QUANTITIES.get(quantity, quantity.replace("_", " ")),
                _figure(value),
                _figure(limit) if np.isfinite(limit) else "–",
                drawn.check_unit[i],
                _place(drawn.check_where[i], drawn.check_side[i]),
                f"{time:.2f} s" if np.isfinite(time) else "",
                "–" if not np.isfinite(value) or not np.isfinite(limit)
                else "no" if drawn.check_bad[i] else "yes",
            ]
        )  # fmt: skip
    n, last = len(drawn.time), float(drawn.time[-1])
    text = (
        "The checker shares nothing with the optimiser: it looks at the finished motion in "
        f"{n} frames over {last:.2f} s, several between any two nodes, with MuJoCo's inverse "
        "dynamics, and alone decides whether the run is ok. What no contact explains must be "
        "(nearly) nothing; what stands must not slip. Negative figures are that far on the safe "
        "side."
    )
    return Section(
        "Check",
        text=text,
        headers=("quantity", "worst", "limit", "unit", "where", "when", "ok"),
        rows=rows,
    )


def fault_sections(drawn: SynthesisDrawing) -> list[Section]:
    """Return what is wrong in words, if anything is; the worst first."""
    found = []
    if drawn.findings:
        found.append(
            Section(
                "What the checker found",
                text="Worst first, relative to what is allowed.",
                headers=("", "finding"),
                rows=[[str(i), s] for i, s in enumerate(drawn.findings, 1)],
            )
        )
    if drawn.broken:
        found.append(
            Section(
                "What the solver could not keep",
                text="Of every kind of condition the one that is broken most, at the nodes of the "
                "last motion the solver had, and what to relax.",
                headers=("", "condition"),
                rows=[[str(i), s] for i, s in enumerate(drawn.broken, 1)],
            )
        )
    return found


def convergence_section(drawn: SynthesisDrawing) -> Section:
    """Return objective, violation and optimality over the iterations of all stages."""
    title = "How it was found"
    h = drawn.history
    if not len(h):
        return Section(title, missing="the solver told nothing of its iterations.")
    count = np.arange(float(len(h)))
    starts = [float(np.argmax(h[:, 0] == k)) for k in np.unique(h[:, 0])[1:]]
    marks = [(s - 0.5, MIDDLE) for s in starts]
    figures = [
        Figure(
            line_plot(
                [
                    Series(count, h[:, 3], "violation", RIGHT, 1.8),
                    Series(count, h[:, 4], "optimality", LEFT, 1.8),
                ],
                title="Errors",
                x_label="iteration",
                y_label="[1]",
                marks=marks,
                width=520,
                height=260,
                log=TINY,
            ),
            "Violation: the condition that is broken most, in its own unit (body weights, metres, "
            "radians, 100 N m). Optimality: how far the cost could still fall, scaled.",
        ),
        Figure(
            line_plot(
                [Series(count, h[:, 2], "", MIDDLE, 1.8)],
                title="Objective",
                x_label="iteration",
                y_label="[1]",
                marks=marks,
                width=520,
                height=260,
            ),
            "What the motion costs: squared torques, accelerations and forces, weighed and summed "
            "over time." + (" Upright lines: a new stage." if marks else ""),
        ),
    ]
    rows = []
    for k, name in enumerate(drawn.stage_names):
        mine = h[h[:, 0] == k]
        worst = [w for w, row in zip(drawn.history_worst, h, strict=True) if row[0] == k]
        rows.append(
            [
                name,
                {"interior-point": "banded interior point", "ipopt": "IPOPT"}.get(
                    drawn.stage_solvers[k], drawn.stage_solvers[k]
                ),
                str(int(drawn.stage_nodes[k])),
                str(max(len(mine) - 1, 0)),
                f"{drawn.stage_seconds[k]:.2f}",
                drawn.stage_status[k],
                _figure(mine[-1, 2]) if len(mine) else "",
                _power(mine[-1, 3]) if len(mine) else "",
                (worst[-1] if worst else "").replace("_", " "),
            ]
        )
    return Section(
        title,
        figures,
        headers=(
            "stage", "solver", "nodes", "iterations", "time [s]", "ended", "objective",
            "violation", "of",
        ),
        rows=rows,
    )  # fmt: skip


def segment_section(drawn: SynthesisDrawing) -> Section:
    """Return the vertical force under every segment of each foot, and under other supports."""
    title = "Contact forces by segment"
    figures = []
    for side in ("r", "l", ""):
        columns = [i for i, s in enumerate(drawn.site_sides) if s == side]
        groups: dict[str, list[int]] = {}
        for i in columns:
            groups.setdefault(_segment(drawn.site_segments[i]), []).append(i)
        total = drawn.force[:, columns, 2].sum(axis=1) / drawn.weight
        if not columns or not np.any(total):
            continue
        series = [
            Series(
                drawn.time, drawn.force[:, own, 2].sum(axis=1) / drawn.weight, name,
                PALETTE[1 + k % (len(PALETTE) - 1)], 1.6,
            )
            for k, (name, own) in enumerate(groups.items())
        ]  # fmt: skip
        if len(groups) > 1:
            series.insert(0, Series(drawn.time, total, "sum", SIDES[side or None], 2.0, 0.6, "5 3"))
        name = f"{SIDE_NAMES[side].capitalize()} foot" if side else "Other supports"
        figures.append(
            Figure(
                line_plot(
                    series,
                    title=name,
                    x_label="time [s]",
                    y_label="vertical [BW]",
                    width=520,
                    height=250,
                    zero=True,
                    least=LEAST["BW"],
                )
            )
        )
    if not figures:
        return Section(title, missing="nothing carried any force.")
    text = (
        "What the ground gives each segment of the foot, in body weights; the forces are unknowns "
        "of the problem, one at every place that can carry."
    )
    return Section(title, figures, text=text)


def pressure_section(drawn: SynthesisDrawing) -> Section:
    """Return the zero-moment point over the polygons of support, and its distance to their edge."""
    title = "Zero-moment point and support"
    asked = np.isfinite(drawn.pressure).all(axis=1)
    if not asked.any():
        return Section(title, missing="the motion asks nothing of the feet.")
    outlines = [
        Outline(hull, colour)
        for hull, colour in _supports(drawn)
        if len(hull) > 2
    ]  # fmt: skip
    series = [
        Series(drawn.com[:, 0], drawn.com[:, 1], "centre of mass", MIDDLE, 1.4, 1.0, "5 3"),
        Series(
            np.where(asked, drawn.pressure[:, 0], np.nan),
            np.where(asked, drawn.pressure[:, 1], np.nan),
            "zero-moment point",
            "var(--force, #b07c00)",
            2.2,
        ),
    ]
    above = Figure(
        path_plot(
            series,
            outlines=outlines,
            title="From above",
            x_label="forward [m]",
            y_label="left [m]",
        ),
        "Pale shapes: hulls of the places of each foot that stand, one for every change. The point "
        "where the ground's force has no moment lies in the hull of all that stands at the time, "
        "with both feet down between them.",
        wide=True,
    )
    inside = np.array([_depth(drawn, k) for k in range(len(drawn.time))])
    margin = Figure(
        line_plot(
            [Series(drawn.time, 1000.0 * inside, "", MIDDLE, 1.8)],
            title="Distance to the edge of the support",
            x_label="time [s]",
            y_label="inside [mm]",
            width=1060,
            height=230,
            zero=True,
            least=20.0,
        ),
        "Positive inside the hull of everything that stands; where only an edge of the foot "
        "stands, as at heel strike, the hull has no inside.",
        wide=True,
    )
    return Section(title, [above, margin])


def contact_section(drawn: SynthesisDrawing) -> Section:
    """Return which place of which foot stands when."""
    rows = []
    for side in ("r", "l", ""):
        for i, own in enumerate(drawn.site_sides):
            if own != side:
                continue
            bars = [
                Bar(drawn.time[a], drawn.time[b - 1], SIDES[side or None], opacity=0.6)
                for a, b in _runs(drawn.standing[:, i])
            ]
            rows.append((_place(drawn.site_names[i], side), bars))
    if not any(bars for _, bars in rows):
        return Section("What stands when", missing="nothing stands.")
    return Section(
        "What stands when",
        [Figure(timeline_plot(rows, title="", x_label="time [s]"), wide=True)],
        text="The plan of contact: the task decides it, the motion keeps it.",
    )


def power_section(model: mujoco.MjModel, record: Record) -> Section:
    """Return joint powers over time, for motions without gait cycles."""
    title = "Joint powers over time"
    if record.qfrc_actuator is None:
        return Section(title, missing="no torques were computed.")
    mass = float(model.body_mass.sum())
    time, names = record.motion.time, record.motion.joint_names[1:]
    figures = []
    for base in POWERED:
        series = []
        for name in (base, f"{base}_r", f"{base}_l"):
            if name in names:
                i = names.index(name)
                power = record.qfrc_actuator[:, 6 + i] * record.motion.qvel[:, 6 + i] / mass
                side = side_of(name)
                series.append(Series(time, power, SIDE_NAMES.get(side or "", ""), SIDES[side], 1.8))
        if series:
            figures.append(
                Figure(
                    line_plot(
                        series,
                        title=f"{title_of(base)} power",
                        x_label="time [s]",
                        y_label="takes ← [W/kg] → gives",
                        zero=True,
                        least=LEAST["W/kg"],
                    )
                )
            )
    return Section(title, figures, text="Torque times speed of the joint, per kilogram of body.")


def use_section(model: mujoco.MjModel, record: Record) -> Section:
    """Return how much of each joint's strength the motion takes."""
    from plantigrade.charts import bar_plot

    title = "Strength that is used"
    limited = [
        j for j in range(1, model.njnt)
        if model.jnt_actfrclimited[j] and np.abs(model.jnt_actfrcrange[j]).max() > 0
    ]  # fmt: skip
    if record.qfrc_actuator is None or not limited:
        return Section(title, missing="the joints of the model have no limits of torque.")
    rows = []
    for j in limited:
        tau = record.qfrc_actuator[:, 5 + j]
        low, high = model.jnt_actfrcrange[j]
        bound = np.where(tau > 0, max(high, 1e-9), min(low, -1e-9))
        name = model.joint(j).name
        most = int(np.argmax(tau / bound))
        rows.append((float(100 * tau[most] / bound[most]), name, float(tau[most])))
    rows = sorted(rows, reverse=True)[:16]
    figure = bar_plot(
        [_place(name, side_of(name) or "") for _, name, _ in rows],
        [use for use, _, _ in rows],
        title="",
        x_label="largest torque [% of the joint's limit in that direction]",
        colours=[SIDES[side_of(name)] for _, name, _ in rows],
        notes=[f"{tau:+.0f} N m".replace("-", "−") for _, _, tau in rows],
        width=720,
    )
    return Section(title, [Figure(figure, wide=True)], text="The joints that are used most.")


# Geometry -----------------------------------------------------------------------------------------


def _supports(drawn: SynthesisDrawing) -> list[tuple[np.ndarray, str]]:
    """Return hulls of each foot's standing places, one for each change of what stands."""
    found = []
    for side in ("r", "l"):
        mine = np.array([s == side for s in drawn.site_sides], bool)
        standing = drawn.standing & mine
        change = np.flatnonzero(np.any(standing[1:] != standing[:-1], axis=1)) + 1
        for a, b in zip([0, *change], [*change, len(drawn.time)], strict=True):
            middle = (a + b) // 2
            if standing[middle].sum() > 2:
                hull = _hull(drawn.point[middle, standing[middle], :2])
                found.append((hull, SIDES[side]))
    return found[:60]


def _depth(drawn: SynthesisDrawing, frame: int) -> float:
    """Return how far inside the hull of what stands the zero-moment point is [m]."""
    feet = [k for k, s in enumerate(drawn.site_sides) if s and drawn.standing[frame, k]]
    if not feet or not np.isfinite(drawn.pressure[frame]).all():
        return float("nan")
    hull = _hull(drawn.point[frame, feet, :2])
    p = drawn.pressure[frame, :2]
    if len(hull) < 3:
        return -_to_edges(p, hull)
    edge = np.roll(hull, -1, axis=0) - hull
    length = np.linalg.norm(edge, axis=1)
    away = p - hull
    side = (edge[:, 0] * away[:, 1] - edge[:, 1] * away[:, 0]) / np.maximum(length, 1e-12)
    return float(side.min()) if side.min() >= 0 else -_to_edges(p, hull)


def _to_edges(p: np.ndarray, hull: np.ndarray) -> float:
    """Return the distance of a point to the edges of a hull [m]."""
    a, b = hull, np.roll(hull, -1, axis=0)
    d = b - a
    share = np.einsum("ij,ij->i", p - a, d) / np.maximum(np.einsum("ij,ij->i", d, d), 1e-12)
    near = a + np.clip(share, 0, 1)[:, None] * d
    return float(np.linalg.norm(p - near, axis=1).min())


def _runs(mask: np.ndarray) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.r_[0, mask.astype(np.int8), 0]))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


# Words --------------------------------------------------------------------------------------------


def _segment(body: str) -> str:
    return body.removesuffix("_r").removesuffix("_l").replace("_", " ")


def _place(name: str, side: str) -> str:
    plain = name.removesuffix(f"_{side}") if side else name
    front = f"{SIDE_NAMES[side]} " if side in SIDE_NAMES and plain != name else ""
    return f"{front}{plain.replace('_', ' ')}"


def _figure(value: float) -> str:
    if not np.isfinite(value):
        return "–"
    text = f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    if abs(value) < 5e-4:
        text = "0"
    return text.replace("-", "−")


def _power(value: float) -> str:
    return f"{value:.1e}".replace("e-0", "e-").replace("-", "−") if np.isfinite(value) else "–"
