"""A motion at one phase: named views of one row of numbers, so that a look-up blends once."""

from typing import Any, overload

import numpy as np

from plantigrade.arrays import Array, Bool, Float

Layout = dict[str, tuple[Any, tuple[int, ...] | None]]
"""Field → its columns, and the shape they are brought to; None where they have it."""


class Field:
    """A quantity of an :class:`Instant`: a view that may be written to.

    Args:
        shape: Its shape; a name stands for a size that depends on the person.
        order: Order of the time derivative: 0 of positions and forces, 1 of rates, 2 of
            accelerations.
    """

    def __init__(self, *shape: int | str, order: int = 0):
        self.shape, self.order = shape, order

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instant: None, owner: type) -> "Field": ...
    @overload
    def __get__(self, instant: "Instant", owner: type) -> Array: ...
    def __get__(self, instant, owner):
        if instant is None:
            return self
        columns, shape = instant.layout[self.name]
        values = instant.row[columns]
        return values if shape is None else values.reshape(shape)

    def __set__(self, instant: "Instant", value: Any) -> None:
        self.__get__(instant, Instant)[...] = value


class Instant:
    """A motion at one phase, world axes; feet right first.

    Args:
        row: All numbers, or a mask of them; of several phases one row each, which every field then
            begins with.
        layout: Columns and shape of every field.
    """

    q = Field("nq")  #: Configuration
    v = Field("nv", order=1)  #: Velocity, in the tangent space of the configuration
    a = Field("nv", order=2)  #: Acceleration, likewise
    tau = Field("n_hinges")  #: Joint torques [N m]
    force = Field("n_sites", 3)  #: Force on each contact sphere [N]
    com = Field(3)  #: Centre of mass [m]
    com_velocity = Field(3, order=1)  #: Its velocity [m/s]
    com_acceleration = Field(3, order=2)  #: Its acceleration [m/s²]
    cop = Field(3)  #: Centre of pressure; where nothing is loaded, the zero-moment point [m]
    foot_position = Field(2, 3)  #: Origin of each foot [m]
    foot_velocity = Field(2, 3, order=1)  #: Its velocity [m/s]
    foot_acceleration = Field(2, 3, order=2)  #: Its acceleration [m/s²]
    foot_rotation = Field(2, 3, 3)  #: Rotation matrix of each foot, foot to world
    foot_angular_velocity = Field(2, 3, order=1)  #: Angular velocity of each foot [rad/s]
    foot_angular_acceleration = Field(2, 3, order=2)  #: Angular acceleration of each foot [rad/s²]
    contact = Field("n_sites")  #: Whether each sphere is in contact, 1 or 0
    contact_soon = Field("n_sites")  #: Whether it is, or will be shortly, 1 or 0
    contact_position = Field("n_sites", 3)  #: Lowest point of each sphere [m]

    __slots__ = ("layout", "row")

    def __init__(
        self, row: Float[Array, "*n n_columns"] | Bool[Array, " n_columns"], layout: Layout
    ):
        self.row, self.layout = row, layout

    def still(self) -> "Instant":
        """Return the same instant at rest: no rates, the pressure under the centre of mass."""
        out = Instant(np.where(derivative_order(self.layout) > 0, 0.0, self.row), self.layout)
        out.cop = out.com
        return out


FIELDS = tuple(each for each in vars(Instant).values() if isinstance(each, Field))


def layout_of(nq: int, nv: int, n_sites: int) -> Layout:
    """Return the layout of a row."""
    sizes = {"nq": nq, "nv": nv, "n_hinges": nv - 6, "n_sites": n_sites}
    layout: Layout = {}
    first = 0
    for field in FIELDS:
        shape = tuple(sizes[n] if isinstance(n, str) else n for n in field.shape)
        size = int(np.prod(shape))
        layout[field.name] = slice(first, first + size), shape if len(shape) > 1 else None
        first += size
    return layout


def width_of(layout: Layout) -> int:
    """Return the number of columns of a layout."""
    return max(columns.stop for columns, _ in layout.values())


def rows_of(table: Float[Array, "n_rows n_columns"], layout: Layout) -> Instant:
    """Return the fields of a whole table, one row an instant."""
    every = slice(None)
    return Instant(table, {k: ((every, c), s and (-1, *s)) for k, (c, s) in layout.items()})


def derivative_order(layout: Layout) -> Float[Array, " n_columns"]:
    """Return the order of the time derivative of every column."""
    order = np.zeros(width_of(layout))
    for field in FIELDS:
        order[layout[field.name][0]] = field.order
    return order
