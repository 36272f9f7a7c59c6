"""The walks and upper bodies of a person, chosen while they walk."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.control.gait.clearance import SelfClearance, clearance_of
from plantigrade.control.gait.phase import GaitState
from plantigrade.control.gait.reference import ReferenceTables
from plantigrade.control.pendulum.command import RECORDED, Style
from plantigrade.control.pendulum.controller import Pendulum
from plantigrade.control.pendulum.reference import ScaledReference
from plantigrade.control.pendulum.summary import StyleChange
from plantigrade.control.pendulum.transition import PhaseMap, Transition
from plantigrade.control.pendulum.upper_body import (
    BlendedUpperBody,
    FixedPose,
    Source,
    UpperMotion,
    source_of,
)
from plantigrade.errors import ParameterError
from plantigrade.world import Target


@dataclass(frozen=True, eq=False)
class PreparedWalk:
    """A walk ready to be walked."""

    name: str
    reference: ReferenceTables
    clearance: SelfClearance

    @classmethod
    def of(cls, style: Style, pendulum: Pendulum) -> "PreparedWalk":
        """Return the walk of a style, for a person."""
        assert style.record is not None
        clearance = clearance_of(style.record)
        return cls(style.name, pendulum.reference_for(style.record, clearance), clearance)


class Styles:
    """Changes the walk of a pendulum, and its upper body, when the targets say so.

    Attributes:
        targets: The walk and the upper body by number, to be chosen while it walks; only where
            there are several.
        changes: From one walk to another, in order.
    """

    def __init__(
        self,
        pendulum: Pendulum,
        own: str = RECORDED,
        walks: Sequence[Style] = (),
        uppers: Sequence[Style] = (),
    ):
        self._pendulum, human = pendulum, pendulum.human
        for style in (*walks, *uppers):
            other = human if style.record is None else style.record.human
            if other.joint_names != human.joint_names:
                raise ParameterError(
                    f"{style.name} has {other.model.nv} degrees of freedom, the person who walks "
                    f"has {human.model.nv}: the joints and feet of both must be the same"
                )
        first = pendulum.reference.recorded
        self._walks = [
            PreparedWalk(own, first, pendulum.clearance),
            *(PreparedWalk.of(w, pendulum) for w in walks),
        ]
        for walk in self._walks[1:]:
            try:
                PhaseMap(walk.reference.schedule, first.schedule)
            except ParameterError as error:
                raise ParameterError(f"{own}, then {walk.name}: {error}") from error
        self._uppers: list[tuple[str, ReferenceTables | FixedPose | None]] = [(RECORDED, None)]
        self._schedule = [(w.time, 0, i + 1) for i, w in enumerate(walks) if w.time is not None]
        for style in uppers:
            what = (
                style.pose if style.record is None else PreparedWalk.of(style, pendulum).reference
            )
            number = 0  # back to the walk's own
            if what is not None:
                number = len(self._uppers)
                self._uppers.append((style.name, what))
            if style.time is not None:
                self._schedule.append((style.time, 1, number))
        self._schedule.sort()
        names = [[w.name for w in self._walks], [name for name, _ in self._uppers]]
        self._chosen = tuple(
            Target(what, 0.0, len(own) - 1.0, 0.0, names=tuple(own)) if len(own) > 1 else None
            for what, own in zip(("style", "upper body"), names, strict=True)
        )
        self.targets = tuple(target for target in self._chosen if target is not None)
        self.begin()

    @property
    def fastest(self) -> float:
        """Speed of the fastest walk [m/s]."""
        walks = (walk.reference for walk in self._walks)
        return max(float(w.advance[0]) / w.duration if w.period else 0.0 for w in walks)

    @property
    def changing(self) -> bool:
        """Whether one walk turns into another now."""
        return self._pendulum.reference.transition is not None

    @property
    def error(self) -> float:
        """Root mean square error of the joints since the last change was over [rad], or NaN."""
        return float(np.sqrt(self._squares / self._counted)) if self._counted else float("nan")

    @property
    def name(self) -> str:
        """Name of the walk that is walked."""
        return self._walks[self._walk].name

    def begin(self) -> None:
        """Start anew: with the first walk, as recorded."""
        pendulum, first = self._pendulum, self._walks[0]
        if pendulum.reference.recorded is not first.reference:
            pendulum.reference = ScaledReference(first.reference, pendulum.settings.speed)
            pendulum.clearance = first.clearance
        pendulum.reference.transition = pendulum.reference.upper = None
        self._walk = self._upper = 0
        self._left = list(self._schedule)
        for target in self.targets:
            target.set(0.0)
        self.changes: list[StyleChange] = []
        self._since, self._squares, self._counted = 0.0, 0.0, 0

    def update(self, time: float, walks: bool) -> None:
        """Make the changes that are due, once the gait allows them.

        Args:
            time: Now [s].
            walks: Whether the pendulum walks; a person who stands takes another walk at once.
        """
        if not self.targets:
            return
        while self._left and self._left[0][0] <= time + 1e-9:
            _, k, i = self._left.pop(0)
            target = self._chosen[k]
            assert target is not None
            target.set(float(i))
        walk, upper = (0 if t is None else round(t.value) for t in self._chosen)
        pendulum = self._pendulum
        transition = pendulum.reference.transition
        if transition is not None:
            goes_on = transition.advance(time - self._since)
            pendulum.reference.blend(transition if goes_on else None, pendulum.gait.phase)
        elif walk != self._walk:
            self._change_walk(walk, time, walks)
        reference = pendulum.reference
        if upper != self._upper:
            before = None if reference.upper is None else reference.upper.source
            self._upper, what = upper, self._uppers[upper][1]
            self._set_upper(None if what is None else self._source(what, time), before, time)
        if reference.upper is not None:
            reference.upper.time = time

    def record_error(self, error: float) -> None:
        """Record the error of the joints now [rad]."""
        if self.changes and not self.changing:
            self._squares, self._counted = self._squares + error**2, self._counted + 1

    def _source(self, other: ReferenceTables | FixedPose, time: float) -> Source:
        """Return an upper body for the legs of the present walk."""
        walk = self._pendulum.reference.recorded
        return source_of(self._pendulum.human, other, walk, time)

    def _set_upper(self, source: Source | None, before: Source | None, since: float) -> None:
        """Let one upper body turn into another."""
        pendulum = self._pendulum
        reference, settings = pendulum.reference, pendulum.settings.speed
        reference.upper = BlendedUpperBody(
            pendulum.human, reference.recorded, source, before, since, settings
        )

    def _change_walk(self, number: int, time: float, walks: bool) -> None:
        """Begin to turn into another walk, in single support with the swing on time."""
        pendulum, walk = self._pendulum, self._walks[number]
        upper, crouch = pendulum.reference.upper, pendulum.reference.crouch
        change = StyleChange(walk.name, time, "", float("nan"))
        if not walks:
            pendulum.reference = ScaledReference(walk.reference, pendulum.settings.speed)
        else:
            found = self._in_single_support(walk, time)
            if found is None:
                return
            change = found
        pendulum.reference.crouch = crouch
        self._walk, pendulum.clearance = number, walk.clearance
        self.changes.append(change)
        self._since, self._squares, self._counted = time, 0.0, 0
        if upper is not None:
            source, before = (
                self._source(each.motion, time)
                if isinstance(each, UpperMotion) and each.phases is not None
                else each
                for each in (upper.source, upper.before)
            )
            self._set_upper(source, before, upper.since)

    def _in_single_support(self, walk: PreparedWalk, time: float) -> StyleChange | None:
        """Begin a transition to another walk at a like instant; None if none can begin now."""
        pendulum, gait = self._pendulum, self._pendulum.gait
        before, settings = pendulum.reference, pendulum.settings.speed
        if gait.single_support is None:
            return None
        foot, stance = gait.single_support
        if foot.recovering or foot.wait or stance.early or gait.phase >= foot.touchdown:
            return None
        transition = Transition(walk.reference, before.recorded, settings)
        phases = transition.phases
        phase = phases.to_new(gait.phase)
        new = GaitState(walk.reference, gait.weight, phase, gait.settings)
        if [f.in_stance for f in new.feet] != [f.in_stance for f in gait.feet]:
            return None
        reference = ScaledReference(walk.reference, settings)
        reference.crouch = before.crouch
        ahead = float(before.at(gait.phase).q[0])
        reference.start(before.step_scale, phase, 0.0)
        reference.blend(transition, phase)
        reference.scale(before.step_scale, transition.cadence(phase), phase)
        reference.shift(ahead - float(reference.at(phase).q[0]))
        for now, then in zip(new.feet, gait.feet, strict=True):
            now.swing, now.lift_off = then.swing, phases.to_new(then.lift_off)
            assert now.stance is not None and then.stance is not None
            new.offset(now.stance)[:] = gait.offset(then.stance)
        new.rate, new.touchdowns = gait.rate, gait.touchdowns
        pendulum.reference = reference
        pendulum.walk_on(new)
        return StyleChange(walk.name, time, stance.side, 100.0 * phases.share(phase))
