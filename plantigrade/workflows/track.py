"""A recording repaired: fitted, then moved by forces of the ground along what was recorded.

Measured forces of the ground are withheld: of the plates, at most the body mass is known, where no
file tells it (see :mod:`plantigrade.analyze.trial`).
"""

import time as clock
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ReproduceError
from plantigrade.workflows.fit import FitSettings
from plantigrade.workflows.synthesize import Progress, Synthesized, SynthesizeSettings, judged

if TYPE_CHECKING:
    from plantigrade.analyze.gait_forces import ForceComparison
    from plantigrade.analyze.trial import Trial
    from plantigrade.models import Human
    from plantigrade.motion import Motion
    from plantigrade.synthesize.tasks.tracking import Tracking

MARGIN = 0.1  # tracked before the first and after the last gait event [s]
EDGE = 0.05  # of a recording, not tracked for its own sake: filters know too little there [s]


@dataclass(frozen=True)
class TrackSettings:
    """Everything that decides the result.

    Attributes:
        fit: How the recording is fitted.
        start: From when [s]; the first gait event if absent, or the first frame where nobody walks.
        stop: To when [s]; the last gait event or frame if absent.
        tracking: Weights; the default ones if absent.
        refinements: How often nodes are added where the motion asks for what no contact can give.
    """

    fit: FitSettings = field(default_factory=FitSettings)
    start: float | None = None
    stop: float | None = None
    tracking: "Tracking | None" = None
    refinements: int = 3


@dataclass(frozen=True, eq=False)
class Tracked:
    """A recorded motion on forces of the ground.

    Attributes:
        trial: The fitted recording.
        human: The person, on the soles the recorded feet stand on.
        motion: The recorded motion, smoothed, over level ground that rests, lifted.
        lift: How far it was lifted onto its soles [m].
        made: The motion that forces explain, and what the checker says of it.
        begin: Time zero of the motion, on the clock of the recording [s].
        start: From when it is compared: without what flows in [s].
        stop: To when [s].
        seconds: How long it took, without the fit [s].
    """

    trial: "Trial"
    human: "Human"
    motion: "Motion"
    lift: float
    made: Synthesized
    begin: float
    start: float
    stop: float
    seconds: float

    @cached_property
    def forced(self) -> "TrackedForces":
        """The motion with its forces, on the clock of the recording, without what flows in."""
        made = self.made
        time = made.sampled.time + self.begin
        keep = (time >= self.start - 1e-9) & (time <= self.stop + 1e-9)
        return TrackedForces(
            time[keep],
            made.sampled.qpos[keep],
            made.sampled.qvel[keep],
            made.check.tau[keep],
            made.sampled.force[keep],
            made.check.contact_point[keep],
            tuple(s.side for s in made.synthesis.body.sites),
        )

    def moved(self) -> tuple[float, float]:
        """Return how far the motion is from the recorded one: joints and pelvis [rad], pelvis [m].

        Both are root mean squares over time and coordinates.
        """
        from plantigrade.motion.filters import resample

        recorded = self.human.to_coordinates(self.motion.qpos)[1]
        recorded[:, :3] = np.unwrap(recorded[:, :3], axis=0)
        ours = self.human.to_coordinates(self.forced.qpos)[1]
        apart = ours - resample(self.motion.time, recorded, self.forced.time)
        apart[:, :3] = (apart[:, :3] + np.pi) % (2 * np.pi) - np.pi
        angles = np.delete(apart, [3, 4, 5], axis=1)
        return float(np.sqrt((angles**2).mean())), float(np.sqrt((apart[:, 3:6] ** 2).mean()))

    def against_plates(self) -> "ForceComparison":
        """Hold the forces against the measured ones.

        Raises:
            ReproduceError: If the recording came without force plates.
        """
        from plantigrade.analyze.gait_forces import compare_forces
        from plantigrade.workflows.walks import reference_of_trial

        trial = self.trial
        if trial.forces is None:
            name = trial.fit.recording.source.name
            raise ReproduceError(f"{name} came without force plates; nothing to compare with")
        return compare_forces(
            reference_of_trial(trial),
            self.forced,
            trial.forces,
            trial.moments,
            ground=_way(trial),
        )


@dataclass(frozen=True)
class TrackedForces:
    """A motion with the forces that move it.

    Attributes:
        time: Time of each frame [s].
        qpos: Configurations.
        qvel: Velocities.
        tau: Generalised forces: what nothing explains at the root, then joint moments [N m].
        contact_force: Ground reaction on each site, world [N].
        contact_point: Where it acts, world [m].
        side: ``"r"`` or ``"l"`` of each site.
    """

    time: Float[Array, " n"]
    qpos: Float[Array, "n nq"]
    qvel: Float[Array, "n nv"]
    tau: Float[Array, "n nv"]
    contact_force: Float[Array, "n k 3"]
    contact_point: Float[Array, "n k 3"]
    side: tuple[str, ...]

    @property
    def root_residual(self) -> Float[Array, "n 6"]:
        """What nothing explains at the root [N, N m]."""
        return self.tau[:, :6]

    def foot(self, side: str) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
        """Return the ground reaction on a foot [N] and its centre of pressure [m], NaN without."""
        mine = [s == side for s in self.side]
        force, point = self.contact_force[:, mine], np.nan_to_num(self.contact_point[:, mine])
        load = force[:, :, 2].sum(axis=1)[:, None]
        moved = (force[:, :, 2:] * point).sum(axis=1)
        centre = np.divide(moved, load, out=np.full_like(moved, np.nan), where=load > 1e-6)
        return force.sum(axis=1), centre


def track_recording(
    path: str | Path, settings: TrackSettings | None = None, progress: Progress | None = None
) -> Tracked:
    """Fit a recording and repair it.

    Args:
        path: The recording: markers, a skeleton's motion, or joint coordinates.
        settings: What decides the result.
        progress: Told every iteration; returning True stops with the best so far.

    Raises:
        FileError: If the file cannot be read.
        FitError: If it cannot be fitted.
        ParameterError: If no foot is on the ground between start and stop.
    """
    from plantigrade.workflows import fit as fitting

    settings = settings or TrackSettings()
    loaded = fitting.load(Path(path), settings.fit)
    trial = fitting.analyse(fitting.fit(loaded, settings.fit), settings.fit)
    return track_trial(trial, settings, progress)


def track_trial(
    trial: "Trial", settings: TrackSettings | None = None, progress: Progress | None = None
) -> Tracked:
    """Repair a fitted recording; see :func:`track_recording`."""
    from plantigrade.contact.site import foot_sites
    from plantigrade.reproduce.phases import walking_events
    from plantigrade.synthesize.problem.formulation import Body
    from plantigrade.synthesize.solve import synthesize
    from plantigrade.synthesize.tasks.tracking import grounded, track
    from plantigrade.workflows.walks import events_in_order, refuse_uneven

    settings = settings or TrackSettings()
    trial = events_in_order(trial)
    refuse_uneven(trial)
    began = clock.perf_counter()
    human, motion, lift = grounded(trial.fit.human, motion_of(trial))
    walked = walking_events(motion.events)
    first, last = float(motion.time[0]), float(motion.time[-1])
    start, stop = (walked[0].time, walked[-1].time) if len(walked) > 2 else (first, last)
    start = start if settings.start is None else settings.start
    stop = stop if settings.stop is None else settings.stop
    begin = max(start - MARGIN, min(first + EDGE, start))
    end = min(stop + MARGIN, max(last - EDGE, stop))
    task = track(human, motion, start=begin, stop=end, tracking=settings.tracking)
    synthesis = synthesize(
        Body.of(human, foot_sites(human)), task, progress=progress, refinements=settings.refinements
    )
    seconds = clock.perf_counter() - began
    told = SynthesizeSettings(
        task=task.name,
        parameters={"file": str(trial.fit.recording.source.name), "start": start, "stop": stop},
        height=human.height,
        mass=human.mass,
        sex=human.sex,
        joints=human.joints,
        feet=human.feet,
    )
    made = judged(told, synthesis, prepared=seconds - synthesis.seconds)
    end = min(stop, begin + task.plan.duration)
    return Tracked(trial, human, motion, lift, made, begin, start, end, seconds)


def motion_of(trial: "Trial") -> "Motion":
    """Return the smoothed motion of a recording over ground that rests, with its gait events."""
    from plantigrade.dynamics.derivatives import continuous, differentiate
    from plantigrade.motion import Motion
    from plantigrade.motion.recording import even_clock

    recorded, human = trial.record.motion, trial.fit.human
    qpos = continuous(recorded.qpos)
    qpos[:, :3] -= _way(trial)
    time = even_clock(recorded.time)
    smooth = differentiate(human, time, qpos, None)
    events = tuple(sorted(recorded.events, key=lambda e: e.time))
    return Motion(time, smooth.qpos, smooth.qvel, human.joint_names, smooth.qacc, events)


def _way(trial: "Trial") -> Float[Array, "n_frames 3"]:
    from plantigrade.kinematics.ground_level import moving_ground

    return moving_ground(trial.fit.time, trial.feet.heel, trial.feet.toe)
