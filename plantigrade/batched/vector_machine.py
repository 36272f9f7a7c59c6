"""A virtual machine that steps through a table of operations, each for many nodes at once.

Decoding an operation costs little compared with computing it for 64 nodes. The machine itself is
machine code, made by LLVM in a fifth of a second, stored on disk, and the same for all tables;
compiling a table of 400 000 operations would take ten seconds or more, for code measured to be less
than twice as fast.
"""

import ctypes
import threading
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from plantigrade.batched import code_cache, llvm
from plantigrade.batched.kernel import kernel
from plantigrade.batched.tables import LIBRARY_NAMES, ProgramTable

LANES = (8, 16, 24, 32, 40, 48, 56, 64)
"""Numbers of nodes evaluated at a time. The smallest is taken with which no more passes are needed
than with the largest: to decode an operation takes as long as to compute it for 16 nodes."""
VERSION = 2  # of the machine; raise it whenever the kernel changes


class Machine:
    """A machine with a table and its constants loaded, or :class:`llvm.Untranslatable` raised.

    Every thread that calls it works in memory of its own.
    """

    def __init__(self, table: ProgramTable, constants: np.ndarray):
        self._table, self._constants = table, constants
        self._library = np.array(llvm.addresses(LIBRARY_NAMES), dtype=np.uint64)
        self._starts = np.cumsum([0, *table.sizes]).tolist()
        self._engines: dict[int, tuple[Any, Any]] = {}  # code lives as long as its engine
        self._own = threading.local()
        _machine(LANES[-1])  # so that LLVM refuses now rather than at the first call

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
        passes = -(-n // LANES[-1])
        run, memory = self._with(next(each for each in LANES if each * passes >= n))
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
        """Return the code for a number of nodes at a time, and this thread's memory for it."""
        if lanes not in self._engines:
            self._engines[lanes] = _machine(lanes)
        memories: dict[int, np.ndarray] = vars(self._own).setdefault("memories", {})
        if lanes not in memories:
            memory = np.zeros(self._table.n_places * lanes + 8)
            memory = memory[(-memory.ctypes.data // 8) % 8 :]  # aligned for vector instructions
            filled = np.repeat(self._constants, lanes)
            first = self._starts[-1] * lanes
            memory[first : first + len(filled)] = filled
            memories[lanes] = memory
        return self._engines[lanes][1], memories[lanes]


@cache
def _machine(lanes: int) -> tuple[Any, Any]:
    """Return the engine with the code for a number of nodes at a time, and the code."""
    width = llvm.vector_width()
    name = f"vector machine {VERSION} {lanes} {LIBRARY_NAMES} for {llvm.target()}"
    content = code_cache.read(name)
    if content is None:
        content = llvm.emitted(kernel(width, lanes // width))
        code_cache.write(name, content)
    engine = llvm.engine(content)
    kinds = [ctypes.c_void_p] * 5 + [ctypes.c_int64] * 3
    return engine, ctypes.CFUNCTYPE(None, *kinds)(engine.get_function_address("run"))
