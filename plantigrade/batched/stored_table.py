"""A table of operations together with the signature of its function, in memory and as bytes."""

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array
from plantigrade.batched.tables import Table
from plantigrade.errors import ParameterError

if TYPE_CHECKING:
    import casadi


@dataclass(frozen=True, eq=False)
class Signature:
    """Inputs and outputs of a function, without its parameters.

    Attributes:
        name: Name of the function.
        names: Names of the inputs.
        sizes: Lengths of the inputs.
        patterns: Rows and columns of the nonzeros of every output.
    """

    name: str
    names: tuple[str, ...]
    sizes: tuple[int, ...]
    patterns: tuple[tuple[Array, Array], ...]

    @classmethod
    def of(cls, function: "casadi.Function", shared: bool) -> "Signature":
        """Return the signature of a function.

        Args:
            function: The function.
            shared: Whether its last input holds parameters.

        Raises:
            ParameterError: If an input is not a dense column.
        """
        for i in range(function.n_in()):
            if not (function.sparsity_in(i).is_dense() and function.size2_in(i) <= 1):
                raise ParameterError(
                    f"input {function.name_in(i)!r} of {function.name()!r} is "
                    f"{function.sparsity_in(i).dim(True)}; only dense columns are taken"
                )
        n = function.n_in() - shared
        triplets = [function.sparsity_out(i).get_triplet() for i in range(function.n_out())]
        return cls(
            function.name(),
            tuple(function.name_in(i) for i in range(n)),
            tuple(function.size1_in(i) for i in range(n)),
            tuple((np.array(r, dtype=np.int64), np.array(c, dtype=np.int64)) for r, c in triplets),
        )


@dataclass(frozen=True, eq=False)
class StoredTable:
    """A table with everything a call has to know about the function.

    Attributes:
        signature: Inputs and outputs.
        constants: Constants of the table, parameters excluded.
        table: The operations.
    """

    signature: Signature
    constants: Array
    table: Table

    def to_bytes(self) -> bytes:
        """Return it as an npz archive."""
        s, file = self.signature, io.BytesIO()
        arrays: dict[str, Any] = {}
        for i, (rows, columns) in enumerate(s.patterns):
            arrays |= {f"rows{i}": rows, f"columns{i}": columns, f"places{i}": self.table.places[i]}
        np.savez(
            file,
            name=np.array(s.name),
            names=np.array(s.names, dtype=str),
            sizes=np.array(s.sizes, dtype=np.int64),
            constants=self.constants,
            lines=self.table.lines,
            counts=np.array([len(s.patterns), self.table.n_places]),
            **arrays,
        )
        return file.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes | None) -> "StoredTable | None":
        """Return it from an npz archive; None from None."""
        if content is None:
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as x:
            n_outputs, n_places = x["counts"].tolist()
            patterns = tuple((x[f"rows{i}"], x[f"columns{i}"]) for i in range(n_outputs))
            places = tuple(x[f"places{i}"] for i in range(n_outputs))
            names, sizes = (tuple(x[each].tolist()) for each in ("names", "sizes"))
            signature = Signature(str(x["name"]), names, sizes, patterns)
            return cls(signature, x["constants"], Table(x["lines"], n_places, sizes, places))
