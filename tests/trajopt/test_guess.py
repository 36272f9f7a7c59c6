"""First guesses against the plan they are made for, by plain MuJoCo kinematics."""

from functools import cache

import mujoco
import numpy as np
import pytest

from plantigrade import ContactPlan
from plantigrade.contact.site import foot_sites
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.textbook_gait import textbook_gait
from plantigrade.spatial.conventions import PELVIS
from plantigrade.trajopt import PeriodicClosure
from plantigrade.trajopt.guess.legs import Leg
from plantigrade.trajopt.guess.walk import crude_guess, walking_guess, with_noise
from plantigrade.trajopt.tasks.gait_parameters import gait_parameters
from plantigrade.trajopt.tasks.walking_plan import periodic_walk_plan, walk_plan
from plantigrade.trajopt.transcription.mesh import nodes_of

FEET = ["rigid", "two-segment", "multi-segment"]


@cache
def person(height=1.74, feet: str | None = "two-segment", joints="42") -> Human:
    return Human.create(height, 23.0 * height**2, feet=feet, joints=joints)


def site_places(human, q):
    """Lowest points of all sites (n_times, n_sites, 3) [m]."""
    data, sites = mujoco.MjData(human.model), foot_sites(human)
    bodies = [human.body(s.body) for s in sites]
    local = np.array([s.position for s in sites])
    out = np.empty((len(q), len(sites), 3))
    for i, qpos in enumerate(human.from_coordinates(PELVIS + human.coordinates, q)):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(human.model, data)
        turned = np.einsum("kij,kj->ki", data.xmat[bodies].reshape(-1, 3, 3), local)
        out[i] = data.xpos[bodies] + turned
    out[:, :, 2] -= [s.radius for s in sites]
    return out


def flat_foot(human):
    """Sites of flat feet as seen from the ground below their own ankle."""
    q = np.zeros((1, 6 + len(human.coordinates)))
    q[0, 4] = human.to_coordinates(human.standing()[None])[1][0, 4]
    data = mujoco.MjData(human.model)
    data.qpos[:] = human.from_coordinates(PELVIS + human.coordinates, q)[0]
    mujoco.mj_kinematics(human.model, data)
    below = [data.xpos[human.body(f"foot_{s.side}")] * [1, 1, 0] for s in foot_sites(human)]
    return site_places(human, q)[0] - below


def misplaced(human, plan: ContactPlan, q, times):
    """How far standing sites are from where a flat foot has them, and the lowest swinging one."""
    places, flat = site_places(human, q), flat_foot(human)
    farthest, lowest = 0.0, np.inf
    for k, site in enumerate(foot_sites(human)):
        down = plan.standing(site, times)
        lowest = min(lowest, places[~down, k, 2].min(initial=np.inf))
        for stance in plan.stances:
            f = stance.footprint
            if f.side == site.side:
                start, stop = stance.interval(site.part)
                c, s = np.cos(f.heading), np.sin(f.heading)
                at = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ flat[k] + f.position
                own = down & (times >= start) & (times <= stop)
                farthest = max(farthest, np.abs(places[own, k] - at).max(initial=0.0))
    return farthest, lowest


CASES = [
    (height, feet, speed)
    for feet, pairs in {
        "rigid": ((1.50, 2.0), (1.74, 0.6), (1.95, 1.3)),
        "two-segment": ((1.50, 0.6), (1.50, 2.0), (1.74, 1.3), (1.95, 2.0)),
        "multi-segment": ((1.50, 1.3), (1.74, 2.0), (1.95, 0.6)),
    }.items()
    for height, speed in pairs
]


@pytest.mark.parametrize(("height", "feet", "speed"), CASES)
def test_feet_are_on_their_footprints(height, feet, speed):
    human = person(height, feet)
    p = gait_parameters(human, speed)
    for plan in (walk_plan(human, p, steps=3), periodic_walk_plan(human, p)):
        times = nodes_of(plan, 12.0)
        q = walking_guess(human, plan, p, times)
        farthest, lowest = misplaced(human, plan, q, times)
        assert farthest < 0.010 and lowest > -0.010
        # nothing bends beyond what it can, and the pelvis is lower than in standing
        assert np.all((q[:, 6:] >= human.limits[0]) & (q[:, 6:] <= human.limits[1]))
        standing = human.to_coordinates(human.standing()[None])[1][0, 4]
        assert np.all((q[:, 4] < standing) & (q[:, 4] > 0.85 * standing))


@pytest.mark.parametrize("joints", ["43", "58", "66"])
def test_every_joint_set_walks(joints):
    human = person(feet=None, joints=joints)
    p = gait_parameters(human, 1.2)
    plan = walk_plan(human, p, steps=2)
    times = nodes_of(plan, 10.0)
    farthest, lowest = misplaced(human, plan, walking_guess(human, plan, p, times), times)
    assert farthest < 0.010 and lowest > -0.010


@pytest.mark.parametrize(
    ("speed", "options"),
    [
        (1.0, {"steps": 4, "turn": 1.0}),
        (1.0, {"steps": 6, "turn": -3.0, "first": "l"}),
        (0.5, {"steps": 4, "heights": (0.15, 0.3, 0.45, 0.45)}),
        (1.2, {"steps": 3, "start": "walking", "stop": "walking"}),
        (1.2, {"steps": 2, "start": "walking"}),
    ],
)
def test_feet_are_on_their_footprints_elsewhere(speed, options):
    human = person()
    p = gait_parameters(human, speed)
    plan = walk_plan(human, p, **options)
    times = nodes_of(plan)
    q = walking_guess(human, plan, p, times)
    farthest, lowest = misplaced(human, plan, q, times)
    assert farthest < 0.010 and lowest > -0.010
    if "turn" in options:  # by more than half a turn, and on
        assert q[-1, 2] - q[0, 2] == pytest.approx(options["turn"], abs=1e-6)


@pytest.mark.parametrize("step", [0.3, 0.75])
@pytest.mark.parametrize("speed", [0.4, 1.6])
def test_any_step_at_any_speed(speed, step):
    human = person()
    p = gait_parameters(human, speed, step_length=step)
    plan = walk_plan(human, p, steps=3)
    times = nodes_of(plan, 10.0)
    farthest, lowest = misplaced(human, plan, walking_guess(human, plan, p, times), times)
    assert farthest < 0.010 and lowest > -0.010


def test_begins_and_ends_at_rest_on_both_feet():
    human = person()
    p = gait_parameters(human, 1.3)
    plan = walk_plan(human, p, steps=4)
    T = plan.duration
    q = walking_guess(human, plan, p, np.array([0.0, 0.02, 0.1, T - 0.1, T - 0.02, T]))
    assert np.abs(q[[0, 5]] - q[[1, 4]]).max() < 2e-3  # [rad, m]
    travelled = q[5] - q[0]
    assert travelled[3] == pytest.approx(3 * p.step_length, abs=1e-9)
    assert np.abs(np.delete(travelled, 3)).max() < 0.01
    # both ends are symmetric postures, up to the sway and the wait for the other foot
    left = [6 + human.hinge(n) for n in human.coordinates if n.endswith("_l")]
    right = [6 + human.hinge(n[:-1] + "r") for n in human.coordinates if n.endswith("_l")]
    assert np.abs(q[0, left] - q[0, right]).max() < 1e-6


def mirror(human, step):
    """How a symmetric walk goes on after half a stride, from what a mirror does."""
    names = PELVIS + human.coordinates
    other = {"_r": "_l", "_l": "_r"}
    source = [names.index(n[:-2] + other[n[-2:]]) if n[-2:] in other else i
              for i, n in enumerate(names)]  # fmt: skip
    turned = [n[-2:] not in other and n.endswith(("list", "bending", "rotation", "tz"))
              for n in names]  # fmt: skip
    return PeriodicClosure(
        np.array(source),
        np.where(turned, -1.0, 1.0),
        np.array([step if n == "pelvis_tx" else 0.0 for n in names]),
        np.zeros(0, int),
        np.zeros(0),
    )


@pytest.mark.parametrize("feet", FEET)
def test_periodic_guess_goes_on_as_its_mirror_image(feet):
    human = person(feet=feet)
    p = gait_parameters(human, 1.3)
    plan = periodic_walk_plan(human, p)
    k = mirror(human, plan.advance)
    times = np.linspace(-0.3 * plan.duration, plan.duration, 23)
    once = walking_guess(human, plan, p, times)
    later = walking_guess(human, plan, p, times + plan.duration)
    np.testing.assert_allclose(later, k.sign * once[:, k.source] + k.shift, atol=2e-3)


def test_resembles_the_published_walk():
    human = person()
    p = gait_parameters(human, 1.3)
    times = np.linspace(0, p.stride_time, 101)
    q = walking_guess(human, periodic_walk_plan(human, p), p, times)
    book = textbook_gait(1.3, p.leg_length, rate=100 / p.stride_time, cycles=1).coordinates
    for name, least in (("hip_flexion_r", 0.9), ("knee_angle_r", 0.8), ("ankle_angle_r", 0.6)):
        ours = np.rad2deg(q[:100, 6 + human.hinge(name)])
        theirs = np.rad2deg(book[name])  # of steps of another length: compared by the cycle
        theirs = np.interp(np.arange(100) / 100, np.linspace(0, 1, len(theirs)), theirs)
        assert np.corrcoef(ours, theirs)[0, 1] > least, name
        assert np.sqrt(np.mean((ours - theirs) ** 2)) < 15.0, name
    # the pelvis sways to the foot that stands, and goes up over it
    middle = 0.3 * p.stride_time  # of the right foot's stance
    at = walking_guess(human, periodic_walk_plan(human, p), p, np.array([0.0, middle]))
    assert at[1, 5] - at[0, 5] > 0.01 and at[1, 4] - at[0, 4] > 0.01


def test_a_leg_reaches_what_it_can():
    human = person(feet="multi-segment", joints="66")
    rng = np.random.default_rng(0)
    for side in "rl":
        leg = Leg(human, side)
        hinges = np.tile(human.standing()[7:], (20, 1))
        expected = hinges.copy()
        low, high = leg.limits
        expected[:, leg.columns] = np.clip(rng.uniform(-0.4, 0.8, (20, 6)), low, high)
        pelvis, upright = rng.normal(size=(20, 3)), np.tile(np.eye(3), (20, 1, 1))
        ankle, foot, J = leg.forward(pelvis, upright, expected)
        # the chain is MuJoCo's
        data = mujoco.MjData(human.model)
        data.qpos[:3], data.qpos[7:] = pelvis[0], expected[0]
        data.qpos[3:7] = [1, 0, 0, 0]
        mujoco.mj_kinematics(human.model, data)
        b = human.body(f"foot_{side}")
        np.testing.assert_allclose(ankle[0], data.xpos[b], atol=1e-12)
        np.testing.assert_allclose(foot[0], data.xmat[b].reshape(3, 3), atol=1e-12)
        for i, column in enumerate(leg.columns):
            moved = expected.copy()
            moved[:, column] += 1e-6
            x, R, _ = leg.forward(pelvis, upright, moved)
            np.testing.assert_allclose((x - ankle) / 1e-6, J[:, :3, i], atol=1e-5)
            spin = (R - foot) / 1e-6 @ foot.swapaxes(1, 2)
            np.testing.assert_allclose(spin[:, [2, 0, 1], [1, 2, 0]], J[:, 3:, i], atol=1e-5)
        found = leg.reach(pelvis, upright, hinges, ankle, foot)
        x, R, _ = leg.forward(pelvis, upright, found)
        assert np.abs(x - ankle).max() < 1e-5 and np.abs(R - foot).max() < 1e-4


def test_crude_guess_is_a_straight_line():
    human = person()
    p = gait_parameters(human, 1.0)
    plan = walk_plan(human, p, steps=4)
    times = nodes_of(plan)
    q = crude_guess(human, plan, times)
    assert (
        np.abs(np.diff(q[:, 3]) / np.diff(times) - 3 * p.step_length / plan.duration).max() < 1e-9
    )
    assert np.ptp(np.delete(q, 3, axis=1), axis=0).max() < 1e-9
    assert np.rad2deg(q[0, 6 + human.hinge("knee_angle_l")]) == pytest.approx(17.0)
    places = site_places(human, q[:1])[0]
    assert np.abs(places[:, 2]).max() < 0.006  # soles are on the ground, nearly flat
    turning = walk_plan(human, p, steps=8, turn=2.0)
    ends = crude_guess(human, turning, np.array([0.0, turning.duration]))
    assert ends[1, 2] - ends[0, 2] == pytest.approx(2.0)


def test_noise_has_the_given_size_and_is_periodic_with_the_motion():
    human = person()
    c = np.zeros((80, 6 + len(human.coordinates)))
    noise = with_noise(c, seed=3, size=0.1)
    angles = np.delete(noise, [3, 4, 5], axis=1)
    assert np.sqrt(np.mean(angles**2)) == pytest.approx(0.1, rel=0.2)
    assert np.sqrt(np.mean(noise[:, 3:6] ** 2)) < 0.1
    # smooth: neighbours differ by far less than the noise itself
    assert np.sqrt(np.mean(np.diff(angles, axis=0) ** 2)) < 0.02
    np.testing.assert_array_equal(noise, with_noise(c, seed=3, size=0.1))
    assert np.abs(noise - with_noise(c, seed=4, size=0.1)).max() > 0.05
    k = mirror(human, 0.0)
    noise = with_noise(c, seed=3, size=0.1, closure=k)
    assert np.sqrt(np.mean(np.delete(noise, [3, 4, 5], axis=1) ** 2)) == pytest.approx(0.1, rel=0.3)
    after = k.sign * noise[:1, k.source]
    assert np.abs(after - noise[-1:]).max() < 3 * np.abs(np.diff(noise, axis=0)).max()


def test_what_is_no_walk_is_refused():
    human = person()
    p = gait_parameters(human, 1.0)
    plan = walk_plan(human, p, steps=3)
    with pytest.raises(ParameterError, match="at least one time"):
        walking_guess(human, plan, p, np.zeros(0))
    one = ContactPlan(1.0, tuple(s for s in plan.stances if s.footprint.side == "r"))
    with pytest.raises(ParameterError, match="both feet on the ground"):
        walking_guess(human, one, p, np.array([0.5]))
    with pytest.raises(ParameterError, match="the left foot has no stance"):
        crude_guess(human, one, np.array([0.5]))
    with pytest.raises(ParameterError, match="zero or more"):
        with_noise(np.zeros((3, 8)), seed=0, size=-1.0)
