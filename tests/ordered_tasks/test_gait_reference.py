"""Reference of a recorded gait: paths, contacts and postures over stationary ground."""

import numpy as np
import pytest

from plantigrade.constants import SIDES
from plantigrade.kinematics.state import BodyState
from plantigrade.kinematics.textbook_recording import textbook_walk
from plantigrade.ordered_tasks import reference_of
from tests.models.presets import person
from tests.ordered_tasks.walks import reference


def test_paths_are_those_of_the_recorded_motion():
    known = reference()
    for t in known.motion.time[10:-10:17]:
        state = BodyState(known.human, known.at(float(t)), known.velocity_at(float(t)))
        com = known.com(float(t))
        np.testing.assert_allclose(com[0], state.com, atol=1e-6)
        np.testing.assert_allclose(com[1], state.com_jacobian @ state.qvel, atol=0.02)
        for side in SIDES:
            point = known.heel_point[side]
            path = known.heel[side](float(t))
            np.testing.assert_allclose(path[0], state.position(point)[0], atol=1e-6)
            np.testing.assert_allclose(path[1], state.velocity(point)[0], atol=0.05)


def test_the_motion_lasts_from_the_first_event_to_the_last():
    known = reference()
    assert (known.start, known.stop) == (known.events[0].time, known.events[-1].time)
    assert known.phases[0].start == known.start and known.phases[-1].stop == known.stop


def test_contacts_lie_within_the_stances_of_their_feet():
    known = reference()
    for side in SIDES:
        strikes = [e.time for e in known.events if (e.side, e.kind) == (side, "heel_strike")]
        offs = [e.time for e in known.events if (e.side, e.kind) == (side, "toe_off")]
        for contact in (c for c in known.contacts if c.side == side):
            assert contact.start < contact.stop
            for phase in known.phases:  # a swinging foot touches nothing
                if phase.kind == "single" and phase.swing == side:
                    assert contact.stop <= phase.start + 1e-9 or contact.start >= phase.stop - 1e-9
        for strike in strikes:
            assert any(
                c.start == pytest.approx(strike) and (c.side, c.region) == (side, "heel")
                for c in known.contacts
            )
        for off in offs:
            assert any(
                c.stop == pytest.approx(off) and (c.side, c.region) == (side, "toes")
                for c in known.contacts
            )


def test_a_foot_rolls_from_heel_to_toes():
    known = reference()
    for side in SIDES:
        strike = next(e.time for e in known.events if (e.side, e.kind) == (side, "heel_strike"))
        stance = {
            c.region: c for c in reversed(known.contacts) if c.side == side and c.start >= strike
        }
        assert stance["heel"].start < stance["ball"].start
        assert stance["heel"].stop < stance["ball"].stop <= stance["toes"].stop


def test_configurations_between_frames_are_configurations():
    known = reference()
    times = np.linspace(known.start, known.stop, 57)
    qpos = known.at(times)
    np.testing.assert_allclose(np.linalg.norm(qpos[:, 3:7], axis=1), 1.0, atol=1e-12)
    np.testing.assert_array_equal(known.at(float(times[20])), qpos[20])
    frame = 31
    np.testing.assert_allclose(
        known.at(float(known.motion.time[frame])), known.motion.qpos[frame], atol=1e-9
    )


def test_velocities_are_the_rates_of_configurations():
    known, h = reference(), 1e-3
    for t in np.linspace(known.start + 0.1, known.stop - 0.1, 9):
        ahead = BodyState(known.human, known.at(float(t + h)))
        step = ahead.difference(known.at(float(t - h))) / (2 * h)
        assert np.sqrt(np.mean((known.velocity_at(float(t)) - step) ** 2)) < 0.2


def test_a_walk_on_a_treadmill_gives_the_reference_of_the_walk_over_ground():
    walk = textbook_walk(person("42", "two-segment"), cycles=2)
    belt = np.zeros((len(walk.time), 3))
    belt[:, 0] = -1.25 * (walk.time - walk.time[0])
    on_belt = walk.qpos.copy()
    on_belt[:, :3] += belt
    ours = reference_of(walk.human, walk.time, on_belt, walk.events, ground=belt)
    known = reference()
    assert ours.contacts == known.contacts
    for t in np.linspace(known.start, known.stop, 20):
        np.testing.assert_allclose(ours.com(float(t)), known.com(float(t)), atol=1e-6)


def test_the_recorded_motion_is_not_modified():
    walk = textbook_walk(person("42", "two-segment"), cycles=1)
    before = walk.qpos.copy()
    reference_of(walk.human, walk.time, walk.qpos, walk.events, ground=np.ones((len(before), 3)))
    np.testing.assert_array_equal(walk.qpos, before)


def test_the_sign_of_quaternions_does_not_matter():
    walk = textbook_walk(person("42", "two-segment"), cycles=2)
    flipped = walk.qpos.copy()
    flipped[60:, 3:7] *= -1
    ours, known = reference_of(walk.human, walk.time, flipped, walk.events), reference()
    np.testing.assert_allclose(ours.motion.qvel, known.motion.qvel, atol=1e-9)
    np.testing.assert_allclose(
        np.abs(ours.motion.qpos[:, 3]), np.abs(known.motion.qpos[:, 3]), atol=1e-9
    )
