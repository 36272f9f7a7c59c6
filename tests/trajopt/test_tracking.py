"""A motion that is tracked: the textbook walk, whose feet and angles are known; and a recording."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.intervals import ContactInterval as Contact
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.ball_joints import BallJoint
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.ground_forces import estimate_forces
from plantigrade.dynamics.loading import EARLY_LOAD
from plantigrade.errors import ParameterError
from plantigrade.kinematics.contacts import foot_flat_time
from plantigrade.kinematics.shoulders import arms_of
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.kinematics.sole_paths import sole_paths as contact_points
from plantigrade.kinematics.textbook_recording import textbook_walk
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.filters import interpolate, runs
from plantigrade.trajopt import ContactBody, ProblemBuilder, make_task, synthesize
from plantigrade.trajopt.tasks.recorded_shoulders import ShoulderPath
from plantigrade.trajopt.tasks.recorded_stances import TOE_ROLL_TIME
from plantigrade.trajopt.tasks.tracking import GRID, contacts_of, grounded, recorded_stances, track
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.terms.solid import LEGS, ROW_SCALE, SolidLimbs
from plantigrade.trajopt.terms.tracking import PartLegs
from plantigrade.workflows.track import MAX_ERRORS

pytestmark = pytest.mark.solver

SPEED = 1.25


@pytest.fixture(scope="module")
def human():
    """A person of the joint set recordings are fitted with."""
    return Human.create(1.75, 70.0, joints="42")


@pytest.fixture(scope="module")
def walk(human):
    """Two strides of the textbook walk as a motion with its gait events."""
    book = textbook_walk(human, speed=SPEED, cycles=2)
    smooth = differentiate(human, book.time, book.qpos, 6.0)
    return Motion(book.time, smooth.qpos, smooth.qvel, human.joint_names, smooth.qacc, book.events)


@pytest.fixture(scope="module")
def tracked(human, walk):
    """One stride, tracked."""
    strikes = [e.time for e in walk.events if e.kind == "heel_strike" and e.side == "l"]
    task = track(human, walk, start=strikes[0] - 0.1, stop=strikes[0] + 1.1)
    return synthesize(ContactBody(human, foot_sites(human)), task, refinements=0), strikes[0] - 0.1


def test_stances_are_those_of_the_events(human, walk):
    """They begin a little before heel strikes, as loads do; toes move already at toe off."""
    stances = recorded_stances(human, walk, contacts_of(human, walk), 0.0, float(walk.time[-1]))
    for e in walk.events:
        struck = e.kind == "heel_strike"
        times = [
            s.heel_strike if struck else s.toe_off for s in stances if s.footprint.side == e.side
        ]
        if 0.1 < e.time < walk.time[-1] - 0.2:
            expected = e.time - EARLY_LOAD if struck else e.time - TOE_ROLL_TIME
            assert np.abs(np.array(times) - expected).min() <= 0.5 * GRID + 1e-9
    for s in stances:
        assert s.footprint.position[2] == 0.0
        assert np.all(np.diff(s.times) > 0)


def test_the_forefoot_is_down_when_the_recorded_one_is(human, walk):
    """It was put down 20 to 40 ms after heel strike, from 20 mm above the ground."""
    points = contact_points(human, walk.qpos)
    stances = recorded_stances(human, walk, contacts_of(human, walk), 0.0, float(walk.time[-1]))
    for s in stances:
        if s.heel_strike < 0.1 or s.foot_flat > walk.time[-1] - 0.1:
            continue
        k = int(np.searchsorted(walk.time, s.foot_flat + 0.5 * GRID))
        side = s.footprint.side
        front = [i for region in ("ball", "toes") for i in points.of(side, region)]
        assert points.position[k, front, 2].min() < 0.006  # [m]
        assert s.foot_flat - s.heel_strike >= 3 * GRID - 1e-9


def test_ankles_follow_the_book(human, walk, tracked):
    """Their range was 47 to 62 degrees for 29 to 35."""
    s, begin = tracked
    m = s.sample(s.times(4))
    inside = (m.time > 0.1) & (m.time < m.time[-1] - 0.1)
    for side in "rl":
        ours = np.rad2deg(m.q[inside, 6 + human.coordinates.index(f"ankle_angle_{side}")])
        book = np.interp(m.time[inside] + begin, walk.time, walk[f"ankle_angle_{side}"])
        book = np.rad2deg(book)
        assert np.sqrt(np.mean((ours - book) ** 2)) < 2.5
        assert abs(np.ptp(ours) - np.ptp(book)) < 5.0


def test_feet_are_flat_when_the_recorded_ones_are(human, walk, tracked):
    """They were flat 15 to 45 ms too early."""
    s, begin = tracked
    m = s.sample(s.times(4))
    compared = 0
    for side in "rl":
        strikes = [
            e.time
            for e in walk.events
            if e.kind == "heel_strike" and e.side == side
            if m.time[0] < e.time - begin < m.time[-1] - 0.3
        ]
        ours, theirs = (
            foot_flat_time(time, forefoot_height(human, qpos, side), strikes)
            for time, qpos in ((m.time + begin, m.qpos), (walk.time, walk.qpos))
        )
        if strikes:
            compared += 1
            assert abs(ours - theirs) < 0.015  # [s]
    assert compared


def forefoot_height(human, qpos, side):
    """Return the height of the lowest point of ball and toes [m]."""
    points = contact_points(human, qpos)
    front = [i for region in ("ball", "toes") for i in points.of(side, region)]
    return points.position[:, front, 2].min(axis=1)


def test_footprints_are_a_stride_apart(human, walk):
    stances = recorded_stances(human, walk, contacts_of(human, walk), 0.0, float(walk.time[-1]))
    right = [s for s in stances if s.footprint.side == "r"]
    way = right[1].footprint.position[0] - right[0].footprint.position[0]
    assert way == pytest.approx(SPEED * (right[1].toe_off - right[0].toe_off), rel=0.05)


def test_sum_of_forces_is_newtons(human, tracked):
    s, _ = tracked
    assert s.success, s.status
    m = s.sample(s.problem.nodes)
    asked = centroid(human, m.qpos, m.qvel, m.qacc).force
    assert asked is not None
    np.testing.assert_allclose(m.force.sum(axis=1), asked, atol=1e-3 * s.body.weight)


def test_forces_keep_near_the_estimated_ones(human, walk, tracked):
    """In most of the stance the load on each foot is within its 90 % band, or nearly."""
    s, begin = tracked
    found = estimate_forces(human, walk)
    weight = s.body.weight
    for k, side in enumerate("rl"):
        m = s.sample(s.problem.nodes)
        own = [i for i, site in enumerate(s.body.sites) if site.side == side]
        load = m.force[:, own].sum(axis=1) / weight
        expected = interpolate(m.time + begin, walk.time, found.forces.force[:, k] / weight)
        band = interpolate(m.time + begin, walk.time, found.force_band[:, k] / weight)
        stands = expected[:, 2] > 0.3
        apart = np.abs(load - expected)[stands]
        assert np.mean(apart <= band[stands] + 0.03, axis=0).min() > 0.7
        assert np.corrcoef(load[stands, 0], expected[stands, 0])[0, 1] > 0.97


def test_no_joint_is_overloaded_and_half_the_strength_would_not_do(tracked):
    s, _ = tracked
    times, use = s.overloaded()
    assert len(times) == len(use) and use.max() < 1.1
    weaker = tuple(
        replace(t, strength=0.5, speed=1.0) if isinstance(t, Limits) else t for t in s.task.terms
    )
    half = replace(s, task=replace(s.task, terms=weaker))
    _, more = half.overloaded()
    assert more.max() >= 1.5 * use.max()
    speed = np.abs(s.sample(times).qvel[:, 6:]).max(axis=1)
    assert np.all(more >= speed - 1e-9)  # of 1 rad/s


def test_flat_feet_stand_still_on_the_ground(human, tracked):
    s, _ = tracked
    m = s.sample(s.times(4))
    points = contact_points(human, m.qpos)
    assert points.position[..., 2].min() > -2e-3  # [m]
    names = [name for name, _, _ in human.contact_points]
    for k, site in enumerate(s.body.sites):
        if site.part != "sole":
            continue
        path = points.position[:, next(i for i, n in enumerate(names) if n.endswith(site.name))]
        for run in runs(m.standing[:, k]):
            assert np.ptp(path[run], axis=0).max() < 2e-3  # [m]


def test_forces_push_within_the_friction_cone_where_feet_stand(tracked):
    s, _ = tracked
    m = s.sample(s.problem.nodes)
    assert m.force[..., 2].min() > -1e-3
    sideways = np.abs(m.force[..., :2]).max(axis=2)
    assert np.all(sideways <= 0.8 / np.sqrt(2) * m.force[..., 2] + 1e-2)
    assert np.all(np.linalg.norm(m.force[~m.standing], axis=1) < 1e-6)


def test_impulse_carries_the_body_and_stays_near_the_book(human, walk, tracked):
    """Over a stride, the mean vertical force is body weight: the body is as fast as before."""
    s, begin = tracked
    m = s.sample(s.times(4))
    vertical = m.force[..., 2].sum(axis=1) / s.body.weight
    inside = (m.time >= 0.1) & (m.time <= 0.1 + 1.08)
    assert np.mean(vertical[inside]) == pytest.approx(1.0, abs=0.05)
    assert vertical.min() > 0.3 and vertical.max() < 1.7  # nobody flies, nobody lands
    book = human.to_coordinates(walk.qpos)[1]
    at = np.stack([np.interp(m.time + begin, walk.time, x) for x in book.T], axis=1)
    apart = m.q - at
    assert np.sqrt((apart[:, 3:6] ** 2).mean()) < 0.015  # [m]
    assert np.rad2deg(np.sqrt((apart[:, 6:] ** 2).mean())) < 5.0


def test_soles_of_ones_own_are_flat_on_the_ground(human):
    """A foot recorded 4 degrees toes up stands with all its places on the ground."""
    heel = {n: 0.0 for n, _, _ in human.contact_points}
    own = human.with_soles({n: (-0.01 if "heel" not in n else 0.0) for n in heel})
    body = foot_sites(own)
    places = flat_sites(own, body, "r")
    plain = flat_sites(human, foot_sites(human), "r")
    height = [p[2] for p in places.values()]
    assert np.ptp(height) < 2e-3
    for name in places:
        assert np.linalg.norm(places[name][:2] - plain[name][:2]) < 0.02


def test_feet_that_hover_get_soles(human, walk):
    high = replace(walk, qpos=walk.qpos + np.array([0, 0, 0.02] + [0] * (human.model.nq - 3)))
    assert lowest(human, high.qpos).min() > 0.01
    own, motion, lift = grounded(human, high)
    assert lift == 0.0 and motion is high
    assert abs(np.median(lowest(own, motion.qpos))) < 0.005


def test_feet_that_sink_are_lifted(human, walk):
    """Where soles would have to be thinner than the foot, the motion is lifted onto it."""
    low = replace(walk, qpos=walk.qpos - np.array([0, 0, 0.02] + [0] * (human.model.nq - 3)))
    own, motion, lift = grounded(human, low)
    assert lift == pytest.approx(0.02, abs=0.006)
    np.testing.assert_allclose(motion.qpos[:, 2] - low.qpos[:, 2], lift)
    assert abs(np.median(lowest(own, motion.qpos))) < 0.005


def test_a_toe_that_touches_keeps_its_heel_up(human, walk):
    """The heel of a person who balances on one leg had to come down where the toes touched."""
    points = contact_points(human, walk.qpos)
    heel = points.position[:, points.of("r", "heel"), 2].min(axis=1)
    high = np.flatnonzero(
        (heel - forefoot_height(human, walk.qpos, "r") > 0.05) & (walk.time > 0.2)
    )
    touch = float(walk.time[high[0]])
    contacts = [Contact("r", part, touch, touch + 0.5) for part in ("ball", "toes")]
    (stance,) = recorded_stances(human, walk, contacts, 0.0, touch + 0.8)
    assert stance.toes_first and stance.toe_off - stance.heel_strike > 0.4
    start, stop = stance.interval("heel")
    assert start == stop


@pytest.mark.parametrize("away", [2.0, 5.0])
def test_an_arm_passes_the_singularity_of_its_shoulder_as_fast_as_a_joint_can(human, walk, away):
    """Beside it, two angles turn by half a turn in 40 ms while the arm moves by a few degrees."""
    (joint, *_), angles = arms_of(human), np.zeros((len(walk.time), 3))
    turn = np.pi / (1.0 + np.exp(-(walk.time - walk.time.mean()) / 0.01))
    ball = BallJoint("r", joint)
    angles[:, 1] = np.deg2rad(away - 90.0)
    paths = [angles + np.outer(turn, (1.0, 0.0, sign)) for sign in (1.0, -1.0)]
    moved = [np.linalg.norm(ball.between(x[:1], x[-1:])) for x in paths]
    fast = paths[int(np.argmin(moved))]
    assert min(moved) < np.deg2rad(2.1 * away)
    qpos, k = walk.qpos.copy(), 7 + np.array(joint)
    qpos[:, k] = fast
    found = ShoulderPath().of(human, replace(walk, qpos=qpos))[:, k]
    assert np.abs(np.gradient(fast, walk.time, axis=0)).max() > 40.0
    assert np.abs(np.gradient(found, walk.time, axis=0)).max() < 15.0  # [rad/s]
    off = np.linalg.norm(ball.between(fast, found), axis=1)
    assert off.max() < np.deg2rad(away)


def test_legs_in_each_other_are_drawn_apart_and_no_others(human):
    """Recorded legs that are in each other may be so; those apart have to keep their distance."""
    task = make_task("squat", human)
    given = ContactBody.for_plan(human, task.plan)
    times = np.array([0.0, task.plan.duration])
    q = given.symbolic.from_mujoco(human.standing()[None], *np.zeros((2, 1, human.model.nv)))[0]
    q = np.repeat(q, 2, axis=0)
    crossed = q.copy()
    for side in "rl":
        crossed[:, 6 + human.hinge(f"hip_adduction_{side}")] = 0.25
    rows = {}
    for name, path in (("apart", q), ("crossed", crossed)):
        b = ProblemBuilder(given, task.plan, task.nodes())
        PartLegs(times, path).add_to(b)
        rows[name] = b.family(LEGS)
    least = ROW_SCALE * SolidLimbs().margin
    assert rows["apart"].lower.min() > least - 0.1 and not rows["apart"].weight.any()
    assert rows["crossed"].lower.max() < 0.0
    assert rows["crossed"].weight.min() > 0.0
    np.testing.assert_allclose(rows["crossed"].target, least)


def test_what_never_touches_is_refused(human, walk):
    with pytest.raises(ParameterError, match="at least four"):
        track(human, walk, start=5.0, stop=4.0)
    one = Contact("r", "toes", 0.5, 0.6)
    assert recorded_stances(human, walk, [one], 0.0, 1.0) == ()


@pytest.mark.slow
def test_a_recording_gives_ground_reactions(data):
    """The vertical forces of a recorded walk come out within 0.08 body weights."""
    from plantigrade.workflows.fit import fit_trial
    from plantigrade.workflows.synthesize import Origin
    from plantigrade.workflows.track import TrackSettings, run_of, track_trial

    settings = TrackSettings(start=0.62, stop=1.41, refinements=0)
    path = data / "opensim/gait2392_subject01/subject01_walk1.trc"
    recording, trial = fit_trial(path, settings)
    found = track_trial(trial, settings)
    c = found.against_plates()
    assert found.solution.success
    assert c.vertical_rmse <= 0.08
    assert c.vertical_r > 0.98
    angle, way = found.moved()
    assert np.rad2deg(angle) < 4.0 and way < 0.02
    made = run_of(recording, found, settings, Origin())
    assert made.kind == "track" and made.record.clock == found.begin
    assert "subject01_walk1_grf.mot" in made.provenance.source_files  # all that was read
    assert made.provenance.settings["cutoff"] == settings.cutoff
    assert set(found.walk.notes) <= set(made.record.notes)
    recorded, ours = made.record.references["recorded"], made.record.motion
    inside = (recorded.time > 0.2) & (recorded.time < 0.8)
    theirs = recorded["knee_angle_r"][inside]
    apart = np.interp(recorded.time[inside], ours.time, ours["knee_angle_r"]) - theirs
    assert np.abs(apart).max() < 0.2  # one clock [rad]
    assert not found.estimate.measured.any()  # plates are withheld
    held = found.against_recording
    for side in "rl":
        assert (
            held.rmse[f"ankle_angle_{side}"] < 2.5
            and abs(held.rom_error[f"ankle_angle_{side}"]) < 5
        )
    assert made.figures["rmse_max_deg"] <= made.figures["rmse_max_limit_deg"]
    assert not found.violations  # unrefined, the check may still find something
    assert c.forward_r > 0.98 and c.backward_m < 0.02  # [m]
    assert min(c.moment_r.values()) > 0.8
    beside = found.estimate_against_plates()
    assert made.figures["estimated_forward_force_correlation"] == beside.forward_r > 0.98
    measured = made.record.signals["measured.force"]
    assert measured.shape == (ours.n_frames, 2, 3) and np.nanmax(measured[..., 2]) > 700.0
    assert made.figures["vertical_force_rmse_bw"] == pytest.approx(c.vertical_rmse)


def test_a_time_outside_of_the_recording_is_refused(data):
    from plantigrade.workflows.fit import fit_trial
    from plantigrade.workflows.track import TrackSettings, track_trial

    settings = TrackSettings(start=50.0, stop=60.0)
    _, trial = fit_trial(data / "cmu_asfamc/07_01.amc", settings)
    with pytest.raises(ParameterError, match=r"nothing is recorded from 50 to 60 s: .* from 0 to"):
        track_trial(trial, settings)


def test_angles_far_from_the_recording_are_not_ok(human, walk, tracked):
    """A tracked motion whose ankle was 30 degrees off in range was ok."""
    from plantigrade.workflows.track import Tracked

    s, begin = tracked
    made = Tracked(None, human, walk, 0.0, None, s, begin, begin + 0.1, begin + 1.1, 0.0)
    assert made.violations == ""
    assert made.against_recording.foot_flat["r"][0] > 0.05  # [s]
    qpos = walk.qpos.copy()
    column = 7 + human.coordinates.index("ankle_angle_l")
    qpos[:, column] = qpos[:, column].mean()  # a stiff ankle
    far = replace(made, motion=replace(walk, qpos=qpos))
    assert "ankle_angle_l" in far.violations and "s into the recording" in far.violations
    assert f"at most {MAX_ERRORS['rom_error_max_deg']:g}° allowed" in far.violations


def test_feet_of_a_recorded_runner_stand_as_long_as_plates_say(data):
    """The forefoot was down half a contact too late: its level was that of midstance in walking."""
    from plantigrade.analyze.recorded_walk import RecordedWalk
    from plantigrade.workflows.fit import fit_trial

    trial = fit_trial(data / "opensim/running_subject04/run300.trc")[1]
    walk = RecordedWalk.of(trial)
    human, motion, _ = grounded(walk.human, walk.over_ground())
    task = track(human, motion, forces=estimate_forces(human, motion), start=0.0, stop=3.0)
    first, measured = float(motion.time[0]), walk.measured
    assert measured is not None and measured.contact_force is not None
    for side in "rl":
        own = [s for s in task.plan.stances if s.footprint.side == side]
        feet = [k for k, site in enumerate(measured.sites) if site.side == side]
        load = measured.contact_force[:, feet, 2].sum(axis=1) > 50.0  # [N]
        loaded = motion.time[[[r.start, r.stop - 1] for r in runs(load)]] - first
        stood = [s for s in own if s.heel_strike > 0 and s.toe_off < task.plan.duration]
        assert len(stood) == 2
        for stance in stood:
            on, off = loaded[np.argmin(np.abs(loaded[:, 0] - stance.heel_strike))]
            assert stance.heel_strike == pytest.approx(on, abs=0.03)
            assert stance.toe_off == pytest.approx(off, abs=0.03)
            assert stance.foot_flat - stance.heel_strike < 0.3 * (off - on)
            assert not stance.toes_first


def test_a_jump_lands_with_the_toes_and_heels_follow(data):
    from plantigrade.analyze.recorded_walk import RecordedWalk
    from plantigrade.workflows.fit import fit_trial

    walk = RecordedWalk.of(fit_trial(data / "cmu_bvh/13_11.bvh")[1])
    human, motion, _ = grounded(walk.human, walk.over_ground())
    *pushed, one, two = track(human, motion).plan.stances
    assert (
        {s.footprint.side for s in pushed} == {one.footprint.side, two.footprint.side} == set("rl")
    )
    assert all(s.toe_off < one.heel_strike < two.foot_flat for s in pushed)
    assert one.toes_first and two.toes_first
    forward = one.footprint.position[0] - pushed[0].footprint.position[0]
    assert 1.0 < forward < 1.5  # [m]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "degrees", "peak"),
    [("opensim/running_subject04/run300.trc", 4.0, 0.5), ("cmu_bvh/13_11.bvh", 3.0, np.inf)],
)
def test_recorded_flights_pass_the_check(data, path, degrees, peak):
    """A run and a jump are tracked; forces of the run are near those of the plates."""
    from plantigrade.workflows.fit import fit_trial
    from plantigrade.workflows.synthesize import Origin
    from plantigrade.workflows.track import TrackSettings, run_of, track_trial

    settings = TrackSettings(stop=1.9 if peak < np.inf else 2.9)
    recording, trial = fit_trial(data / path, settings)
    found = track_trial(trial, settings)
    run = run_of(recording, found, settings, Origin())
    assert run.ok, run.status
    assert run.figures["rmse_max_deg"] < degrees
    if found.walk.measured is not None:
        assert run.figures["vertical_force_rmse_bw"] < 0.35
        weight = found.human.mass * found.human.gravity
        assert found.walk.measured.contact_force is not None
        measured = np.nanmax(found.walk.measured.contact_force[..., 2]) / weight
        assert abs(run.figures["ground_force_max_bw"] - measured) < peak


@pytest.mark.slow
def test_a_drop_jump_with_swinging_arms_passes_the_check(data):
    """From when the feet leave the box; the arms go up sideways, past the singularity."""
    from plantigrade.workflows.fit import fit_trial
    from plantigrade.workflows.synthesize import Origin
    from plantigrade.workflows.track import TrackSettings, run_of, track_trial

    settings = TrackSettings()
    recording, trial = fit_trial(data / "opensim/opencap_subject4/DJ1.trc", settings, boxes=False)
    found = track_trial(trial, settings)
    assert found.start == pytest.approx(1.15, abs=0.1)
    run = run_of(recording, found, settings, Origin())
    assert run.ok, run.status


@pytest.mark.slow
def test_a_recorded_rise_from_a_chair_passes_the_check(data):
    """The seat carries until the person rises, the feet carry after it, and nothing is broken."""
    from plantigrade.analyze.check import check
    from plantigrade.workflows.fit import fit_trial
    from plantigrade.workflows.track import TrackSettings, track_trial

    settings = TrackSettings(start=2.9, stop=4.2)
    _, trial = fit_trial(data / "opensim/opencap_subject4/STS1.trc", settings)
    found = track_trial(trial, settings)
    record = found.record()
    verdict = check(record)
    assert verdict.ok, "; ".join(verdict.sentences())
    time, weight = record.motion.time + record.clock, record.weight
    assert record.contact_force is not None
    load = record.contact_force[..., 2] / weight
    seat = [not site.side for site in record.sites]
    assert sum(seat) == 2
    seated, stood = time < 3.2, time > 3.7
    assert load[seated][:, seat].sum(axis=1).mean() > 0.7
    assert load[stood][:, seat].max() < 1e-6
    plates = found.walk.measured
    assert plates is not None
    for side in "rl":
        theirs = plates.foot(side).force[:, 2] / weight
        own = [site.side == side for site in record.sites]
        expected = np.interp(time[stood], plates.motion.time, theirs)
        assert np.abs(load[stood][:, own].sum(axis=1) - expected).mean() < 0.12
