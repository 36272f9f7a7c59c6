"""Functions of OpenSim models: the value of a joint axis by its coordinate."""

from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from plantigrade.arrays import Array, Float

MAX_NUMBER = 1e9  # of any number of a model; spline coefficients are the largest
MAX_DEPTH = 20  # of functions within functions; beyond it the file is damaged


@dataclass(frozen=True)
class Function:
    """A function of one coordinate."""

    value: Callable[[np.ndarray], np.ndarray]  #: Its value, element by element
    #: Slope and value at zero where it is a straight line, otherwise None
    line: tuple[float, float] | None = None

    @classmethod
    def linear(cls, slope: float, offset: float = 0.0) -> "Function":
        """Return a straight line."""
        return cls(lambda q: slope * q + offset, (slope, offset))

    @property
    def constant(self) -> float | None:
        """The value of a constant, otherwise None."""
        return self.line[1] if self.line is not None and self.line[0] == 0.0 else None

    def of(self, inner: "Function") -> "Function":
        """Return this function of another one."""
        return Function(lambda q: self.value(inner.value(q)))


class SimmSpline:
    """Cubic spline of SIMM: third derivatives at its ends by four knots, linear outside."""

    def __init__(self, x: Float[Array, " n"], y: Float[Array, " n"]):
        self.x, self.y, n = x, y, len(x)
        self.m = np.zeros(n)  # a sixth of the second derivative
        if n < 3:
            return
        h, slope = np.diff(x), np.diff(y) / np.diff(x)
        A, right = np.zeros((n, n)), np.zeros(n)
        for i in range(1, n - 1):
            A[i, i - 1 : i + 2] = h[i - 1], 2 * (h[i - 1] + h[i]), h[i]
            right[i] = slope[i] - slope[i - 1]
        A[0, :2], A[-1, -2:] = (-h[0], h[0]), (h[-1], -h[-1])
        if n > 3:
            third = np.diff(slope) / (x[2:] - x[:-2])
            right[0] = h[0] ** 2 * (third[1] - third[0]) / (x[3] - x[0])
            right[-1] = -(h[-1] ** 2) * (third[-1] - third[-2]) / (x[-1] - x[-4])
        self.m = np.linalg.solve(A, right)

    def __call__(self, q: np.ndarray) -> np.ndarray:
        """Return the value of the spline."""
        x, y, m = self.x, self.y, self.m
        i = np.clip(np.searchsorted(x, q, "right") - 1, 0, len(x) - 2)
        inside = np.clip(q, x[0], x[-1])
        h = x[i + 1] - x[i]
        t = (inside - x[i]) / h
        u = 1.0 - t
        value = t * y[i + 1] + u * y[i] + h**2 * ((t**3 - t) * m[i + 1] + (u**3 - u) * m[i])
        slope = (y[i + 1] - y[i]) / h + h * ((3 * t**2 - 1) * m[i + 1] - (3 * u**2 - 1) * m[i])
        return value + slope * (q - inside)


def read_function(node: ET.Element, depth: int = 0) -> Function:
    """Return the function that an element describes."""
    tag = node.tag
    if depth > MAX_DEPTH:
        raise ValueError("functions are nested too deeply")
    if tag in ("function", "coupled_coordinates_function") and len(node):
        return read_function(node[0], depth + 1)
    if tag == "Constant":
        return Function.linear(0.0, numbers(node, "value", 1, 0.0)[0])
    if tag == "LinearFunction":
        slope, offset = numbers(node, "coefficients", 2)
        return Function.linear(slope, offset)
    if tag == "PolynomialFunction":
        coefficients = numbers(node, "coefficients")
        return Function(lambda q: np.polyval(coefficients, q))
    if tag in ("SimmSpline", "NaturalCubicSpline"):
        return Function(SimmSpline(*_knots(node)))
    if tag == "PiecewiseLinearFunction":
        x, y = _knots(node)
        return Function(lambda q: np.interp(q, x, y))
    if tag == "MultiplierFunction":
        scale = float(numbers(node, "scale", 1, 1.0)[0])
        inner = node.find("function")
        if inner is None:
            raise ValueError("a MultiplierFunction has no function")
        f = read_function(inner, depth + 1)
        line = None if f.line is None else (scale * f.line[0], scale * f.line[1])
        return Function(lambda q: scale * f.value(q), line)
    raise ValueError(f"a function of kind {tag[:40]} is not read")


def _knots(node: ET.Element) -> tuple[np.ndarray, np.ndarray]:
    x, y = numbers(node, "x"), numbers(node, "y")
    if len(x) != len(y) or len(x) < 2 or not (np.diff(x) > 0).all():
        raise ValueError(f"a {node.tag} needs as many x as y, two at least, x increasing")
    return x, y


def numbers(
    node: ET.Element, tag: str, count: int | None = None, default: float | None = None
) -> Float[Array, " n"]:
    """Return the numbers of a child element.

    Args:
        count: How many there must be; any number if absent.
        default: Value of each where the child is missing; an error if absent.
    """
    words = (node.findtext(tag) or "").split()
    if not words and default is not None and count is not None:
        return np.full(count, default)
    try:
        found = np.array([float(word) for word in words])
    except ValueError as error:
        raise ValueError(f"{tag} of {_name(node)} is not a list of numbers") from error
    if not len(found) or (count is not None and len(found) != count):
        raise ValueError(f"{tag} of {_name(node)} has {len(found)} numbers, not {count or 'any'}")
    if not np.isfinite(found).all():
        raise ValueError(f"{tag} of {_name(node)} is not finite")
    if (most := float(np.abs(found).max())) > MAX_NUMBER:
        raise ValueError(f"{tag} of {_name(node)} is {most:.1e}, which no model of a person has")
    return found


def _name(node: ET.Element) -> str:
    return f"{node.tag} {node.get('name', '')}".strip()[:60]
