"""The walks and upper bodies of a person, chosen while they walk."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.control.gait.clearance import Clearance, clearance_of
from plantigrade.control.gait.phase import Gait
from plantigrade.control.gait.reference import Reference, reference_of
from plantigrade.control.pendulum.command import RECORDED, Style
from plantigrade.control.pendulum.controller import Pendulum
from plantigrade.control.pendulum.scaled_reference import ScaledReference
from plantigrade.control.pendulum.summary import StyleChange
from plantigrade.control.pendulum.transition import PhaseMap, Transition
from plantigrade.control.pendulum.upper_body import InStep, Pose, Source, UpperBody, source_of
from plantigrade.control.pendulum.walk import with_feasible_com
from plantigrade.errors import ParameterError
from plantigrade.world import Target


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk ready to be walked."""

    name: str
    reference: Reference
    clearance: Clearance

    @classmethod
    def of(cls, style: Style) -> "Walk":
        """Return the walk of a style."""
        assert style.record is not None
        clearance = clearance_of(style.record)
        return cls(style.name, with_feasible_com(reference_of(style.record, clearance)), clearance)


class Styles:
    """Changes the walk of a pendulum, and its upper body, when the targets say so.

    Args:
        pendulum: The walk.
        own: Its name.
        walks: Other walks.
        uppers: Other upper bodies.

    Attributes:
        targets: The walk and the upper body by number, to be chosen while it walks; only where
            there are several.
        changes: From one walk to another, in order.
        error: Root mean square of the joints' distance from the walk since the last change was
            over [rad]; NaN before.

    Raises:
        ParameterError: If one is of another person, or none that is repeated on level ground.
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
                    f"{style.name} has {other.model.nv} degrees of freedom, the one who walks "
                    f"{human.model.nv}: the joints and feet of both must be the same"
                )
        first = pendulum.reference.recorded
        self._walks = [Walk(own, first, pendulum.clearance), *(Walk.of(w) for w in walks)]
        for walk in self._walks[1:]:
            try:
                PhaseMap(walk.reference.schedule, first.schedule)
            except ParameterError as error:
                raise ParameterError(f"{own}, then {walk.name}: {error}") from error
        self._uppers: list[tuple[str, Reference | Pose | None]] = [(RECORDED, None)]
        self._plan = [(w.time, 0, i + 1) for i, w in enumerate(walks) if w.time is not None]
        for style in uppers:
            what = style.pose if style.record is None else Walk.of(style).reference
            number = 0  # back to the walk's own
            if what is not None:
                number = len(self._uppers)
                self._uppers.append((style.name, what))
            if style.time is not None:
                self._plan.append((style.time, 1, number))
        self._plan.sort()
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

    def begin(self) -> None:
        """Start anew: with the first walk, as recorded."""
        pendulum, first = self._pendulum, self._walks[0]
        if pendulum.reference.recorded is not first.reference:
            pendulum.reference = ScaledReference(first.reference, pendulum.settings.speed)
            pendulum.clearance = first.clearance
        pendulum.reference.transition = pendulum.reference.upper = None
        self._now = [0, 0]
        self._left = list(self._plan)
        for target in self.targets:
            target.set(0.0)
        self.changes: list[StyleChange] = []
        self._since, self._squares, self._counted = 0.0, 0.0, 0

    @property
    def error(self) -> float:
        """Root mean square of the joints' distance from the walk it was changed to [rad]."""
        return float(np.sqrt(self._squares / self._counted)) if self._counted else float("nan")

    @property
    def name(self) -> str:
        """Name of the walk that is walked."""
        return self._walks[self._now[0]].name

    def update(self, time: float, walks: bool) -> None:
        """Change what is to be changed now, if that can be.

        Args:
            time: Now [s].
            walks: Whether the pendulum walks; who stands takes another walk at once.
        """
        if not self.targets:
            return
        while self._left and self._left[0][0] <= time + 1e-9:
            _, k, i = self._left.pop(0)
            target = self._chosen[k]
            assert target is not None
            target.set(float(i))
        style, upper = (0 if t is None else round(t.value) for t in self._chosen)
        scaled = self._pendulum.reference
        if scaled.transition is not None:
            self._blend(time)
        elif style != self._now[0]:
            self._switch(style, time, walks)
        scaled = self._pendulum.reference
        if upper != self._now[1]:
            before = None if scaled.upper is None else scaled.upper.source
            self._now[1] = upper
            scaled.upper = self._dressed(scaled, self._source(upper, time), before, time)
        if scaled.upper is not None:
            scaled.upper.time = time

    def count(self, error: float) -> None:
        """Record the distance of the joints from the walk now [rad]."""
        if self.changes and not self.changing:
            self._squares, self._counted = self._squares + error**2, self._counted + 1

    def _source(self, upper: int, time: float) -> Source | None:
        what = self._uppers[upper][1]
        if what is None:
            return None
        return source_of(self._pendulum.human, what, self._pendulum.reference.recorded, time)

    def _blend(self, time: float) -> None:
        """Continue the transition."""
        pendulum = self._pendulum
        scaled, transition = pendulum.reference, pendulum.reference.transition
        assert transition is not None
        goes = transition.advance(time - self._since)
        scaled.blend(transition if goes else None, pendulum.gait.phase)

    def _switch(self, style: int, time: float, walks: bool) -> None:
        """Begin to turn into another walk, where one foot stands and the other swings on time."""
        pendulum, walk = self._pendulum, self._walks[style]
        before = pendulum.reference
        upper = before.upper
        if not walks:
            scaled = ScaledReference(walk.reference, pendulum.settings.speed)
            scaled.crouch = before.crouch
            self._changed(scaled, style, time, "", float("nan"))
        else:
            gait = pendulum.gait
            swings = [f for f in gait.feet if not f.stands and f.number is not None]
            if len(gait.standing) != 1 or len(swings) != 1:
                return
            foot, stood = swings[0], gait.standing[0]
            if foot.caught or foot.waited or stood.early or gait.phase >= foot.touchdown:
                return
            transition = Transition(walk.reference, before.recorded, pendulum.settings.speed)
            phases = transition.phases
            phase = phases.to_new(gait.phase)
            new = Gait(walk.reference, gait.weight, phase, gait.settings)
            if [f.stands for f in new.feet] != [f.stands for f in gait.feet]:
                return
            scaled = ScaledReference(walk.reference, pendulum.settings.speed)
            scaled.crouch = before.crouch
            ahead = float(before.at(gait.phase).q[0])
            scaled.start(before.step_scale, phase, 0.0)
            scaled.blend(transition, phase)
            scaled.scale(before.step_scale, transition.cadence(phase), phase)
            scaled.shift(ahead - float(scaled.at(phase).q[0]))
            for now, then in zip(new.feet, gait.feet, strict=True):
                now.swing, now.lifted = then.swing, phases.to_new(then.lifted)
                assert now.number is not None and then.number is not None
                new.offset(now.number)[:] = gait.offset(then.number)
            new.rate, new.touchdowns = gait.rate, gait.touchdowns
            share = 100.0 * phases.share(phase)
            self._changed(scaled, style, time, stood.side, share)
            pendulum.walk_on(new)
        self._since, self._squares, self._counted = time, 0.0, 0
        pendulum.clearance = walk.clearance
        if upper is not None:
            sources = [self._renewed(source, time) for source in (upper.source, upper.before)]
            scaled.upper = self._dressed(scaled, sources[0], sources[1], upper.since)

    def _dressed(
        self, scaled: ScaledReference, source: Source | None, before: Source | None, since: float
    ) -> UpperBody:
        settings = self._pendulum.settings.upper_body
        return UpperBody(self._pendulum.human, scaled.recorded, source, before, since, settings)

    def _renewed(self, source: Source | None, time: float) -> Source | None:
        """Return what the upper body does, on the legs of the walk that is walked now."""
        if not isinstance(source, InStep):
            return source
        return source_of(
            self._pendulum.human, source.other, self._pendulum.reference.recorded, time
        )

    def _changed(
        self, scaled: ScaledReference, style: int, time: float, foot: str, percent: float
    ) -> None:
        self._pendulum.reference = scaled
        self._now[0] = style
        self.changes.append(StyleChange(self._walks[style].name, time, foot, percent))
