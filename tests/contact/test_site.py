"""Contact sites: spheres of the model, and sites of a plan with their bodies."""

import mujoco
import numpy as np
import pytest

from plantigrade.contact.site import ContactSite, Point, contact_sites, foot_sites
from plantigrade.errors import ParameterError
from plantigrade.models import FEET, Human


@pytest.mark.parametrize("feet", FEET)
def test_every_sphere_of_the_model_is_a_site(feet):
    human = Human.create(feet=feet)
    sites = contact_sites(human)
    model = human.model
    spheres = [i for i in range(model.ngeom) if model.geom_group[i] == 3]
    assert len(sites) == len({site.name for site in sites}) == len(spheres)
    for site in sites:
        geom = model.geom(f"contact_{site.name}")
        assert model.body(geom.bodyid[0]).name == site.body
        np.testing.assert_array_equal(geom.pos, site.position)
        assert geom.size[0] == site.radius > 0 and site.side == site.body[-1]


@pytest.mark.parametrize("feet", FEET)
def test_sites_of_a_plan_are_where_the_spheres_are(feet):
    """A sphere on the toe hinge is given in the frame of the toes."""
    human = Human.create(feet=feet)
    data = mujoco.MjData(human.model)
    data.qpos = human.standing()
    mujoco.mj_kinematics(human.model, data)

    def places(sites):
        return np.array([data.body(s.body).xmat.reshape(3, 3) @ s.position + data.body(s.body).xpos
                         for s in sites])  # fmt: skip

    sites = foot_sites(human)
    own = places(contact_sites(human))
    apart = np.linalg.norm(places(sites)[:, None] - own[None], axis=-1).min(axis=1)
    np.testing.assert_allclose(apart, 0.0, atol=1e-12)
    half = len(sites) // 2
    assert [s.side for s in sites] == ["r"] * half + ["l"] * half
    assert [s.name[:-2] for s in sites[:half]] == [s.name[:-2] for s in sites[half:]]


@pytest.mark.parametrize(
    "wrong",
    [{"position": (0.0, 1.0)}, {"position": (0, 0, float("nan"))}, {"radius": -0.1},
     {"radius": float("nan")}],
)  # fmt: skip
def test_an_invalid_point_raises(wrong):
    with pytest.raises(ParameterError):
        Point("foot_r", **wrong)
    with pytest.raises(ParameterError):
        ContactSite(body="foot_r", name="heel", **wrong)


def test_an_unknown_side_raises():
    with pytest.raises(ParameterError, match="side"):
        ContactSite(body="foot_r", name="heel", side="right")
