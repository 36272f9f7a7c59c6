"""Other walks of a person, and what their upper body does instead: recordings, runs, poses."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from plantigrade.control.pendulum.command import RECORDED, Style
from plantigrade.control.pendulum.transfer import transferred_walk
from plantigrade.control.pendulum.upper_body import POSES, FixedPose
from plantigrade.errors import ParameterError
from plantigrade.kinematics.stride import stride_of
from plantigrade.kinematics.transfer import transferred
from plantigrade.models import Human
from plantigrade.options import as_path
from plantigrade.record import Record, Run
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.steps import Step

THEN = "write FILE@S or RUN@S, such as stroll.c3d@4"
UPPER = (
    "write FILE, RUN, a pose such as arms-up, angles such as arm_flex_r=60,elbow_flex_r=90 "
    "(degrees) or recorded, each with @S where it begins later"
)


def styles_of(
    human: Human, how: SimulateSettings, step: Step
) -> tuple[tuple[Style, ...], tuple[Style, ...]]:
    """Return the other walks of a person, and what their upper body does instead.

    Recordings are fitted, with the joints and feet of the person; their walks are carried over to
    the person's body.

    Raises:
        ParameterError: If a text is invalid, or a walk has no stride or a person with other
            joints.
        FileError: If a file or run cannot be read.
        FitError: If a recording cannot be fitted.
    """
    walks = []
    for word in how.words.then:
        what, time = timed(word, "walk to go over to", THEN)
        record = _found(what, human, how, step)
        try:
            walk = transferred_walk(record, human)
        except ParameterError as error:
            raise ParameterError(f"then={word}: {error}") from error
        walks.append(Style(name=Path(what).stem, record=walk, time=time))
    uppers = [_upper(word, human, how, step) for word in how.words.upper_body]
    known = [upper.name for upper in uppers]
    uppers += [
        Style(name=name, pose=_posed(human, angles))  # by hand
        for name, angles in POSES.items()
        if name not in known and set(angles) <= set(human.coordinates)
    ]
    return tuple(walks), tuple(uppers)


def _posed(human: Human, angles: Mapping[str, float]) -> FixedPose:
    return FixedPose.of(human, {name: float(np.deg2rad(angle)) for name, angle in angles.items()})


def timed(word: str, what: str, form: str) -> tuple[str, float | None]:
    """Return a word without its time, and that [s]; None where it has none."""
    name, at, when = word.rpartition("@")
    if not at:
        return word, None
    try:
        time = float(when)
    except ValueError:
        time = -1.0
    if not (name and np.isfinite(time) and time >= 0.0):
        raise ParameterError(f"{word!r} is no {what}: {form}")
    return name, time


def pose_of(word: str) -> dict[str, float] | None:
    """Return coordinate → angle of a word [rad]; None where it is no pose."""
    if "=" not in word:
        return None
    angles = {}
    for part in word.split(","):
        name, _, angle = part.partition("=")
        try:
            angles[name.strip()] = float(np.deg2rad(float(angle)))
        except ValueError:
            raise ParameterError(f"{word!r} is no upper body: {UPPER}") from None
    return angles


def _upper(word: str, human: Human, how: SimulateSettings, step: Step) -> Style:
    what, time = timed(word, "upper body", UPPER)
    time = time or 0.0
    if what == RECORDED:
        return Style(name=RECORDED, time=time)
    if what in POSES:
        return Style(name=what, pose=_posed(human, POSES[what]), time=time)
    angles = pose_of(what)
    if angles is not None:
        return Style(name=what, pose=FixedPose.of(human, angles), time=time)
    record = _found(what, human, how, step)
    try:
        walk = transferred_walk(record, human)
    except ParameterError:  # no walk
        moved = transferred(record, human)
        motion = stride_of(human, moved.motion).motion(human)
        walk = Record(human, motion, notes=moved.notes)
    return Style(name=Path(what).stem, record=walk, time=time)


def _found(word: str, human: Human, how: SimulateSettings, step: Step) -> Record:
    """Return the record of a recording or run."""
    path = as_path(word, "another walk")
    if path.is_dir():
        record = Run.load(path).record
    else:
        kept = {"marker_set": how.marker_set, "cutoff": how.cutoff}
        own = FitSettings.given("fit", None, {"joints": human.joints, "feet": human.feet, **kept})
        record = fit_trial(path, own, step)[1].record()
    if record.human.joint_names != human.joint_names:
        raise ParameterError(
            f"the person of {word} has {record.human.model.nv} degrees of freedom, the one who "
            f"walks has {human.model.nv}: the joints and feet of both must be the same"
        )
    return record
