"""Every signal of a Record: name, unit, shape, meaning, and the section of a report that draws it.

``docs/signals.md`` is this table. Axes are named: ``frames`` are those of the motion, ``nv`` its
generalised forces, ``hinges`` its hinges, ``markers`` its recorded markers; other axes of one name
are equally long within a family, which is what stands before the first dot. ``*`` stands for any
word. Names of the families ``controller``, ``live`` and ``user`` are free.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from plantigrade.errors import ParameterError, known_names

Kind = Literal["number", "word", "flag"]


@dataclass(frozen=True)
class Signal:
    """A signal that the package knows, or a family of them."""

    name: str  #: Its name; ``*`` at the end stands for any word
    kind: Kind  #: What it holds
    shape: str  #: Names or lengths of its axes, with spaces; ``...`` for any shape
    unit: str  #: SI unit, ``°`` or ``%``; empty for words, flags and pure numbers
    meaning: str  #: What it is
    section: str = ""  #: Title of the section of the report that draws it, ``viewer``, or empty

    @property
    def axes(self) -> tuple[str | int, ...]:
        """Names or lengths of its axes."""
        return tuple(int(axis) if axis.isdigit() else axis for axis in self.shape.split())

    @property
    def has_any_shape(self) -> bool:
        """Whether nothing is asked of its kind and shape."""
        return self.shape == "..."


CONTROLLER, LIVE, USER = "controller.", "live.", "user."
"""Beginnings of free names: what a controller, a live session or a user stores."""

# Title of a section → (name, kind, shape, unit, meaning) of the signals that it draws first.
_TABLE: dict[str, tuple[tuple[str, Kind, str, str, str], ...]] = {
    "Check": (
        ("check.quantity", "word", "measures", "", "what was checked"),
        ("check.value", "number", "measures", "check.unit", "worst value"),
        ("check.limit", "number", "measures", "check.unit", "limit of that value"),
        ("check.time", "number", "measures", "s", "time of the worst value"),
        ("check.where", "word", "measures", "", "joint, contact site or condition"),
        ("check.side", "word", "measures", "", "side of the body: `r`, `l` or empty"),
        ("check.unit", "word", "measures", "", "unit of value and limit"),
        ("check.bad", "number", "measures", "", "1 if the value is beyond its limit"),
    ),
    "Findings of the check": (
        ("check.findings", "word", "findings", "", "findings in sentences, the worst first"),
    ),
    "Constraints the solver did not satisfy": (
        ("solver.broken", "word", "constraints", "", "violated constraints in sentences"),
    ),
    "Convergence": (
        ("solver.stage_names", "word", "stages", "", "stages of the solution"),
        ("solver.stage_solvers", "word", "stages", "", "solver of each stage"),
        ("solver.stage_status", "word", "stages", "", "how each stage ended"),
        ("solver.stage_nodes", "number", "stages", "", "number of nodes of each stage"),
        (
            *("solver.history", "number", "iterations 5", "1"),
            "stage, iteration, objective, violation and optimality of each iteration",
        ),
        ("solver.history_worst", "word", "iterations", "", "most violated constraint"),
    ),
    "Tasks and when they are active": (
        ("tasks.names", "word", "tasks", "", "ordered tasks"),
        ("tasks.level", "number", "tasks", "", "level of priority of each task"),
        ("tasks.meanings", "word", "tasks", "", "what each task does"),
        ("tasks.active", "number", "frames tasks", "", "1 while a task is active"),
        ("phase.span", "number", "phases 2", "s", "start and end of each phase of the gait"),
        ("phase.kind", "word", "phases", "", "`single` or `double` support"),
        ("phase.swing", "word", "phases", "", "side of the swing foot"),
        ("posture.end", "number", "postures", "s", "times at which a posture is to be reached"),
        ("contact.span", "number", "contacts 2", "s", "start and end of each contact"),
        ("contact.place", "word", "contacts", "", "part of the foot in contact: `heel_r`, …"),
    ),
    "Device": (
        (
            *("device.torque", "number", "frames nv", "N m"),
            "torque that a device adds, a part of the joint torque",
        ),
        (
            *("device.without", "number", "frames nv", "N m"),
            "joint torque of the same task without the device",
        ),
    ),
    "Residual of each level": (
        (
            *("tasks.residual", "number", "frames tasks", "m/s², rad/s²"),
            "norm of desired minus achieved acceleration of each task",
        ),
    ),
    "Joint angles over the gait cycle": (
        ("norms.people", "word", "1", "", "population of the user's own norms"),
        ("norms.names", "word", "curves", "", "coordinates of the norms"),
        ("norms.mean", "number", "curves percent", "°", "mean over the gait cycle"),
        ("norms.sd", "number", "curves percent", "°", "standard deviation between people"),
    ),
    "Foot segments": (
        ("foot.names", "word", "angles", "", "angles between segments of the foot"),
        ("foot.percent", "number", "percent", "%", "percents of the gait cycle"),
        ("foot.*", "number", "* percent", "°", "one such angle, a row for each cycle"),
    ),
    "Marker errors": (
        (
            *("markers.residual", "number", "frames markers", "m"),
            "distance of each recorded marker from the fitted one, before the motion is filtered",
        ),
    ),
    "Estimated ground reactions": (
        (
            *("forces.measured", "flag", "frames 2", ""),
            "whether the force on the right and left foot was measured",
        ),
        (
            *("forces.band", "number", "frames 2 3", "N"),
            "half-width of the 90 % band of the force on each foot",
        ),
        ("measured.force", "number", "frames 2 3", "N", "measured force on each foot"),
    ),
    "Estimated joint moments": (
        ("forces.moment_band", "number", "frames nv", "N m", "half-width of the 90 % band"),
        ("measured.moment", "number", "frames moments", "N m/kg", "moments of measured forces"),
        ("measured.moment_names", "word", "moments", "", "coordinates of these moments"),
    ),
    "Activation of the joints": (
        ("vault.joints", "word", "joints", "", "joints of the gymnast"),
        (
            *("vault.activation", "number", "frames joints", "1"),
            "activation, from −1 (full strength in flexion) to 1 (in extension)",
        ),
    ),
    "Sensitivity to the approach": (
        ("vault.changed", "word", "changes", "", "what of the approach was changed"),
        (
            *("vault.change", "number", "changes 3", "1, m/s, m/s"),
            "relative change; upward velocity at take-off with the same and with new activations",
        ),
    ),
    "viewer": (
        ("assumed.joints", "word", "joints", "", "coordinates that the recording does not show"),
        (
            *("ground.place", "number", "frames 4", "m, m, rad, rad"),
            "shift of the ground forward and left, tilt up in front and up on the left",
        ),
        ("things.name", "word", "things", "", "objects in the world"),
        ("things.kind", "word", "things", "", "shape of each object"),
        ("things.size", "number", "things 3", "m", "half sizes of each object"),
        (
            *("things.place", "number", "frames things 7", "m, 1"),
            "centre and rotation (w, x, y, z) of each object; NaN while it is absent",
        ),
    ),
    "": (
        (
            *("forces.point_band", "number", "frames 2 2", "m"),
            "half-width of the 90 % band of the centre of pressure",
        ),
        (
            *("forces.torque_band", "number", "frames 2", "N m"),
            "half-width of the 90 % band of the free moment",
        ),
        ("estimated.force", "number", "frames 2 3", "N", "estimated force, which was tracked"),
        ("exact", "number", "frames", "", "1 where no inequality limited the tasks"),
        ("stopped", "word", "", "", "why a motion from tasks ended early; empty if it did not"),
        ("world.motor", "number", "frames hinges", "N m", "torques of the motors alone"),
        ("world.push", "number", "frames 3", "N", "sum of the forces that push the body"),
        ("barrier.clearance", "number", "frames", "m", "distance of the body from the barrier"),
        ("spline.basis", "word", "", "", "kind of spline of a synthesised motion"),
        ("spline.status", "word", "", "", "how the solver ended"),
        ("spline.nodes", "number", "nodes", "s", "times of the nodes"),
        ("spline.switches", "number", "switches", "s", "times at which contacts change"),
        ("spline.coordinates", "word", "coordinates", "", "coordinates of the spline"),
        ("spline.unknowns", "word", "unknowns", "", "unknown forces at the nodes"),
        ("spline.coefficients", "number", "coefficients coordinates", "m, rad", "coefficients"),
        ("spline.forces", "number", "intervals unknowns", "N", "their values"),
        ("spline.period", "number", "2", "1, m", "1 if steps are mirrored; advance of a period"),
        ("spline.aside", "number", "1", "m", "way of a period along y, where it leads to the side"),
        (
            *("spline.multipliers.*", "number", "3 * *", ""),
            "multipliers of a family of constraints, of its lower and upper limits",
        ),
        ("controller.tracking_error", "number", "...", "rad", "RMS error of the joint angles"),
        ("controller.posture_error", "number", "...", "rad", "norm of the joint angle errors"),
        ("controller.com_error", "number", "...", "m", "distance of the centre of mass"),
        ("controller.phase", "number", "...", "s", "time within the reference motion"),
        ("controller.phase_rate", "number", "...", "1", "rate of that time"),
        ("controller.off_path", "number", "...", "m", "offset of the centre of mass"),
        ("controller.capture_error", "number", "...", "m", "capture error of the footstep"),
        ("controller.landing", "number", "...", "m", "planned footstep, world axes"),
        ("controller.landing_time", "number", "...", "s", "time to the planned touchdown"),
        ("controller.contacts", "number", "...", "", "number of contact spheres in use"),
        ("controller.limited", "number", "...", "", "1 where strength limits a torque"),
        ("controller.solved", "number", "...", "", "1 where the program was solved"),
        ("controller.steps", "number", "...", "", "number of recovery steps begun"),
        ("controller.opposing", "number", "...", "N", "force of the feet against each other"),
        (
            *("controller.support_residual", "number", "...", "m/s², rad/s²"),
            "norm of the missing acceleration of the supporting segments",
        ),
        (
            *("controller.joints_beyond_strength", "number", "...", ""),
            "number of joints whose torque is beyond their strength",
        ),
        ("controller.foot_stiffness", "number", "...", "N m/rad", "joint stiffness of a policy"),
        ("controller.*", "number", "...", "", "what else a controller returns"),
        ("live.*", "number", "...", "", "a value that was set in the live viewer"),
        ("user.*", "number", "...", "", "anything of your own"),
    ),
}

SIGNALS: Mapping[str, Signal] = {
    row[0]: Signal(*row, section) for section, rows in _TABLE.items() for row in rows
}
"""Every signal by name, and families by ``NAME.*``."""
_FAMILIES = {name[:-1]: signal for name, signal in SIGNALS.items() if name.endswith("*")}


def signal_of(name: str) -> Signal:
    """Return the signal of a name, or the family that it belongs to.

    Example:
        >>> signal_of("controller.com_error").unit
        'm'
    """
    found = SIGNALS.get(name)
    if found is not None:
        return found
    for beginning, family in _FAMILIES.items():
        if name.startswith(beginning) and name != beginning:
            return family
    raise ParameterError(
        f"no signal is called {name!r}; {known_names(name, list(SIGNALS))}. Names of your own "
        f"begin with {USER!r}, those of a controller with {CONTROLLER!r}"
    )
