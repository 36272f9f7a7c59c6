"""The mean walk of adults, balanced: forces on its feet could drive it.

Mean curves of joint angles leave the path of the pelvis over the feet uncertain by some
millimetres, and with it where the centre of pressure would have to be. The pelvis is shifted until
the zero-moment point of the motion is the centre of pressure of people.
"""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.force_scales import PHASE, UsualStance
from plantigrade.kinematics.planting import lead_pelvis
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.textbook_walk import ADULT_SPREAD, TextbookWalk, textbook_walk
from plantigrade.models import Human
from plantigrade.motion.blends import cubic_rise
from plantigrade.motion.filters import interpolate

CUTOFF = 6.0  # [Hz] low-pass of the motion, usual for walking (Winter 2009)
HARMONICS = 6  # harmonics of the stride in the path of the pelvis


def adult_walk(human: Human, *, speed: float = 1.25) -> TextbookWalk:
    """Return three strides of the mean walk of adults, which forces on the feet could drive.

    Args:
        speed: Walking speed [m/s].
    """
    walk = textbook_walk(human, speed=speed, adult=True)
    spread = {name: float(np.deg2rad(value)) for name, value in ADULT_SPREAD.items()}
    return replace(walk, qpos=lead_pelvis(human, walk.qpos, _off_balance(walk), spread))


def _off_balance(walk: TextbookWalk) -> Float[Array, "n_frames 2"]:
    r"""Return the shift of the pelvis that balances the walk, world axes [m].

    A shift :math:`\delta` of the body at height :math:`h` moves its zero-moment point by
    :math:`\delta - (h / g) \ddot\delta`; harmonic by harmonic of the middle stride that makes up
    for the distance from the centre of pressure.
    """
    human, time = walk.human, walk.time
    smooth = differentiate(human, time, walk.qpos, CUTOFF)
    body = centroid(human, smooth.qpos, smooth.qvel, smooth.qacc)
    assert body.zmp is not None
    error = body.zmp[:, :2] - _pressure(walk)
    strikes = [e.time for e in walk.events if (e.side, e.kind) == ("r", "heel_strike")]
    start, stop = strikes[1:3]
    at = np.linspace(start, stop, 128, endpoint=False)
    waves = np.fft.rfft(interpolate(at, time, error).T)[:, : HARMONICS + 1] / len(at)
    rate = 2 * np.pi * np.arange(HARMONICS + 1) / (stop - start)
    waves = -waves / (1 + body.com[:, 2].mean() / GRAVITY * rate**2)
    waves[:, 1:] *= 2
    return (waves[:, :, None] * np.exp(1j * rate[:, None] * (time - start))).sum(axis=1).real.T


def _pressure(walk: TextbookWalk) -> Float[Array, "n_frames 2"]:
    """Return the centre of pressure of people on these feet, world axes [m].

    It rolls over each foot as people's does, and goes over to the next in double support.
    """
    human, time = walk.human, walk.time
    ankle = PointSet(human, ["foot_r", "foot_l"], np.zeros((2, 3))).path(walk.qpos)[..., :2]
    load, point = np.zeros((2, len(time))), np.zeros((2, len(time), 2))
    for k, side in enumerate(("r", "l")):
        strikes, offs = (
            np.array([e.time for e in walk.events if (e.side, e.kind) == (side, kind)])
            for kind in ("heel_strike", "toe_off")
        )
        period = strikes[1] - strikes[0]
        length = (offs[offs > strikes[0]][0] - strikes[0]) / period
        both = length - 0.5  # of the cycle, each double support
        phase = (time - strikes[0]) / period
        cycle = np.floor(phase)
        share = (phase - cycle) / length
        for c in np.unique(cycle):
            stance = (cycle == c) & (share <= 1)
            middle = stance & (share > 0.25) & (share < 0.6)
            if not middle.any():  # the edge of the walk shows less than a stance
                continue
            spot = np.median(ankle[middle, k], axis=0)
            out = -1.0 if side == "r" else 1.0
            ahead, aside = (
                np.interp(share[stance], PHASE, path)
                for path in (UsualStance().cop_forward, UsualStance().cop_outward)
            )
            own = human.dimensions.foot_length * np.stack([ahead, out * aside], axis=1)
            point[k, stance] = spot + own
            near = np.minimum(share[stance], 1 - share[stance]) * length / both
            load[k, stance] = cubic_rise(near)
    total = load.sum(axis=0)
    known = total > 0.5
    pressure = (load[..., None] * point).sum(axis=0)[known] / total[known, None]
    return interpolate(time, time[known], pressure)
