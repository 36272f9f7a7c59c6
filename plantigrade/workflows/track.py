"""Track a recording with a dynamically consistent motion.

Ground reactions are estimated from the motion; the tracked motion starts from them and keeps near
them as closely as their error bands allow. Measured ones are withheld; at most the body mass is
taken from the plates (see :mod:`plantigrade.analyze.trial`).
"""

import time as clock
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.estimated_forces import estimate_signals, on_box
from plantigrade.analyze.gait_forces import ForceComparison, compare_forces, measured_signals
from plantigrade.analyze.norms_of_runs import norm_files
from plantigrade.analyze.overlap import Overlap, overlap_along
from plantigrade.analyze.recorded_walk import RecordedWalk
from plantigrade.analyze.reproduction import Comparison, compare
from plantigrade.analyze.reproduction_status import limit_of, limits_exceeded
from plantigrade.analyze.tolerances import Tolerances
from plantigrade.analyze.trial import Trial, analyse
from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.contact.ground import LEVEL_GROUND
from plantigrade.contact.site import ContactSite
from plantigrade.dynamics.ball_joints import BallJoint
from plantigrade.dynamics.ground_forces import GroundForces, estimate_forces
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.dynamics.loading import MIN_BOX_REST
from plantigrade.errors import ParameterError, ReproduceError
from plantigrade.kinematics.shoulders import arms_of, counted_on
from plantigrade.models import Human
from plantigrade.motion import Motion, Recording
from plantigrade.motion.event_timing import is_running
from plantigrade.motion.filters import resample, runs
from plantigrade.options import as_path
from plantigrade.ordered_tasks.phases import walking_events
from plantigrade.record import Record, Run
from plantigrade.spatial.conventions import within_half_turn
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.solution import Solution
from plantigrade.trajopt.solve import Progress, synthesize
from plantigrade.trajopt.tasks.tracking import grounded
from plantigrade.trajopt.tasks.tracking import track as track_task
from plantigrade.workflows.fit import fit_trial, norm_signals
from plantigrade.workflows.settings import TrackSettings
from plantigrade.workflows.steps import Step, silent
from plantigrade.workflows.synthesize import Origin, checked, solver_figures

MAX_ERRORS = {"rmse_max_deg": 6.0, "rom_error_max_deg": 10.0}
"""Largest error of any rotation of hips, knees and ankles against the recorded one: root mean
square, and range of motion. Beyond them the motion is not the recorded one, however well forces
explain it. They are at least twice the goals of ankles in the experiment synthesis-tracking."""
EXCLUDED_JOINT = "subtalar"
"""Joint without a limit: the sole of a planned stance is flat, whereas a recorded foot rolls over
its edge."""
COMPARED_PREFIXES = ("hip_", "knee_", "ankle_", "subtalar_", "rom_", "rmse_", "foot_flat")
"""Beginnings of the names of figures that are compared with the recording."""

MAX_NAMED_OVERLAPS = 3  # pairs of body parts in each other that a warning names
MAX_PELVIS_DISTANCE = 0.05
"""Distance of the pelvis from the recorded one at which a warning tells it [m]: three times the RMS
of tracked runs, and as much as a centre of mass goes up and down in walking."""
EVENT_MARGIN = 0.1  # tracked before the first and after the last gait event [s]
UNTRACKED_EDGE = 0.05  # [s] of a recording: filters know too little there


@dataclass(frozen=True, eq=False)
class Tracked:
    """A tracked recording."""

    walk: RecordedWalk  #: The recorded motion, as fitted
    human: Human  #: The person, on the soles the recorded feet stand on
    motion: Motion  #: The recorded motion over level ground, lifted onto its soles
    lift: float  #: How far it was lifted [m]
    estimate: GroundForces  #: Ground reactions estimated from it, on its frames
    solution: Solution  #: The physical motion
    begin: float  #: Time zero of the solution, on the clock of the recording [s]
    start: float  #: Start of the comparison, after the lead-in [s]
    stop: float  #: End of the comparison [s]
    seconds: float  #: Computing time without the fit [s]

    @cached_property
    def _solved(self) -> Record:
        return self.solution.record()

    def record(self) -> Record:
        """Return the whole motion, on its own clock, with the recorded one."""
        record, signals = self._solved, {}
        if self.walk.measured is not None:
            signals = measured_signals(self._on_the_recordings_clock(record), self.walk.measured)
        return replace(
            record,
            signals={**record.signals, **signals},
            references={"recorded": _later(self.motion, -self.begin)},
            clock=self.begin,
            notes=(*self.walk.notes, *record.notes, *self._overlap_notes, *self._place_notes),
        )

    @cached_property
    def _overlaps(self) -> tuple[Overlap, Overlap, Float[Array, " n"]]:
        """Depths of limbs in each other, recorded and ours, and when."""
        time = self.motion.time
        during = (time >= self.begin) & (time <= self.begin + self.solution.task.plan.duration)
        recorded = self.motion.frames(during)
        ours = self._solved.motion
        nearest = np.abs(ours.time[None] - (recorded.time - self.begin)[:, None]).argmin(axis=1)
        one, two = (overlap_along(self.human, q) for q in (recorded.qpos, ours.qpos[nearest]))
        return one, two, recorded.time

    @property
    def _overlap_notes(self) -> tuple[str, ...]:
        """A warning of limbs in each other, beside how deep the recorded ones are."""
        recorded, ours, time = self._overlaps
        deepest = 1000.0 * ours.depth.max(axis=0)
        own = np.maximum(1000.0 * recorded.depth.max(axis=0), 0.0)
        allowed = Tolerances().overlap
        words = [
            f"{ours.names[k].replace('_', ' ')} by {deepest[k]:.0f} mm at "
            f"{time[ours.depth[:, k].argmax()]:.2f} s (recorded: {own[k]:.0f} mm)"
            for k in np.argsort(-deepest)[:MAX_NAMED_OVERLAPS]
            if deepest[k] > allowed
        ]
        return (f"parts of the body are in each other: {', '.join(words)}.",) if words else ()

    @property
    def _place_notes(self) -> tuple[str, ...]:
        """A warning of a pelvis far from the recorded one, as in a fall that is not followed."""
        ours = self.compared().motion
        recorded = resample(self.motion.time, self.motion.qpos[:, :3], ours.time)
        away = np.linalg.norm(ours.qpos[:, :3] - recorded, axis=1)
        far = int(away.argmax())
        if away[far] <= MAX_PELVIS_DISTANCE:
            return ()
        return (
            f"the pelvis is {1000 * away[far]:.0f} mm from the recorded one at "
            f"{ours.time[far]:.2f} s: joint angles alone decide whether the run is ok.",
        )

    def compared(self) -> Record:
        """Return the motion without lead-in and lead-out, on the clock of the recording."""
        record = self._on_the_recordings_clock(self._solved)
        time = record.motion.time
        keep = (time >= self.start - 1e-9) & (time <= self.stop + 1e-9)
        names = ("qfrc_actuator", "contact_force", "contact_point", "contact_planned")
        arrays = {name: getattr(record, name)[keep] for name in names}
        return replace(record, motion=record.motion.frames(keep), **arrays)

    def moved(self) -> tuple[float, float]:
        """Return the RMS distance from the recorded motion: of angles [rad], of the pelvis [m].

        That of a shoulder is the rotation between both upper arms.
        """
        human, ours = self.human, self.compared().motion
        recorded = human.to_coordinates(self.motion.qpos)[1]
        recorded[:, :3] = np.unwrap(recorded[:, :3], axis=0)
        recorded = resample(self.motion.time, recorded, ours.time)
        found = human.to_coordinates(ours.qpos)[1]
        apart = found - recorded
        apart[:, :3] = within_half_turn(apart[:, :3])
        for side, hinges in zip(SIDES, arms_of(human), strict=False):
            k = 6 + np.array(hinges)
            apart[:, k] = BallJoint(side, hinges).between(recorded[:, k], found[:, k])
        angles = np.delete(apart, [3, 4, 5], axis=1)
        return root_mean_square(angles), root_mean_square(apart[:, 3:6])

    @cached_property
    def with_recording(self) -> Record:
        """The motion without lead-in and lead-out, with the recorded one as a reference."""
        found = self.compared()
        motion = replace(found.motion, events=self.motion.events)
        return replace(found, motion=motion, references={"recorded": self.motion})

    @cached_property
    def against_recording(self) -> Comparison:
        """Joint angles of the legs and feet and the recorded ones, over the strides."""
        return compare(self.with_recording)

    @cached_property
    def assessed(self) -> Comparison:
        """The same without the excluded joint."""
        held = self.against_recording
        rom, rmse = (
            {name: x for name, x in of.items() if not name.startswith(EXCLUDED_JOINT)}
            for of in (held.rom, held.rmse)
        )
        return replace(held, rom=rom, rmse=rmse)

    @property
    def violations(self) -> str:
        """Joint angles too far from the recorded ones, where and when; empty where none is."""
        if not self.assessed.metrics().keys() >= MAX_ERRORS.keys():
            return f"no joint angle can be compared from {self.start:.2f} to {self.stop:.2f} s"
        return limits_exceeded(self.with_recording, self.assessed, MAX_ERRORS)

    def against_plates(self) -> ForceComparison:
        """Compare the forces with the measured ones.

        Raises:
            ReproduceError: If the recording has no force plates.
        """
        return compare_forces(self.compared(), self._measured, ground=self.walk.ground)

    def estimate_against_plates(self) -> ForceComparison:
        """Compare the estimated forces with the measured ones, over the same frames.

        The joint moments for comparison are those of the recorded motion.

        Raises:
            ReproduceError: If the recording has no force plates.
        """
        motion, found = self.motion, self.estimate
        assert motion.qacc is not None
        moved = (self.human, motion.qpos, motion.qvel, motion.qacc)
        moments = inverse_dynamics(*moved, found.forces)
        keep = (motion.time >= self.start - 1e-9) & (motion.time <= self.stop + 1e-9)
        sites = tuple(
            ContactSite(body=f"foot_{side}", name=f"foot_{side}", side=side, measured=True)
            for side in SIDES
        )
        record = Record(
            self.human,
            motion.frames(keep),
            qfrc_actuator=moments.tau[keep],
            sites=sites,
            contact_force=found.forces.force[keep],
            contact_point=found.forces.point[keep],
            contact_torque=found.forces.torque[keep],
            signals={name: x[keep] for name, x in estimate_signals(found).items()},
        )
        return compare_forces(record, self._measured, ground=self.walk.ground)

    @property
    def _measured(self) -> Record:
        if self.walk.measured is None:
            raise ReproduceError(f"{self.walk.name} has no force plates")
        return self.walk.measured

    def figures(self) -> dict[str, Any]:
        """Return how far the motion is from the recorded one, and the forces from measured ones."""
        angle, place = self.moved()
        found: dict[str, Any] = {
            "tracked_start_s": self.start,
            "tracked_stop_s": self.stop,
            "tracking_angle_rms_deg": float(np.rad2deg(angle)),
            "tracking_pelvis_rms_mm": 1000.0 * place,
            "lift_mm": 1000.0 * self.lift,
        }
        recorded, ours, _ = self._overlaps
        for name, of in (("overlap", ours), ("recorded_overlap", recorded)):
            found[f"{name}_mm"] = max(1000.0 * float(of.depth.max()), 0.0)
        angles = self.against_recording.metrics() | self.assessed.metrics()
        found |= {name: x for name, x in angles.items() if name.startswith(COMPARED_PREFIXES)}
        found |= {limit_of(name): limit for name, limit in MAX_ERRORS.items()}
        if self.walk.measured is not None:
            found |= self.against_plates().metrics()
            compared = self.estimate_against_plates().metrics()
            found |= {f"estimated_{name}": x for name, x in compared.items() if name in found}
        return found

    def _on_the_recordings_clock(self, record: Record) -> Record:
        return replace(record, motion=_later(record.motion, self.begin), conditions=())


def _off_boxes(human: Human, motion: Motion, estimate: GroundForces) -> tuple[float, float]:
    """Return the longest time without load on a box, whose height a plan does not have [s]."""
    time, (high, _) = motion.time, on_box(human, estimate, LEVEL_GROUND)
    if high.any(axis=1).sum() * np.median(np.diff(time)) < MIN_BOX_REST:
        return float(time[0]), float(time[-1])
    load, places = estimate.forces.force[..., 2], estimate.forces.point[..., 2]
    free = ~((load > 0.0) & (places >= places[high].min())).any(axis=1)
    longest = max(runs(np.asarray(free)), key=lambda run: run.stop - run.start)
    start, stop = longest.start, longest.stop - 1  # filters smear what a box carries
    return (
        float(time[start] + (UNTRACKED_EDGE if start > 0 else 0.0)),
        float(time[stop] - (UNTRACKED_EDGE if stop < len(time) - 1 else 0.0)),
    )


def _later(motion: Motion, seconds: float) -> Motion:
    """Return a motion, its events too, later by some seconds."""
    events = tuple(replace(e, time=e.time + seconds) for e in motion.events)
    return replace(motion, time=motion.time + seconds, events=events)


def track(
    path: str | Path,
    settings: TrackSettings | None = None,
    *,
    progress: Progress | None = None,
    step: Step = silent,
    origin: Origin | None = None,
) -> Run:
    """Fit a recording, track it with ground reactions, and check the result.

    Args:
        path: The recording: markers, a skeleton's motion, or joint coordinates.
        settings: What decides the result.
        progress: Called with every iteration; returning True stops with the best so far.
        step: Shows progress of the fit.
        origin: For the provenance.

    Raises:
        FileError: If the file cannot be read.
        FitError: If it cannot be fitted.
        ReproduceError: If it is not on level ground.
        ParameterError: If nothing is recorded, or no foot is on the ground, between start and stop.
    """
    settings, path = settings or TrackSettings(), as_path(path, "a recording")
    origin = origin or Origin(name=f"synthesize-track-{path.stem}")
    recording, trial = fit_trial(path, settings, step, boxes=False)
    tracked = track_trial(trial, settings, progress=progress)
    return run_of(recording, tracked, settings, origin)


def run_of(recording: Recording, tracked: Tracked, settings: TrackSettings, origin: Origin) -> Run:
    """Return the run of a tracked recording; its provenance names all files that were read.

    It is ok where the checker finds nothing and hips, knees and ankles are within
    :data:`MAX_ERRORS` of the recorded ones.
    """
    solution, name = tracked.solution, recording.source.name
    made = "as near to the recording as the laws of physics allow"
    record = tracked.record()
    run = checked(
        replace(record, signals={**record.signals, **norm_signals(settings)}),
        f"track ({name})",
        made,
        {"task": "track", "file": name, **settings.plain()},
        replace(
            origin, files=(recording.source, *recording.companions, *norm_files(settings.norms))
        ),
        {**solver_figures(solution), **tracked.figures()},
        solution.violations,
        kind="track",
        seconds={"solve": solution.seconds, "prepare": tracked.seconds - solution.seconds},
    )
    if not tracked.violations:
        return run
    far = f"far from the recording: {tracked.violations}"
    return replace(run, status=far if run.ok else f"{run.status}; {far}")


def track_trial(
    trial: Trial,
    settings: TrackSettings | None = None,
    *,
    progress: Progress | None = None,
) -> Tracked:
    """Track a fitted recording with ground reactions; see :func:`track`."""
    settings, began = settings or TrackSettings(), clock.perf_counter()
    if trial.withheld is None and trial.forces is not None:
        trial = analyse(
            trial.fit, cutoff=trial.cutoff, mass=trial.fit.human.mass, without_plates=True
        )
    walk = RecordedWalk.of(trial)
    walk.refuse_uneven()
    human, motion, lift = grounded(walk.human, counted_on(walk.human, walk.over_ground()))
    walked = motion.events if is_running(motion.events) else walking_events(motion.events)
    estimate = estimate_forces(human, motion)
    first, last = _off_boxes(human, motion, estimate)
    start, stop = (walked[0].time, walked[-1].time) if len(walked) > 2 else (first, last)
    start = max(start, first) if settings.start is None else settings.start
    stop = min(stop, last) if settings.stop is None else settings.stop
    if start >= motion.time[-1] or stop <= motion.time[0]:
        raise ParameterError(
            f"nothing is recorded from {start:g} to {stop:g} s: the recording lasts from "
            f"{motion.time[0]:g} to {motion.time[-1]:g} s"
        )
    begin = max(start - EVENT_MARGIN, min(first + UNTRACKED_EDGE, start))
    end = min(stop + EVENT_MARGIN, max(last - UNTRACKED_EDGE, stop))
    task = track_task(human, motion, forces=estimate, start=begin, stop=end)
    body = ContactBody.for_plan(human, task.plan)
    solution = synthesize(body, task, progress=progress, refinements=settings.refinements)
    seconds = clock.perf_counter() - began
    stop = min(stop, begin + task.plan.duration)
    return Tracked(walk, human, motion, lift, estimate, solution, begin, start, stop, seconds)
