"""The walk up to the phase at which it is pushed: one push after another begins there."""

from collections.abc import Callable
from typing import Any

from experiments.guest import Guest, PushedGuest
from experiments.walk_trial import PushedWalk
from experiments.walkers import Walker

_LAST_PUSHED: list[tuple[Any, float, PushedWalk | PushedGuest]] = []


def pushed_at(one: Walker | Callable[[], Guest], phase: float) -> PushedWalk | PushedGuest:
    """Return the walk up to a phase; that of the last call if it is the same."""
    if not _LAST_PUSHED or _LAST_PUSHED[0][0] is not one or _LAST_PUSHED[0][1] != phase:
        pushed = PushedWalk(one, phase) if isinstance(one, Walker) else PushedGuest(one, phase)
        _LAST_PUSHED[:] = [(one, phase, pushed)]
    return _LAST_PUSHED[0][2]
