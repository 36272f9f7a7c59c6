"""Grounds by name, as on the command line: ``slope:5``, ``bumps:2``, ``stones``."""

from collections.abc import Callable

import numpy as np
from scipy.ndimage import gaussian_filter

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.contact.relief import Bump, HeightField
from plantigrade.errors import ParameterError
from plantigrade.world.platform import Tilting

RELIEF_AHEAD = 12.0  # [m] of relief in front of the origin
RELIEF_ASIDE = 2.0  # [m] of relief to each side of the origin and behind it
RAMP_LENGTH = 40.0  # [m]
RAMP_START = 4.0  # [m] of level ground before a ramp, for the first steps
RAMP_SPACING = 0.5  # [m] between grid points of a ramp
TREAD_DEPTH = 0.6  # [m] of stairs, about a walking step
GRID_SPACING = 0.05  # [m] between points of a height field
TILE_WIDTH = 0.40  # [m]
TILE_SPACING = 0.025  # [m] between points of the height field of tiles
TILES_AHEAD = 18.0  # [m] of tiles in front of the origin
SMOOTHING = 3.0  # [grid points] standard deviation of the Gaussian that smooths bumps


def ground_named(word: str, *, seed: int = 0) -> Ground:
    """Return the ground that a name describes, with its number after a colon.

    ==============  =============================================================================
    ``flat``        level ground
    ``slope:DEG``   slope upwards in front
    ``ramp:DEG``    slope after 4 m of level ground; downwards if negative
    ``sphere:R``    top of a sphere of radius R [m]
    ``dome:CM``     dome of this height and 15 cm radius under each foot
    ``steps:CM``    stairs with treads of 60 cm, the first 50 cm ahead; downwards if negative
    ``bumps:CM``    smooth random bumps up to this height, different for every seed
    ``tiles:CM``    tiles of 40 cm with random heights up to this; level within 0.5 m of the start
    ``stones``      stepping stones over a trench of 20 cm
    ==============  =============================================================================
    """
    name, colon, number = word.strip().partition(":")
    if name not in GROUNDS:
        raise ParameterError(
            f"no ground {word!r}; there are {', '.join(map(_spelled, GROUNDS))}, tilting:DEG"
        )
    build, unit, low, high, _ = GROUNDS[name]
    if not unit:
        if colon:
            raise ParameterError(f"{name} takes no number, not {number!r}")
        return build(0.0, seed)
    try:
        value = float(number)
    except ValueError:
        value = np.nan
    if not low <= value <= high:
        raise ParameterError(
            f"{_spelled(name)} needs a number from {low:g} to {high:g} {unit}, not {number!r}"
        )
    return build(value, seed)


def platform_named(word: str) -> Tilting | None:
    """Return the plate of ``tilting:DEG``, ``tilting:DEG,PERIOD`` or ``tilting:DEG,PERIOD,WAY``.

    The plate tilts about the start position of the person with this amplitude [°] and period [s]
    (4 s if absent), first up in front, or in another direction [°], 90 for up on the left.

    Returns:
        The plate; None for any other ground.
    """
    name, _, numbers = word.strip().partition(":")
    if name != "tilting":
        return None
    try:
        degrees, period, way = (*map(float, numbers.split(",")), *(4.0, 0.0)[numbers.count(",") :])
    except ValueError:
        raise ParameterError(
            f"{word!r}: write tilting:DEG, tilting:DEG,PERIOD_S or tilting:DEG,PERIOD_S,WAY_DEG"
        ) from None
    amplitude, direction = float(np.deg2rad(degrees)), float(np.deg2rad(way))
    return Tilting(amplitude=amplitude, period=period, direction=direction)


def _spelled(name: str) -> str:
    metavar = GROUNDS[name][4]
    return f"{name}:{metavar}" if metavar else name


def _ramp(degrees: float, _: int) -> Ground:
    """Return level ground followed by a slope, which a person reaches while walking."""
    n = round((RAMP_LENGTH + RAMP_START + RELIEF_ASIDE) / RAMP_SPACING) + 1
    rise = np.tan(np.deg2rad(degrees)) * np.maximum(
        RAMP_SPACING * np.arange(n) - RELIEF_ASIDE - RAMP_START, 0.0
    )
    low = float(rise.min())
    rows = tuple(map(tuple, np.tile(rise - low, (2, 1)).tolist()))
    return Ground(
        height=low,
        field=HeightField((-RELIEF_ASIDE, -RELIEF_ASIDE), (RAMP_SPACING, 2 * RELIEF_ASIDE), rows),
    )


def _sphere(radius: float, _: int) -> Ground:
    """Return the top of a sphere at the origin, without ground around it."""
    return Ground(height=-radius, bumps=(Bump((0.05, 0.0, -radius), radius),))


def _dome(centimetres: float, _: int, foot: float = 0.15, half_step_width: float = 0.09) -> Ground:
    """Return a spherical cap under the middle of each foot."""
    height = 0.01 * centimetres
    radius = (foot**2 + height**2) / (2 * height)
    return Ground(
        bumps=tuple(
            Bump((0.05, y, height - radius), radius) for y in (-half_step_width, half_step_width)
        )
    )


def _steps(centimetres: float, _: int) -> Ground:
    rise = 0.01 * centimetres
    return Ground(steps=tuple(GroundStep(0.5 + TREAD_DEPTH * i, rise * (i + 1)) for i in range(18)))


def _bumps(centimetres: float, seed: int) -> Ground:
    z = relief(0.01 * centimetres, np.random.default_rng(seed))
    return _field(z - z.min(), float(z.min()))


def relief(height: float, rng: np.random.Generator) -> Float[Array, "n_y n_x"]:
    """Return random heights, smoothed over 15 cm, with a given maximum magnitude [m].

    The grid spacing is :data:`GRID_SPACING`; the first point lies :data:`RELIEF_ASIDE` behind and
    to the right of the origin.

    Args:
        height: Maximum magnitude of the heights [m].
    """
    white = rng.uniform(-1.0, 1.0, _size())
    z = gaussian_filter(white, SMOOTHING, mode="constant", truncate=3.0)
    return z * (height / np.abs(z).max())


def _tiles(centimetres: float, seed: int) -> Ground:
    """Return tiles of random height; the tile at the start is at height zero."""
    per = round(TILE_WIDTH / TILE_SPACING)
    ny, nx = (
        round(2 * RELIEF_ASIDE / TILE_SPACING) + 1,
        round((TILES_AHEAD + RELIEF_ASIDE) / TILE_SPACING) + 1,
    )
    rng = np.random.default_rng(seed)
    heights = rng.uniform(0.0, 0.01 * centimetres, (ny // per + 1, nx // per + 1))
    z = np.kron(heights, np.ones((per, per)))[:ny, :nx]
    x, y = TILE_SPACING * np.arange(nx) - RELIEF_ASIDE, TILE_SPACING * np.arange(ny) - RELIEF_ASIDE
    z[np.ix_(np.abs(y) < 0.5, np.abs(x) < 0.5)] = 0.0
    rows = tuple(map(tuple, z.tolist()))
    return Ground(
        field=HeightField((-RELIEF_ASIDE, -RELIEF_ASIDE), (TILE_SPACING, TILE_SPACING), rows)
    )


def _stones(_: float, seed: int, *, depth: float = 0.2) -> Ground:
    """Return flat stones of 35 by 25 cm, every 30 cm, with small random displacements."""
    rng = np.random.default_rng(seed)
    ny, nx = _size()
    x, y = GRID_SPACING * np.arange(nx) - RELIEF_ASIDE, GRID_SPACING * np.arange(ny) - RELIEF_ASIDE
    z = np.zeros((ny, nx))
    z[np.ix_(np.abs(y) < 0.3, np.abs(x) < 0.3)] = depth  # start position
    for i, place in enumerate(np.arange(0.6, RELIEF_AHEAD - 0.5, 0.3)):
        at = place + rng.uniform(-0.05, 0.05)
        side = (0.12 if i % 2 else -0.12) + rng.uniform(-0.03, 0.03)
        z[np.ix_(np.abs(y - side) <= 0.13, np.abs(x - at) <= 0.18)] = depth
    return _field(z, -depth)


def _size() -> tuple[int, int]:
    """Return the number of points along y and along x."""
    return round(2 * RELIEF_ASIDE / GRID_SPACING) + 1, round(
        (RELIEF_AHEAD + RELIEF_ASIDE) / GRID_SPACING
    ) + 1


def _field(z: np.ndarray, height: float) -> Ground:
    heights = tuple(map(tuple, z.tolist()))
    return Ground(
        height=height,
        field=HeightField((-RELIEF_ASIDE, -RELIEF_ASIDE), (GRID_SPACING, GRID_SPACING), heights),
    )


GROUNDS: dict[str, tuple[Callable[[float, int], Ground], str, float, float, str]] = {
    "flat": (lambda _, __: Ground(), "", 0, 0, ""),
    "slope": (lambda deg, _: Ground(slope=float(np.deg2rad(deg))), "degrees", -30, 30, "DEG"),
    "ramp": (_ramp, "degrees", -30, 30, "DEG"),
    "sphere": (_sphere, "m", 0.3, 100, "R"),
    "dome": (_dome, "cm", 0.1, 5, "CM"),
    "steps": (_steps, "cm", -80, 80, "CM"),
    "bumps": (_bumps, "cm", 0.1, 20, "CM"),
    "tiles": (_tiles, "cm", 0.1, 20, "CM"),
    "stones": (_stones, "", 0, 0, ""),
}
"""Name → builder, unit, minimum, maximum and placeholder of its number."""
