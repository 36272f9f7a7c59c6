"""Paths of the soles over a motion: the lowest points of the contact spheres."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.contact.site import ContactSite, contact_sites
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human

__all__ = ["SitePoints", "SolePaths", "lowest", "sole_paths"]

_REGIONS = {"heel": "heel", "metatarsal": "ball", "toe": "toes", "base": "middle"}


def region_of(site: ContactSite) -> str:
    """Return the region of the sole a site belongs to: heel, ball, toes or middle."""
    name = site.name.removeprefix(f"{site.body[:-2]}_")
    return next(region for word, region in _REGIONS.items() if name.startswith(word))


class SitePoints(PointSet):
    """Contact sites of one person: the centres of their spheres are the points.

    Args:
        sites: The sites.

    Attributes:
        sites: The sites.
        radius: Radius of each sphere [m].
    """

    def __init__(self, human: Human, sites: Sequence[ContactSite]):
        super().__init__(human, [s.body for s in sites], np.array([s.position for s in sites]))
        self.sites = tuple(sites)
        self.radius = np.array([site.radius for site in sites])

    def height(self, state: BodyState) -> Float[Array, " n_points"]:
        """Return how high the lowest points of the spheres are [m]."""
        return state.position(self)[:, 2] - self.radius


@dataclass(frozen=True)
class SolePaths:
    """The soles of a person over a motion."""

    sites: tuple[ContactSite, ...]  #: The contact spheres
    #: Lowest point of each sphere, straight below its centre, in axes of the ground, z the height
    #: above it [m]
    position: Float[Array, "n_frames n_sites 3"]

    @cached_property
    def region(self) -> tuple[str, ...]:
        """Region of each site: ``"heel"``, ``"ball"``, ``"toes"`` or ``"middle"``."""
        return tuple(region_of(site) for site in self.sites)

    @cached_property
    def radius(self) -> Float[Array, " n_sites"]:
        """Radius of each sphere [m]."""
        return np.array([site.radius for site in self.sites])

    def of(self, side: str, region: str | None = None) -> np.ndarray:
        """Return the indices of a foot's sites, of one region or of all."""
        pairs = zip(self.sites, self.region, strict=True)
        return np.flatnonzero([s.side == side and region in (None, r) for s, r in pairs])

    def lowest(self, side: str, region: str | None = None) -> Float[Array, " n_frames"]:
        """Return the height of the lowest point of a sole, or of one of its regions [m]."""
        return self.position[:, self.of(side, region), 2].min(axis=1)

    @property
    def ends(self) -> list[Float[Array, "n_frames 2 3"]]:
        """Mean positions of the heels, then of the toes, of both feet, right first [m]."""
        return [
            np.stack([self.position[:, self.of(s, r)].mean(axis=1) for s in SIDES], axis=1)
            for r in ("heel", "toes")
        ]

    @property
    def penetration(self) -> Float[Array, " n_frames"]:
        """How deep the lowest point lies below the ground in every frame [m]."""
        return np.maximum(0.0, -self.position[..., 2].min(axis=1))


def sole_paths(
    human: Human, qpos: Float[Array, "n_frames nq"], ground: Ground = LEVEL_GROUND
) -> SolePaths:
    """Return the positions of the soles in every frame.

    Args:
        ground: Ground above which they are measured.
    """
    sites = contact_sites(human)
    centres = SitePoints(human, sites).path(qpos)
    paths = SolePaths(sites, ground.above(centres))
    paths.position[..., 2] -= paths.radius
    return paths


def lowest(human: Human, qpos: Float[Array, "n_frames nq"]) -> Float[Array, " n_frames"]:
    """Return the height of the lowest point of the soles in every frame [m]."""
    return sole_paths(human, qpos).position[..., 2].min(axis=1)
