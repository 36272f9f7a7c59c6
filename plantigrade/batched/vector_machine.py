"""A machine that steps through tables of operations, every one of them for many nodes at once.

Finding out what to do next costs little beside doing it for 64 nodes. The machine is machine code,
made by LLVM in a fifth of a second and kept on disk, and the same for all tables; translating a
table of 400 000 operations itself would take ten seconds and more, for code that was measured to be
less than twice as fast.
"""

import ctypes
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from plantigrade.batched import code_cache as _code_cache
from plantigrade.batched import llvm as _llvm
from plantigrade.batched.kernel import kernel
from plantigrade.batched.tables import LIBRARY_NAMES, Table

LANES = (16, 32, 64)  # nodes done at once: the fewest that are enough, else the most
VERSION = 2  # of the machine: one of another version is not used


class Machine:
    """A machine with a table in it.

    Args:
        table: What it steps through.
        constants: What the constants are.

    Raises:
        Untranslatable: If LLVM refuses.
    """

    def __init__(self, table: Table, constants: np.ndarray):
        self._table, self._constants = table, constants
        self._library = np.array(_llvm.addresses(LIBRARY_NAMES), dtype=np.uint64)
        self._starts = np.cumsum([0, *table.sizes]).tolist()
        self._made: dict[int, tuple[Any, np.ndarray]] = {}
        self._engines: list[Any] = []  # what is run lives as long as these
        self._with(LANES[-1])  # what is refused is refused now

    def __call__(
        self,
        inputs: Sequence[np.ndarray],
        outputs: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]],
        add: bool,
    ) -> None:
        """Evaluate at all nodes.

        Args:
            inputs: Contiguous, (n_nodes, size) each; at least one node.
            outputs: For every output a contiguous array (n_nodes, width), which of its nonzeros
                are written (int64) and to which columns (int64).
            add: Whether to add to what the arrays hold.
        """
        n = len(inputs[0])
        run, memory = self._with(next((each for each in LANES if each >= n), LANES[-1]))
        rows = zip(inputs, self._table.sizes, self._starts, strict=False)
        taken = np.array([(x.ctypes.data, size, at) for x, size, at in rows], dtype=np.int64)
        found = [self._table.places[i][s] for i, (_, s, _) in enumerate(outputs)]
        given = np.array(
            [
                (
                    *(y.ctypes.data, y.shape[1], source.ctypes.data, place.ctypes.data),
                    *((0, len(source)) if add else (len(source), 0)),
                )
                for (y, _, place), source in zip(outputs, found, strict=True)
            ],
            dtype=np.int64,
        )
        arrays = (taken, given, self._table.lines, self._library, memory)
        run(*(each.ctypes.data for each in arrays), n, len(inputs), len(outputs))

    def _with(self, lanes: int) -> tuple[Any, np.ndarray]:
        """Return the machine for so many nodes at once, and its memory with constants in it."""
        if lanes not in self._made:
            memory = np.zeros(self._table.n_places * lanes + 8)
            memory = memory[(-memory.ctypes.data // 8) % 8 :]  # at an address that vectors want
            filled = np.repeat(self._constants, lanes)
            first = self._starts[-1] * lanes
            memory[first : first + len(filled)] = filled
            engine, run = _machine(lanes)
            self._engines.append(engine)
            self._made[lanes] = run, memory
        return self._made[lanes]


@cache
def _machine(lanes: int) -> tuple[Any, Any]:
    """Return the machine for so many nodes at once: what keeps it in memory, and what runs it."""
    width = _llvm.vector_width()
    name = f"vector machine {VERSION} {lanes} {LIBRARY_NAMES} for {_llvm.target()}"
    content = _code_cache.read(name)
    if content is None:
        content = _llvm.emitted(kernel(width, lanes // width))
        _code_cache.write(name, content)
    engine = _llvm.engine(content)
    kinds = [ctypes.c_void_p] * 5 + [ctypes.c_int64] * 3
    return engine, ctypes.CFUNCTYPE(None, *kinds)(engine.get_function_address("run"))
