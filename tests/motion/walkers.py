"""Feet of a walker made in closed form, whose events are known exactly."""

import numpy as np

from plantigrade.constants import SIDES


def walker(
    *,
    speed=1.2,
    stride_time=1.1,
    stance=0.62,
    cycles=5,
    rate=100.0,
    heading=0.0,
    belt=False,
    turn=0.0,
    noise=0.0,
    foot=0.2,
    seed=0,
    backward=False,
    runs=False,
):
    """Return time, heel, toe, pelvis and the true events [(time, side, kind)].

    In stance the foot is still, but for the forefoot that comes down first and the heel rising over
    the toe in its last third; in swing it travels one stride, its speed starting and ending
    abruptly.
    """
    duration = cycles * stride_time
    time = np.arange(int(duration * rate)) / rate
    stride = speed * stride_time
    heel, toe, truth = np.zeros((len(time), 2, 3)), np.zeros((len(time), 2, 3)), []
    for k, side in enumerate(SIDES):
        left = side == "l"
        cycle = time / stride_time + 0.5 * left + 0.13
        number, phase = np.floor(cycle), cycle % 1.0
        swing = np.clip((phase - stance) / (1 - stance), 0.0, 1.0)
        # Half a sine wave on a step: the foot leaves at three tenths of its peak speed, as people's
        # feet do, and lands at an eighth.
        gone = 0.42 * swing - 0.126 * swing**2 + 0.3527 * (1 - np.cos(np.pi * swing))
        x = stride * (number + gone - 0.13 - 0.5 * left)
        rise = np.clip((phase - 0.66 * stance) / (0.34 * stance), 0.0, 1.0)
        pitch = np.where(phase < stance, 0.8 * rise**2, 0.8 * (1 - swing) ** 2 - 0.35 * swing**2)
        # The raised forefoot comes down about heel strike, fastest then, as the plates of real
        # walkers show.
        slap = 0.06 * stance
        to_strike = (phase + 0.5) % 1.0 - 0.5
        fall = np.clip((to_strike + slap) / (2 * slap), 0.0, 1.0)
        raised = np.where(to_strike < 0, swing**2, 1.0) * (0.1 if runs else 0.35)
        down = -raised * 0.5 * (1 + np.cos(np.pi * fall))
        pitch = np.where(np.abs(to_strike) <= slap, down, pitch)
        # A runner's foot comes down at speed; a walker's is put down.
        lift = 0.12 * np.sin(np.pi * swing) if runs else 0.04 * np.sin(np.pi * swing) ** 2
        toe_z = lift + np.where(pitch < 0, -foot * np.sin(pitch), 0.0)
        heel_z = lift + np.where(pitch > 0, foot * np.sin(pitch), 0.0)
        offset = np.where(pitch > 0, foot * (1 - np.cos(pitch)), 0.0)
        y = 0.06 * (1 if left else -1)
        direction = -1.0 if backward else 1.0
        heel[:, k] = np.stack([x + direction * offset, np.full_like(x, y), heel_z], axis=1)
        toe[:, k] = np.stack(
            [
                x + direction * foot * np.where(pitch > 0, 1.0, np.cos(pitch)),
                np.full_like(x, y),
                toe_z,
            ],
            axis=1,
        )
        for n in range(-2, cycles + 2):
            for fraction, kind in ((0.0, "heel_strike"), (stance, "toe_off")):
                instant = (n + fraction - 0.5 * left - 0.13) * stride_time
                if time[0] - 0.1 < instant < time[-1] + 0.1:
                    truth.append((instant, side, kind))
    pelvis = np.stack([speed * time, 0 * time, 0.95 + 0 * time], axis=1)
    if turn:  # bend the straight path into an arc of radius `turn`

        def bend(p):
            angle = p[..., 0] / turn
            r = turn - p[..., 1]
            return np.stack([r * np.sin(angle), turn - r * np.cos(angle), p[..., 2]], axis=-1)

        heel, toe, pelvis = bend(heel), bend(toe), bend(pelvis)
    if belt:
        back = np.stack([speed * time, 0 * time, 0 * time], axis=1)
        heel, toe, pelvis = heel - back[:, None], toe - back[:, None], pelvis - back
    c, s = np.cos(heading), np.sin(heading)
    matrix = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    random = np.random.default_rng(seed)
    out = [p @ matrix.T + noise * random.standard_normal(p.shape) for p in (heel, toe, pelvis)]
    return time, *out, sorted(truth)


def compare(events, truth, *, tolerance=0.1):
    """Return errors [s] by kind, missed true events, and events that are not true."""
    left = list(events)
    errors, missed = {"heel_strike": [], "toe_off": []}, []
    for instant, side, kind in truth:
        same = [e for e in left if e.side == side and e.kind == kind]
        best = min(same, key=lambda e: abs(e.time - instant), default=None)
        if best is None or abs(best.time - instant) > tolerance:
            missed.append((instant, side, kind))
            continue
        left.remove(best)
        errors[kind].append(best.time - instant)
    return errors, missed, left
