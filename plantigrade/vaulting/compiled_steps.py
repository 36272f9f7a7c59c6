"""Many integration steps as one call of machine code.

A step is a CasADi function of about a thousand operations. CasADi's interpreter needs about 20 µs
for it and Python the same again per call; a search needs millions of steps. LLVM, which is
installed for optimisation, compiles the loop. Without LLVM the interpreter gives the same result
more slowly.
"""

import ctypes
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.batched import code_cache, llvm
from plantigrade.batched.tables import (
    ARITHMETIC,
    CALLS,
    COMPARISONS,
    LIBRARY_NAMES,
    SQUARES,
    Program,
)


class Stepper:
    """Repeat a step ``(y, u_now, u_then, h) -> (y_next, extras)`` until the hands leave the table.

    Args:
        step: The step, of SX symbols.
        end_index: Index of the extra that ends the loop when it becomes zero, after the first
            steps.

    Attributes:
        compiled: Whether steps run as machine code.
    """

    def __init__(self, step: Any, *, end_index: int):
        self._step, self._leave = step, end_index
        self.ny, self.nu = step.nnz_in(0), step.nnz_in(1)
        self.ne = step.nnz_out(1)
        self.compiled = not llvm.unavailable()
        if self.compiled:
            try:
                self._load()
            except llvm.Untranslatable:
                self.compiled = False

    def __call__(
        self, y: Float[Array, " ny"], u: Float[Array, "m nu"], h: float, min_steps: int = 5
    ) -> tuple[Float[Array, "n ny"], Float[Array, "n ne"]]:
        """Return states and extras from the first state to the first one without force.

        Args:
            u: Inputs at the boundaries of the steps.
            h: Length of a step [s].
            min_steps: Minimum number of steps regardless of the force.
        """
        m = len(u)
        rows = np.empty((m + 1, self.ny + self.ne))
        rows[0, : self.ny] = y
        if self.compiled:
            u = np.ascontiguousarray(u, dtype=float)
            library = self._library.ctypes.data
            n = self._run(rows.ctypes.data, u.ctypes.data, library, h, m - 1, min_steps)
        else:
            n = self._interpreted(rows, u, h, min_steps)
        return rows[:n, : self.ny], rows[:n, self.ny :]

    def _interpreted(self, rows: Array, u: Array, h: float, min_steps: int) -> int:
        for i in range(len(u) - 1):
            after, extras = self._step(rows[i, : self.ny], u[i], u[i + 1], h)
            rows[i, self.ny :] = extras.full().ravel()
            rows[i + 1, : self.ny] = after.full().ravel()
            if i >= min_steps and not rows[i, self.ny + self._leave] > 0.0:
                return i + 1
        return len(u) - 1

    def _load(self) -> None:
        text = _loop(Program.of(self._step), self.ny, self.nu, self.ne, self._leave)
        name = f"steps for {llvm.target()}\n{text}"
        content = code_cache.read(name)
        if content is None:
            content = llvm.emitted(text)
            code_cache.write(name, content)
        self._engine = llvm.engine(content)
        kinds = [ctypes.c_void_p] * 3 + [ctypes.c_double] + [ctypes.c_int64] * 2
        address = self._engine.get_function_address("run")
        self._run = ctypes.CFUNCTYPE(ctypes.c_int64, *kinds)(address)
        self._library = np.array(llvm.addresses(LIBRARY_NAMES), dtype=np.uint64)


def _loop(program: Program, ny: int, nu: int, ne: int, end_index: int) -> str:
    """Return the loop in LLVM assembly: ``run(rows, u, library, h, steps, min_steps)``."""
    width = ny + ne
    lines = [
        "declare double @llvm.sqrt.f64(double)\ndeclare double @llvm.fabs.f64(double)",
        "declare double @llvm.copysign.f64(double, double)",
        "define i64 @run(ptr %rows, ptr %u, ptr %f, double %h, i64 %steps, i64 %least) {",
        "entry:\n%none = icmp sle i64 %steps, 0\nbr i1 %none, label %empty, label %step",
        "empty:\nret i64 0",
        "step:\n%i = phi i64 [0, %entry], [%i.1, %next]\n%i.1 = add i64 %i, 1",
        f"%at = mul i64 %i, {width}\n%row = getelementptr double, ptr %rows, i64 %at",
        f"%after = getelementptr double, ptr %row, i64 {width}",
        f"%u.at = mul i64 %i, {nu}\n%now = getelementptr double, ptr %u, i64 %u.at",
        f"%then = getelementptr double, ptr %now, i64 {nu}",
    ]
    sources = ("%row", "%now", "%then")
    value: list[str] = []
    for k, (name, a, b) in enumerate(program.named()):
        v = f"%v{k}"
        if name == "constant":
            value.append(_number(program.constants[a]))
            continue
        if name == "input":
            if a == 3:
                value.append("%h")
                continue
            lines.append(f"%p{k} = getelementptr double, ptr {sources[a]}, i64 {b}")
            lines.append(f"{v} = load double, ptr %p{k}")
        else:
            lines += _operation(name, k, value[a], value[b] if b >= 0 else "")
        value.append(v)
    for j, source in enumerate(program.outputs):
        to, place = ("%after", j) if j < ny else ("%row", j)
        lines.append(f"%q{j} = getelementptr double, ptr {to}, i64 {place}")
        lines.append(f"store double {value[source]}, ptr %q{j}")
    lines += [
        f"%held = fcmp ogt double {value[program.outputs[ny + end_index]]}, 0.0",
        "%early = icmp slt i64 %i, %least\n%on = or i1 %held, %early",
        "br i1 %on, label %next, label %done",
        "next:\n%more = icmp slt i64 %i.1, %steps\nbr i1 %more, label %step, label %done",
        "done:\nret i64 %i.1\n}",
    ]
    return "\n".join(lines)


def _number(x: float) -> str:
    return f"0x{np.float64(x).view(np.uint64):016X}"


def _operation(name: str, k: int, a: str, b: str) -> list[str]:
    """Return the instructions that compute value k."""
    v, zero = f"%v{k}", _number(0.0)
    if name in ARITHMETIC:
        return [f"{v} = {ARITHMETIC[name]} double {a}, {b}"]
    if name in SQUARES:
        return [f"{v} = {SQUARES[name]} double {a}, {a}"]
    if name in ("fmax", "fmin"):
        lines = [f"%c{k} = fcmp {'ogt' if name == 'fmax' else 'olt'} double {a}, {b}"]
        return [*lines, f"{v} = select i1 %c{k}, double {a}, double {b}"]
    if name in CALLS:
        arguments = ", ".join(f"double {x}" for x in (a, b) if x)
        return [
            f"%f{k}.p = getelementptr ptr, ptr %f, i32 {CALLS[name]}",
            f"%f{k} = load ptr, ptr %f{k}.p",
            f"{v} = call double %f{k}({arguments})",
        ]
    if name in COMPARISONS:
        lines = [f"%c{k} = fcmp {COMPARISONS[name]} double {a}, {b}"]
        return [*lines, f"{v} = uitofp i1 %c{k} to double"]
    if name == "if_else_zero":
        lines = [f"%c{k} = fcmp une double {a}, {zero}"]
        return [*lines, f"{v} = select i1 %c{k}, double {b}, double {zero}"]
    if name == "neg":
        return [f"{v} = fneg double {a}"]
    if name == "inv":
        return [f"{v} = fdiv double {_number(1.0)}, {a}"]
    if name in ("sqrt", "fabs"):
        return [f"{v} = call double @llvm.{name}.f64(double {a})"]
    raise llvm.Untranslatable(f"a step has the operation {name!r}")
