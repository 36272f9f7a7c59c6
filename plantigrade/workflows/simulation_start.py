"""Start of a simulation: person, ground, initial state, controller."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.plausibility import Plausibility
from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array
from plantigrade.contact.ground import Ground
from plantigrade.contact.limb_sites import SUPPORTED_PARTS
from plantigrade.contact.site import ContactSite
from plantigrade.control import Situation, controller_named
from plantigrade.control.balance import MotionReference, feasible_motion, script_named, scripted
from plantigrade.control.choices import SCRIPTED, WALKING, usual
from plantigrade.control.pendulum import WalkCommand, walk_of
from plantigrade.control.pendulum.command import RECORDED
from plantigrade.control.pendulum.path import depths_of, path_of, speeds_of
from plantigrade.control.pendulum.settings import WALK_DURATION
from plantigrade.errors import ParameterError
from plantigrade.kinematics.ground_level import ground_under
from plantigrade.kinematics.stride import off_the_belt
from plantigrade.learn.controller import PolicyController, load_controller
from plantigrade.learn.policy import file_of
from plantigrade.models import Human
from plantigrade.models.human import require_scaled
from plantigrade.motion import Motion
from plantigrade.motion.recording import rate_of
from plantigrade.notes import Info
from plantigrade.options import LEARNED, as_path, is_policy
from plantigrade.record import Provenance, Record, Run
from plantigrade.record.metrics import METRICS
from plantigrade.record.provenance import source_files
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.fit import provenance as fit_provenance
from plantigrade.workflows.recorded_seat import with_cushion
from plantigrade.workflows.settings import OF_RECORDINGS
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.steps import Step
from plantigrade.workflows.styles import styles_of
from plantigrade.world import Controller, on_ground, standing_on
from plantigrade.world.recorded_wrench import recorded_wrenches

MIN_SOLE_HEIGHT = 0.02
"""Height of standing soles above or below the ground from which a motion is put on it [m]: feet
fitted on a floor are within 10 mm. Chosen."""
MAX_START_DEPTH = 0.3  # Largest depth of the feet below the ground at the start [m]. Chosen.


@dataclass(frozen=True)
class Start:
    """Start of a simulation."""

    human: Human  #: The person
    ground: Ground  #: Ground of the motion
    name: str  #: Name of the source
    provenance: Provenance  #: Its provenance
    motion: Motion | None = None  #: Motion; None for standing
    sites: tuple[ContactSite, ...] = ()  #: Further sites of the body that seats carry
    figures: Mapping[str, Any] | None = None  #: Known figures of the person
    notes: tuple[str, ...] = ()  #: Notes for the user
    record: Record | None = None  #: The motion with its forces
    controller: str = ""  #: Name of the controller: the one that was named, or the usual one
    #: Reference of balance: a foot motion, or a motion brought over the feet
    script: MotionReference | None = None
    policy: Controller | None = None  #: Learned controller
    walk: WalkCommand | None = None  #: Command of the walk
    #: Position [m] and heading [rad] of a person who stands
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def standing(self, ground: Ground) -> Array:
        """Return the posture of standing on a ground."""
        return standing_on(self.human, ground, placement=self.place)


def start_of(
    source: Any, how: SimulateSettings, step: Step, command: str, own: Controller | None = None
) -> Start:
    """Return the start from a recording, a run or its folder; standing without one.

    The walk of a pendulum starts with the stride that it repeats. A controller of one's own gets
    the motion as it is.

    Raises:
        ParameterError: If a run and a person are given, it starts below its ground, or it rests on
            knees, hands or seat on the floor.
        FileError: If a file or run cannot be read.
        FitError: If a recording cannot be fitted.
    """
    if not (_recording(source) or how.words.then or how.words.upper_body):
        how.refuse(OF_RECORDINGS, "without a recording to fit; name one")
    if is_policy(how.controller):
        return replace(_learned(source, how, command), controller=str(how.controller))
    begin = (
        _moving(source, how, step, command)
        if how.motion is None
        else _scripted(source, how, command)
    )
    record, word = begin.record, how.controller
    if word is None:
        word = usual(begin.motion, record, begin.script) if own is None else own.name
    begin = replace(begin, controller=word)
    if record is None:
        return begin
    if own is None and word != WALKING:
        begin, record = _over_ground(begin, record)
    if own is None:
        begin, record = _on_the_ground(begin, record)
    if own is None and word == SCRIPTED and record.motion.n_frames > 1:  # one frame is held
        begin = _over_the_feet(begin)
    walk = walk_of(record) if word == WALKING else record
    begin = replace(begin, notes=(*begin.notes, *_external_notes(record, walk)))
    if word != WALKING:
        return begin
    notes = (*begin.notes, *walk.notes[len(record.notes) :])
    return replace(
        begin,
        record=walk,
        motion=walk.motion,
        ground=walk.ground,
        notes=notes,
        walk=walk_command(begin, how, step),
    )


def _over_ground(begin: Start, record: Record) -> tuple[Start, Record]:
    """Return a start and its motion, which goes over the ground if it was on a treadmill."""
    motion = off_the_belt(record.human, record.motion)
    if motion is record.motion:
        return begin, record
    far = float(np.linalg.norm((motion.qpos[-1] - motion.qpos[0])[:2]))
    note = Info(f"The motion was recorded on a treadmill; over the ground it goes {far:.1f} m.")
    on = replace(record, motion=motion)
    return replace(begin, record=on, motion=motion, notes=(*begin.notes, note)), on


def _on_the_ground(begin: Start, record: Record) -> tuple[Start, Record]:
    """Return a start and its motion, put on level ground that its standing feet do not meet."""
    ground, motion = record.ground, record.motion
    if begin.sites or not ground.level:
        return begin, record
    under = ground_under(record.human, motion.qpos, rate_of(motion.time))
    if under is None or np.abs(under - ground.height).max() < MIN_SOLE_HEIGHT:
        return begin, record
    qpos, moved = motion.qpos.copy(), ground.height - under
    qpos[:, 2] += moved
    on = replace(record, motion=replace(motion, qpos=qpos))
    way, far = "up" if moved.mean() > 0.0 else "down", 1e3 * np.abs(moved).max()
    note = Info(f"The motion was moved {way} by up to {far:.0f} mm: its feet were off the ground.")
    return replace(begin, record=on, motion=on.motion, notes=(*begin.notes, note)), on


def _external_notes(record: Record, walk: Record) -> tuple[str, ...]:
    """Return notes on what acts on the body in a motion besides ground, seats and supports.

    Args:
        walk: What the controller follows: the motion, or a stride of it.
    """
    notes: list[str] = []
    if wrenches := recorded_wrenches(record):
        acting = ", ".join(
            f"{wrench.site.body} (up to {np.linalg.norm(wrench.force, axis=1).max():.0f} N)"
            for wrench in wrenches
        )
        if recorded_wrenches(walk):
            notes.append(Info(f"Forces of the motion act in the simulation, too: on {acting}."))
        else:
            notes.append(
                f"forces of the motion on {acting} are left out, because a stride of it is "
                "repeated: give a periodic motion that leads forward, or another controller"
            )
    if record.device_torque.any():
        notes.append(
            "the torque that a device adds in the motion is left out: the joints' motors exert it"
        )
    return tuple(notes)


def controller_of(begin: Start, ground: Ground, how: SimulateSettings, word: str) -> Controller:
    """Return a controller by its name, for a start.

    Raises:
        ParameterError: If there is no such controller, or it does not fit the start.
    """
    if begin.policy is not None and is_policy(word):
        return begin.policy
    return controller_named(word, situation(begin, ground), how.values)


def _learned(source: Any, how: SimulateSettings, command: str) -> Start:
    """Return the person of a policy, at the start of the walk that it follows.

    Raises:
        ParameterError: If a recording or a foot motion is named, too.
        FileError: If there is no such policy.
    """
    if source is not None or how.motion is not None:
        raise ParameterError("a policy brings its own motion: leave out recording, run and motion")
    policy = _policy_of(how)
    word, lasts = str(how.controller), how.duration or WALK_DURATION
    origin = Provenance(command, how.plain(), seed=how.seed)
    name, motion = Path(word).stem, policy.motion(lasts)
    return Start(policy.reference.human, Ground(), name, origin, motion, policy=policy)


def _recording(source: Any) -> Path | None:
    """Return the file of a recording; None where the source is a run, its folder or nothing."""
    if source is None or isinstance(source, Run):
        return None
    path = as_path(source, "what is simulated")
    return None if path.is_dir() else path


def _over_the_feet(begin: Start) -> Start:
    """Return a start whose motion is one that the feet can carry."""
    assert begin.motion is not None
    desired = MotionReference(begin.human, begin.motion, ground=begin.ground)
    motion = feasible_motion(begin.human, desired)
    script = MotionReference(begin.human, motion, desired.contact)
    moved = 1e3 * float(np.linalg.norm((script.com - desired.com)[:, :2], axis=1).max())
    note = f"The centre of mass was moved by up to {moved:.0f} mm to where the feet can carry it."
    return replace(begin, motion=motion, script=script, notes=(*begin.notes, note))


def _moving(source: Any, how: SimulateSettings, step: Step, command: str) -> Start:
    """Return a start without a script."""
    path = _recording(source)
    if path is not None:
        recording, trial = fit_trial(path, how, step)
        origin = fit_provenance(recording, how, command, how.seed)
        return _of_trial(recording.source.name, trial, origin)
    if source is None:
        human = how.human()
        return Start(human, Ground(), "standing", Provenance(command, how.plain(), seed=how.seed))
    if not isinstance(source, Run):
        source = Run.load(source)
    how.refuse_person()
    record, folder = source.record, source.folder
    require_scaled(record.human, "a simulation")
    if not record.human.on_earth:
        raise ParameterError(
            f"this run has a gravity of {record.human.gravity:.2f} m/s², and controllers are made "
            "for the earth's: give a run without gravity"
        )
    first = record.motion.qpos[0]
    sunk = float(on_ground(record.human, record.ground, first)[2] - first[2])
    if sunk > MAX_START_DEPTH:
        raise ParameterError(
            f"the motion starts {sunk:.2f} m below its ground; give a run whose feet are on it"
        )
    _require_feet_and_seats(record)
    if record.ground.moves:
        raise ParameterError(
            "this motion is on ground or supports that move, and controllers know only those at "
            "rest; give a motion without [ground] and motion"
        )
    record = with_cushion(record)
    files = {} if folder is None else source_files([folder / METRICS])
    return Start(
        record.human,
        record.ground,
        source.name or source.kind,
        Provenance(command, how.plain(), files, how.seed),
        record.motion,
        _carriers(record),
        record=record,
    )


def _scripted(source: Any, how: SimulateSettings, command: str) -> Start:
    """Return the start of a foot motion."""
    if source is not None:
        raise ParameterError("motion and a recording or run cannot be combined; give one")
    word = str(how.motion)
    human, script = how.human(), script_named(word)
    if human.feet != "multi-segment":
        raise ParameterError(
            f"motion={word} moves segments of the foot: it needs feet=multi-segment or joints=66"
        )
    follow = scripted(human, script)
    origin = Provenance(command, how.plain(), seed=how.seed)
    name = Path(word).stem
    return Start(human, Ground(), name, origin, follow.motion, script=follow)


def _of_trial(name: str, trial: Trial, origin: Provenance) -> Start:
    """Return the start from a recording; notes say what makes it doubtful."""
    record = with_cushion(trial.record())
    record = replace(record, notes=(*Plausibility.of(trial).notes, *record.notes))
    sites = _carriers(record)
    stem = Path(name).stem
    return Start(
        record.human, record.ground, stem, origin, record.motion, sites, None, record.notes, record
    )


def _require_feet_and_seats(record: Record) -> None:
    """Raise for a motion that kneels, or rests hands or seat on the floor."""
    seats = {seat.site for seat in record.ground.seats}
    others = [
        site.name
        for site in record.sites
        if site.name in SUPPORTED_PARTS and not site.measured and site.name not in seats
    ]
    if others:
        raise ParameterError(
            f"this motion rests on {', '.join(others)} on the floor, and controllers know only of "
            "feet, seats and supports; give a motion that does not"
        )


def _carriers(record: Record) -> tuple[ContactSite, ...]:
    """Return the sites on no foot that a seat or the ground carries."""
    return tuple(site for site in record.sites if not site.side and not site.measured)


def situation(begin: Start, ground: Ground) -> Situation:
    """Return the situation of a controller."""
    stands = None if begin.motion is not None else begin.standing(ground)
    return Situation(
        human=begin.human,
        ground=ground,
        motion=begin.motion,
        standing=stands,
        record=begin.record,
        script=begin.script,
        walk=begin.walk,
    )


def walk_command(begin: Start, how: SimulateSettings, step: Step) -> WalkCommand:
    """Return the command of a walk.

    Raises:
        PlantigradeError: If a text is no speed or path, no other walk or upper body.
    """
    words = how.words
    walks, uppers = styles_of(begin.human, how, step)
    return WalkCommand(
        own=begin.name if walks else RECORDED,
        walks=walks,
        uppers=uppers,
        speed=None if words.speed is None else speeds_of(words.speed),
        path=None if words.path is None else path_of(words.path),
        stoop=None if words.stoop is None else depths_of(words.stoop),
    )


def _policy_of(how: SimulateSettings) -> PolicyController:
    """Return the policy of the settings.

    Raises:
        ParameterError: If they describe a person, because a policy defines its own.
        FileError: If there is no such policy.
    """
    known, word = dict(how.known), str(how.controller)
    path = file_of(word, known.pop("feet", None) if word == LEARNED else None)
    if known:
        raise ParameterError(
            f"a policy defines its own person: leave out {', '.join(known)}, or train one for yours"
        )
    return load_controller(path)
