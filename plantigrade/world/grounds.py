"""Grounds by name, as on the command line: ``slope:5``, ``bumps:2``, ``stones``."""

from collections.abc import Callable

import numpy as np
from scipy.ndimage import gaussian_filter

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Bump, Ground, HeightField, Step
from plantigrade.errors import ParameterError
from plantigrade.world.platform import Tilting

AHEAD, ASIDE = 12.0, 2.0
"""How far relief reaches forward, and to each side and back [m]."""
UPHILL, LEVEL, CELL = 40.0, 4.0, 0.5
"""A ramp reaches so far, begins after so much level ground, on a grid of this distance [m]."""
TREAD = 0.6
"""Depth of a step [m]."""
GRID = 0.05
"""Distance of the points of a height field [m]."""
TILE, FINE, TILED = 0.40, 0.025, 18.0
"""Width of a tile, distance of the points of their height field, how far ahead they reach [m]."""
SMOOTH = 3.0
"""Standard deviation of the Gaussian that smooths bumps, in such distances."""


def ground_named(word: str, *, seed: int = 0) -> Ground:
    """Return the ground of a name, with its number behind a colon.

    ==============  =============================================================================
    ``flat``        level
    ``slope:DEG``   rises forward
    ``ramp:DEG``    the same after 4 m of level ground; down where negative
    ``sphere:R``    the top of a sphere of that radius [m]
    ``dome:CM``     a dome of that height and 15 cm radius under each foot
    ``steps:CM``    stairs, a tread every 60 cm, the first 50 cm ahead; down where negative
    ``bumps:CM``    smooth random bumps of at most that height, another landscape for every seed
    ``tiles:CM``    tiles of 40 cm, of random heights up to that; level for half a metre at first
    ``stones``      stepping stones over a trench of 20 cm
    ==============  =============================================================================

    Args:
        word: The name.
        seed: Of what is random.

    Raises:
        ParameterError: If there is no such ground, or its number is not allowed.
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

    It sways by so many degrees in so many seconds (4 if absent) about the place where the person
    stands: up in front, or in another direction in degrees, 90 for up on the left.

    Returns:
        The plate; None if the word is another ground.

    Raises:
        ParameterError: If the numbers are not allowed.
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


def _slope(degrees: float, _: int) -> Ground:
    return Ground(slope=float(np.deg2rad(degrees)))


def _ramp(degrees: float, _: int) -> Ground:
    """Return level ground, then a slope: who comes walking meets it as they walk."""
    n = round((UPHILL + LEVEL + ASIDE) / CELL) + 1
    rise = np.tan(np.deg2rad(degrees)) * np.maximum(CELL * np.arange(n) - ASIDE - LEVEL, 0.0)
    low = float(rise.min())
    rows = tuple(map(tuple, np.tile(rise - low, (2, 1)).tolist()))
    return Ground(height=low, field=HeightField((-ASIDE, -ASIDE), (CELL, 2 * ASIDE), rows))


def _sphere(radius: float, _: int) -> Ground:
    """Return the top of a sphere at the origin; beside it there is nothing."""
    return Ground(height=-radius, bumps=(Bump((0.05, 0.0, -radius), radius),))


def _dome(centimetres: float, _: int, foot: float = 0.15, apart: float = 0.09) -> Ground:
    """Return a spherical cap under the middle of each foot."""
    height = 0.01 * centimetres
    radius = (foot**2 + height**2) / (2 * height)
    return Ground(bumps=tuple(Bump((0.05, y, height - radius), radius) for y in (-apart, apart)))


def _steps(centimetres: float, _: int) -> Ground:
    rise = 0.01 * centimetres
    return Ground(steps=tuple(Step(0.5 + TREAD * i, rise * (i + 1)) for i in range(18)))


def _bumps(centimetres: float, seed: int) -> Ground:
    z = relief(0.01 * centimetres, np.random.default_rng(seed))
    return _field(z - z.min(), float(z.min()))


def relief(height: float, rng: np.random.Generator) -> Float[Array, "n_y n_x"]:
    """Return random heights, smoothed over 15 cm, as high or as deep as said somewhere [m].

    Points are :data:`GRID` apart, the first at :data:`ASIDE` behind and to the right.

    Args:
        height: That height [m].
        rng: By which it is drawn.
    """
    white = rng.uniform(-1.0, 1.0, _size())
    z = gaussian_filter(white, SMOOTH, mode="constant", truncate=3.0)
    return z * (height / np.abs(z).max())


def _tiles(centimetres: float, seed: int) -> Ground:
    """Return tiles of random height, the one where the person starts as low as the lowest."""
    per = round(TILE / FINE)
    ny, nx = round(2 * ASIDE / FINE) + 1, round((TILED + ASIDE) / FINE) + 1
    rng = np.random.default_rng(seed)
    heights = rng.uniform(0.0, 0.01 * centimetres, (ny // per + 1, nx // per + 1))
    z = np.kron(heights, np.ones((per, per)))[:ny, :nx]
    x, y = FINE * np.arange(nx) - ASIDE, FINE * np.arange(ny) - ASIDE
    z[np.ix_(np.abs(y) < 0.5, np.abs(x) < 0.5)] = 0.0
    rows = tuple(map(tuple, z.tolist()))
    return Ground(field=HeightField((-ASIDE, -ASIDE), (FINE, FINE), rows))


def _stones(_: float, seed: int, *, deep: float = 0.2) -> Ground:
    """Return flat stones of 35 by 25 cm, two to a step of 60 cm, each a little off its place."""
    rng = np.random.default_rng(seed)
    ny, nx = _size()
    x, y = GRID * np.arange(nx) - ASIDE, GRID * np.arange(ny) - ASIDE
    z = np.zeros((ny, nx))
    z[np.ix_(np.abs(y) < 0.3, np.abs(x) < 0.3)] = deep  # where the person stands
    for i, place in enumerate(np.arange(0.6, AHEAD - 0.5, 0.3)):
        at = place + rng.uniform(-0.05, 0.05)
        side = (0.12 if i % 2 else -0.12) + rng.uniform(-0.03, 0.03)
        z[np.ix_(np.abs(y - side) <= 0.13, np.abs(x - at) <= 0.18)] = deep
    return _field(z, -deep)


def _size() -> tuple[int, int]:
    """Return the number of points along y and along x."""
    return round(2 * ASIDE / GRID) + 1, round((AHEAD + ASIDE) / GRID) + 1


def _field(z: np.ndarray, height: float) -> Ground:
    heights = tuple(map(tuple, z.tolist()))
    return Ground(height=height, field=HeightField((-ASIDE, -ASIDE), (GRID, GRID), heights))


GROUNDS: dict[str, tuple[Callable[[float, int], Ground], str, float, float, str]] = {
    "flat": (lambda _, __: Ground(), "", 0, 0, ""),
    "slope": (_slope, "degrees", -30, 30, "DEG"),
    "ramp": (_ramp, "degrees", -30, 30, "DEG"),
    "sphere": (_sphere, "m", 0.3, 100, "R"),
    "dome": (_dome, "cm", 0.1, 5, "CM"),
    "steps": (_steps, "cm", -30, 30, "CM"),
    "bumps": (_bumps, "cm", 0.1, 20, "CM"),
    "tiles": (_tiles, "cm", 0.1, 20, "CM"),
    "stones": (_stones, "", 0, 0, ""),
}
"""Name → how it is built, unit of its number, least, most, how it is written."""
