"""The run folder of a motion from a task: written whole, read back to start another one from."""

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.errors import FileError
from plantigrade.workflows.synthesize import (
    Synthesized,
    SynthesizeSettings,
    task_of,
    under_test,
)

if TYPE_CHECKING:
    from plantigrade.contact.plan import ContactPlan
    from plantigrade.record import Record
    from plantigrade.report.synthesis import SynthesisDrawing
    from plantigrade.synthesize.solution import Synthesis

UNITS = {
    "speed": "m/s", "step_length": "m", "cadence": "steps/min", "step_height": "m",
    "duration": "s", "chair_height": "m", "distance": "m", "height": "m", "depth": "m",
    "push": "s", "landing": "s",
}  # fmt: skip
"""Of parameters of tasks, by name."""
BEYOND, WIDE = 1.0, 0.6  # of ground that is drawn: past the outer footprints, to either side [m]
SAME = 1e-6  # times closer than this are one [s]
MULTIPLIERS = "multipliers "  # of what begins so in synthesis.npz, the name of the rows follows
MOT_RATE = 100.0  # frames a second of motion.mot [Hz]


def write(
    made: Synthesized,
    out: Path,
    *,
    title: str,
    command: Sequence[str],
    sources: Sequence[Path] = (),
    overwrite: bool = False,
) -> tuple[Path, dict[str, Any]]:
    """Write the run folder of a motion; return it and its metrics."""
    import mujoco

    from plantigrade import __version__
    from plantigrade.motion import Table
    from plantigrade.record.folder import source_files, write_run
    from plantigrade.report.synthesis import FILE

    human = made.human
    metrics = {
        "status": made.status,
        "version": __version__,
        "command": " ".join(command),
        "settings": made.settings.plain() | _ground_settings(made),
        "seed": made.settings.seed,
        "source_files": source_files(sources),
        **made.metrics,
        "warnings": made.notes,
        "title": title,
        "sentence": sentence(made),
    }
    record = replace(made.record, metrics=metrics)
    end = float(made.sampled.time[-1])
    time = np.linspace(0.0, end, int(np.ceil(end * MOT_RATE - 1e-9)) + 1)
    names, values = human.to_coordinates(made.synthesis.sample(time).qpos)
    drawn = drawing(made)
    xml = with_world(human.xml, made.synthesis.task.plan)
    model = mujoco.MjModel.from_xml_string(xml)
    files: dict[str, str | bytes] = dict(pages(model, record, drawn))
    files[FILE] = to_npz(made.synthesis, drawn)
    folder = write_run(
        out,
        model_xml=xml,
        record=record,
        metrics=metrics,
        coordinates=Table(names, time, values),
        files=files,
        overwrite=overwrite,
    )
    return folder, metrics


def with_world(xml: str, plan: "ContactPlan") -> str:
    """Return a model with seats, steps and slopes of a plan, to be seen: they touch nothing.

    The places of the body that rest on a seat become contact spheres like those of the feet, so
    that whoever checks the run finds them.

    Args:
        xml: MJCF of the person.
        plan: Says what rests where, and how the ground is.
    """
    from xml.etree import ElementTree

    from plantigrade.contact.ground import treads

    steps = treads(plan)
    if not plan.supports and not plan.slope and not len(steps.edges):
        return xml

    root = ElementTree.fromstring(xml)
    world = root.find("worldbody")
    assert world is not None
    nothing = {"contype": "0", "conaffinity": "0"}
    places: dict[float, list[tuple[float, float, float]]] = {}
    for site, support in {s.site.name: (s.site, s) for s in plan.supports}.values():
        places.setdefault(round(float(support.position[2]), 3), []).append(support.position)
        body = next(b for b in world.iter("body") if b.get("name") == site.body)
        shape = {"type": "sphere", "pos": _words(*site.position)}
        shape |= {"name": f"contact_{site.name}", "size": _words(site.radius)}
        ElementTree.SubElement(body, "geom", shape | nothing | {"group": "3", "mass": "0"})
    for k, (height, points) in enumerate(places.items(), 1):
        x, y = np.mean([p[:2] for p in points], axis=0)
        across = 0.12 + float(np.ptp([p[1] for p in points])) / 2
        colour = nothing | {"rgba": "0.65 0.55 0.45 1"}
        seat = {"name": f"seat_{k}", "type": "box", "pos": _words(x, y, height - 0.02)}
        post = {"name": f"post_{k}", "type": "cylinder", "pos": _words(x, y, (height - 0.04) / 2)}
        ElementTree.SubElement(world, "geom", seat | {"size": _words(0.18, across, 0.02)} | colour)
        size = _words(0.03, (height - 0.04) / 2)
        ElementTree.SubElement(world, "geom", post | {"size": size} | colour)
    x = np.array([s.footprint.position[0] for s in plan.stances])
    first, last = float(x.min()) - BEYOND, float(x.max()) + BEYOND
    ground = nothing | {"type": "box", "rgba": "0.80 0.80 0.77 1"}
    ends = zip([first, *steps.edges], [*steps.edges, last], steps.heights, strict=True)
    for k, (a, b, height) in enumerate(ends, 1):
        if height > 0.0:  # below the ground that is drawn nothing is seen
            place = {"pos": _words((a + b) / 2, 0.0, height / 2), "name": f"step_{k}"}
            place["size"] = _words((b - a) / 2, WIDE, height / 2)
            ElementTree.SubElement(world, "geom", ground | place)
    if plan.slope:
        pos = plan.to_world @ np.array([(first + last) / 2, 0.0, -0.01])
        place = {"pos": _words(*pos), "size": _words((last - first) / 2, WIDE, 0.01)}
        turn = _words(np.cos(plan.slope / 2), 0.0, -np.sin(plan.slope / 2), 0.0)
        ElementTree.SubElement(world, "geom", ground | place | {"quat": turn, "name": "slope"})
    return ElementTree.tostring(root, encoding="unicode")


def _words(*numbers: float) -> str:
    return " ".join(f"{float(x):.6g}" for x in numbers)


def _ground_settings(made: Synthesized) -> dict[str, Any]:
    """Return what anyone who checks the run must know of the ground."""
    return {"friction": float(under_test(made.synthesis, made.sampled).ground.friction)}


def pages(model, record: "Record", drawn: "SynthesisDrawing") -> dict[str, str]:
    """Return the report and the viewer of a motion from a task, by file name.

    Args:
        model: The body.
        record: The motion, with the run's metrics.
        drawn: What else the report draws.
    """
    from plantigrade.report.run_report import run_pages
    from plantigrade.report.synthesis import facts_of, first_sections, more_sections

    return run_pages(
        model,
        record,
        title=record.metrics["title"],
        sentence=record.metrics["sentence"],
        first=first_sections(drawn),
        extra=more_sections(model, record, drawn),
        facts=facts_of(record.metrics, drawn),
    )


def sentence(made: Synthesized) -> str:
    """Return what was done, in one sentence."""
    human, synthesis, m = made.human, made.synthesis, made.metrics
    told = ", ".join(w for k, v in made.settings.parameters.items() if (w := told_as(k, v)))
    what = f"{synthesis.task.name} ({told})" if told else synthesis.task.name
    what = f"{what[0].upper()}{what[1:]}, {m['duration_s']:.2f} s, of"
    verdict = "it passed the check" if made.status == "ok" else "it did not pass the check"
    solver = {"interior-point": "the banded interior point", "ipopt": "IPOPT"}[made.settings.solver]
    if made.settings.formulation == "paper":
        solver = "the paper's stages"
    source = "from a recording" if synthesis.task.name == "track" else "from the task alone"
    return (
        f"{what} a person of {human.height:.2f} m and {human.mass:.1f} kg "
        f"with {human.model.nv} degrees of freedom and {human.feet} feet, "
        f"made {source} by {solver} in {synthesis.seconds:.1f} s "
        f"({synthesis.iterations} iterations, {m['nodes']} nodes); {verdict} in "
        f"{len(made.check.time)} frames."
    )


def told_as(name: str, value: Any) -> str:
    """Return a parameter of a task in words.

    Example:
        >>> told_as("step_length", 0.6), told_as("turn", np.pi / 2), told_as("periodic", True)
        ('step length 0.6 m', 'turn 90°', 'periodic')
    """
    words = name.replace("_", " ")
    if value is None or value is False:
        return ""
    if value is True:
        return words
    if isinstance(value, int | float):
        if name in ("turn", "slope"):
            return f"{words} {np.rad2deg(value):.4g}°"
        unit = UNITS.get(name, "")
        return f"{words} {value:g}{' ' if unit else ''}{unit}"
    return f"{words} {value}"


def drawing(made: Synthesized) -> "SynthesisDrawing":
    """Return what the report draws of a motion from a task."""
    from plantigrade.analyze.findings import QUANTITY
    from plantigrade.report.synthesis import SynthesisDrawing

    synthesis, check, s = made.synthesis, made.check, made.sampled
    sites = synthesis.body.sites
    bad = {f.quantity for f in check.findings}
    measures = list(check.measures.values())
    history = [(k, it) for k, stage in enumerate(synthesis.stages) for it in stage.history]
    return SynthesisDrawing(
        task=synthesis.task.name,
        stage_names=tuple(x.name for x in synthesis.stages),
        stage_solvers=tuple(x.solver for x in synthesis.stages),
        stage_status=tuple(x.status for x in synthesis.stages),
        stage_nodes=np.array([x.nodes for x in synthesis.stages]),
        stage_seconds=np.array([x.seconds for x in synthesis.stages], float),
        history=np.array(
            [(k, i.number, i.objective, i.violation, i.optimality, i.seconds) for k, i in history],
            float,
        ).reshape(-1, 6),
        history_worst=tuple(i.worst for _, i in history),
        check_quantity=tuple(m.quantity for m in measures),
        check_value=np.array([m.value for m in measures], float),
        check_limit=np.array([m.limit for m in measures], float),
        check_time=np.array([m.time for m in measures], float),
        check_where=tuple(m.name for m in measures),
        check_side=tuple(m.side for m in measures),
        check_unit=tuple(QUANTITY[m.quantity].unit for m in measures),
        check_bad=np.array([m.quantity in bad for m in measures], bool),
        findings=tuple(f.sentence() for f in check.findings),
        broken=tuple(b.sentence() for b in made.broken),
        time=s.time,
        standing=s.standing,
        point=check.contact_point,
        force=s.force,
        site_names=tuple(x.name for x in sites),
        site_sides=tuple(x.side for x in sites),
        site_segments=tuple(x.body for x in sites),
        pressure=check.centre_of_pressure,
        com=check.com,
        weight=synthesis.body.weight,
        nodes=synthesis.nodes,
    )


def to_npz(synthesis: "Synthesis", drawn: "SynthesisDrawing | None" = None) -> bytes:
    """Return ``synthesis.npz``: coefficients, forces, nodes, multipliers, and what is drawn."""
    p = synthesis.problem
    kept: dict[str, Any] = {
        "c": synthesis.c,
        "u": synthesis.u,
        "nodes": synthesis.nodes,
        "coordinates": np.array(p.names),
        "unknowns": np.array(p.u_names),
        "status": np.array(synthesis.status),
        "success": np.array(synthesis.success),
    }
    if synthesis.multipliers is not None:
        for name, values in synthesis.multipliers.rows.items():
            kept[f"{MULTIPLIERS}{name}"] = values
    stream = io.BytesIO()
    np.savez_compressed(stream, **kept, **(drawn.arrays() if drawn is not None else {}))
    return stream.getvalue()


def read_synthesis(folder: Path) -> "Synthesis":
    """Return the motion of a run folder, ready to start another one from.

    Person and task are made anew from the run's settings, coefficients and forces are read.

    Raises:
        FileError: If the folder is no run of ``plantigrade synthesize``, or was made by a version
            whose problem is another.
    """
    from plantigrade.record.folder import METRICS
    from plantigrade.report.synthesis import FILE
    from plantigrade.synthesize.solution import Synthesis
    from plantigrade.synthesize.solvers.interior_point import Multipliers
    from plantigrade.synthesize.tasks.registry import body_for

    folder = Path(folder).expanduser()
    remedy = "name a folder that plantigrade synthesize wrote"
    for name in (FILE, METRICS):
        if not (folder / name).is_file():
            raise FileError(
                folder, f"is no run of plantigrade synthesize: no {name}", remedy=remedy
            )
    try:
        metrics = json.loads((folder / METRICS).read_text("utf-8"))
        settings = settings_from(metrics["settings"])
        with np.load(folder / FILE, allow_pickle=False) as held:
            kept = {k: held[k] for k in held.files if not k.startswith("drawn_")}
        c, u, nodes = kept["c"], kept["u"], kept["nodes"]
        status, success = str(kept["status"]), bool(kept["success"])
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise FileError(
            folder / FILE, f"holds no motion to start from ({error})", remedy=remedy
        ) from error
    if settings.formulation == "paper":
        raise FileError(folder, "is a motion of the paper, no start for others", remedy=remedy)
    human = settings.human()
    task = task_of(human, settings)
    body = body_for(human, task.plan)
    switches = task.plan.switches
    same = len(nodes) > 1 and abs(nodes[-1] - task.plan.duration) < SAME
    if same and np.abs(switches[:, None] - nodes).min(axis=1).max() < SAME:
        problem = task.problem(body, nodes)
        n_c, n_u = (problem.basis.n_coefficients, len(problem.nodes))
        same = c.shape == (n_c, len(problem.names)) and u.shape == (n_u, problem.n_unknowns)
    else:
        same, problem = False, None
    if not same or problem is None:
        raise FileError(
            folder / FILE,
            "was made for another problem than its settings describe here (another version)",
            remedy="make the run anew",
        )
    pushing = {k.removeprefix(MULTIPLIERS): v for k, v in kept.items() if k.startswith(MULTIPLIERS)}
    multipliers = Multipliers(pushing) if pushing else None
    return Synthesis(body, task, problem, c, u, status, success, (), multipliers)


def settings_from(kept: Mapping[str, Any]) -> SynthesizeSettings:
    """Return the settings that ``metrics.json`` holds."""
    names = {f.name for f in fields(SynthesizeSettings)}
    given = {k: v for k, v in kept.items() if k in names}
    if given.get("warm") is not None:
        given["warm"] = Path(given["warm"])
    return SynthesizeSettings(**given)
