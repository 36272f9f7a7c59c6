"""The bones of multi-segment feet in the viewer page, seen by an X-ray."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.models import Human
from plantigrade.pages.scene import build_scene
from plantigrade.pages.viewer import viewer_html
from plantigrade.record import Record
from plantigrade.skin import foot_bones
from tests.conftest import open_browser
from tests.textbook import walk_record

READY = "document.body.dataset.ready === '1'"
BONES = 32  # of both feet


@pytest.fixture(scope="module")
def walking() -> Record:
    """A few frames of a textbook walk on multi-segment feet."""
    walk = walk_record(Human.create(feet="multi-segment"), speed=1.3, cycles=1)
    return replace(walk, motion=walk.motion.frames(slice(None, None, 10)))


@pytest.fixture(scope="module")
def page(tmp_path_factory, walking):
    path = tmp_path_factory.mktemp("bones") / "viewer.html"
    path.write_text(viewer_html(walking, title="walk"), encoding="utf-8")
    with open_browser(width=480, height=360) as browser:
        browser.open(path, ready=READY)
        browser.evaluate("plantigrade.pause(); plantigrade.setQuality('full'); 0")
        yield browser
        assert browser.errors == []


def ivory(picture: np.ndarray) -> int:
    """Number of pixels in the colour of bones: bright, red over green over blue."""
    red, green, blue = np.moveaxis(picture.astype(int), -1, 0)
    return int(((red > 150) & (red - green > 3) & (green - blue > 8) & (red - blue < 60)).sum())


@pytest.mark.browser
def test_the_close_up_follows_the_right_foot_and_shows_its_bones(page, walking):
    before = ivory(page.screenshot())
    page.evaluate("plantigrade.setView('foot'); plantigrade.seek(plantigrade.times[0]); 0")
    picture = page.screenshot()
    assert page.evaluate("plantigrade.show.xray") is True
    scene, foot = build_scene(walking), walking.human.body("foot_r")
    np.testing.assert_allclose(
        page.evaluate("plantigrade.camera.target"), scene.positions[0, foot], atol=1e-3
    )
    assert ivory(picture) > before + 500


@pytest.mark.browser
def test_bones_replace_the_solids_of_the_feet_and_of_nothing_else(page, walking):
    faces = len(foot_bones(walking.human)[0].faces)
    assert page.evaluate("buffers.bones.count") == 3 * BONES * faces
    others = page.evaluate(
        "shapeBuffer(D.shapes.filter(s => s.body && !D.foot.body.includes(s.body))).count"
    )
    assert others > 0
    assert page.evaluate("buffers.inside.count") == 3 * BONES * faces + others


@pytest.mark.browser
def test_contact_points_lie_on_the_sole(page, walking):
    page.evaluate("plantigrade.seek(plantigrade.times[0]); 0")
    page.settle()
    rows = np.array(
        page.evaluate(
            "(buffers.sphere.rows.length = 0, contactPoints(instant().poses), buffers.sphere.rows)"
        )
    )
    points = rows.reshape(-1, 11)[:, :3]
    assert len(points) == BONES
    assert -0.02 < points[:, 2].min() < 0.005


def test_feet_without_bones_offer_no_close_up(record):
    buttons = re.findall(r'data-view="(\w+)"', viewer_html(record, title="x"))
    assert "foot" not in buttons and "feet" in buttons
