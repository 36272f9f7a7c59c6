"""Straight-line programs as machine code, by the LLVM that comes with llvmlite.

A program (:class:`Program`) is cut into pieces of a few hundred operations, each a function of its
own, so that translation takes time in proportion to length. A value that a later piece needs is
kept in a slot of memory; all else stays in registers or on the stack. Every value is a vector with
one node a lane, and every piece runs over the blocks of a few vectors that fit the caches, before
the next piece does: code of some megabytes is then read from memory once for all of them.

Measured on the second derivatives of a body of 43 coordinates (150 000 operations): optimisation
level 1 translates 3.5 times as long as level 0 and gives code 1.2 times as fast, so it is level 0.
"""

import ctypes
import ctypes.util
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, no_type_check

import numpy as np

if TYPE_CHECKING:
    import casadi

VERSION = 2  # of the translation below: code from another one is not used
PIECE = 200  # operations a function
TILE = 4  # vectors a piece runs over before the next one does
FETCHED = ("input", "constant")

_ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
_COMPARISONS = {"lt": "olt", "le": "ole", "eq": "oeq", "ne": "une"}
_SQUARES = {"sq": "fmul", "twice": "fadd"}
_LIBRARY = (  # functions of one or two numbers from the C library: CasADi's name, its name there
    *((n, n) for n in ("exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh")),
    *((n, n) for n in ("tanh", "asinh", "acosh", "atanh", "expm1", "log1p", "erf", "floor")),
    *((n, n) for n in ("ceil", "pow", "fmod", "atan2", "hypot", "remainder", "fmin", "fmax")),
    ("constpow", "pow"),
)
_NAMES = tuple(dict.fromkeys(there for _, there in _LIBRARY))
_CALLS = {name: _NAMES.index(there) for name, there in _LIBRARY}
_OTHERS = ("neg", "sqrt", "fabs", "inv", "sign", "copysign", "if_else_zero", "not", "and", "or")
_KNOWN = {*_ARITHMETIC, *_COMPARISONS, *_SQUARES, *_CALLS, *_OTHERS}
_SAME = {"assign", "lift"}  # give their first operand
_COMMUTE = {"add", "mul", "eq", "ne", "fmin", "fmax", "hypot", "and", "or"}


class Untranslatable(Exception):
    """There is no machine code for this; the message says why."""


@dataclass(frozen=True)
class Program:
    """Operations in order, each making one value that is never made again.

    Attributes:
        operations: Names of the operations: CasADi's, without ``OP_`` and in lower case.
        operands: Two numbers for each: the values it takes (-1: none); input and element of an
            ``"input"``; the index of a ``"constant"``.
        outputs: Values of the nonzeros of every output, one output after the other.
        constants: What the constants are.
        sizes: Lengths of the inputs.
        nonzeros: Numbers of nonzeros of the outputs.
    """

    operations: list[str]
    operands: list[tuple[int, int]]
    outputs: list[int]
    constants: list[float]
    sizes: tuple[int, ...]
    nonzeros: tuple[int, ...]

    @classmethod
    def of(cls, function: "casadi.Function", shared: bool = False) -> "Program":
        """Return the program of an SX function; equal operations on equal values are done once.

        Args:
            function: A function of SX symbols with dense inputs.
            shared: Whether the last input is the same at every node: its elements are then
                constants, after those of the function.

        Raises:
            Untranslatable: If the function is not made of SX symbols or has an unknown operation.
        """
        import casadi as ca

        if not function.is_a("SXFunction"):
            raise Untranslatable(f"{function.name()!r} is a {function.class_name()}, not of SX")
        names = {getattr(ca, n): n[3:].lower() for n in dir(ca) if n.startswith("OP_")}
        sizes = tuple(function.nnz_in(i) for i in range(function.n_in()))
        nonzeros = tuple(function.nnz_out(i) for i in range(function.n_out()))
        starts = np.cumsum([0, *nonzeros]).tolist()
        operations: list[str] = []
        operands: list[tuple[int, int]] = []
        outputs, constants = [-1] * starts[-1], []
        register: dict[int, int] = {}
        known: dict[tuple[str, int, int], int] = {}
        for k in range(function.n_instructions()):
            name = names.get(function.instruction_id(k), "unknown")
            taken, made = function.instruction_input(k), function.instruction_output(k)
            if name == "output":
                outputs[starts[made[0]] + made[1]] = register[taken[0]]
                continue
            if name == "const":
                name, a, b = "constant", len(constants), -1
                constants.append(float(function.instruction_constant(k)))
            elif name == "input":
                a, b = taken
                if shared and a == len(sizes) - 1:
                    name, a, b = "constant", -1 - b, -1  # numbered below
            elif name in _SAME:
                register[made[0]] = register[taken[0]]
                continue
            elif name in _KNOWN:
                a, b = register[taken[0]], register[taken[1]] if len(taken) > 1 else -1
                if b < a and name in _COMMUTE:
                    a, b = b, a
            else:
                raise Untranslatable(f"{function.name()!r} has the operation {name!r}")
            value = known.setdefault((name, a, b), len(operations))
            if value == len(operations):
                operations.append(name)
                operands.append((a, b))
            register[made[0]] = value
        if shared:
            sizes, n = sizes[:-1], len(constants)
            for i, (name, (a, b)) in enumerate(zip(operations, operands, strict=True)):
                if name == "constant" and a < 0:
                    operands[i] = n - 1 - a, b
        if -1 in outputs:
            raise Untranslatable(f"{function.name()!r} leaves nonzeros of outputs unset")
        return cls(operations, operands, outputs, constants, sizes, nonzeros)


class Code:
    """Machine code of a program, ready to run.

    Args:
        objects: From :func:`compiled`.
        sizes: Lengths of the inputs.
        nonzeros: Numbers of nonzeros of the outputs.
        slots: From :func:`compiled`.
    """

    def __init__(
        self, objects: Sequence[bytes], sizes: Sequence[int], nonzeros: Sequence[int], slots: int
    ):
        import llvmlite.binding as llvm

        _start()
        with _refusals():
            self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine(2))
            for each in objects:
                self._engine.add_object_file(llvm.ObjectFileRef.from_data(each))
            self._engine.finalize_object()
        self._tile = self._engine.get_function_address("tile")
        kinds = [ctypes.c_void_p] * 6 + [ctypes.c_int64] * 3
        self._run = ctypes.CFUNCTYPE(None, *kinds)(self._engine.get_function_address("run"))
        self._library = np.array(_addresses(), dtype=np.uint64)
        self._sizes, self._starts = tuple(sizes), np.cumsum([0, *sizes]).tolist()
        self._places = np.cumsum([0, *nonzeros]).tolist()
        vectors = TILE * (sum(sizes) + sum(nonzeros) + slots)
        self._workspace = vectors * vector_width() + 8  # doubles; so many more for alignment

    def workspace(self) -> np.ndarray:
        """Return memory to work in, at an address that vectors want."""
        memory = np.empty(self._workspace)
        return memory[(-memory.ctypes.data // 8) % 8 :]

    def __call__(
        self,
        inputs: Sequence[np.ndarray],
        constants: np.ndarray,
        outputs: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]],
        workspace: np.ndarray,
        add: bool,
    ) -> None:
        """Evaluate at all nodes.

        Args:
            inputs: Contiguous, (n_nodes, size) each; at least one node.
            constants: What the constants are.
            outputs: For every output a contiguous array whose first axis is nodes, which of its
                nonzeros are written (int64) and to which place of a node (int64).
            workspace: From :meth:`workspace`.
            add: Whether to add to what the arrays hold.
        """
        rows = zip(inputs, self._sizes, self._starts, strict=False)
        taken = np.array([(x.ctypes.data, n, at) for x, n, at in rows], dtype=np.int64)
        given = np.array(
            [
                (
                    *(y.ctypes.data, y.strides[0] // 8, s.ctypes.data, p.ctypes.data),
                    *((0, len(s)) if add else (len(s), 0)),
                    at,
                )
                for (y, s, p), at in zip(outputs, self._places, strict=False)
            ],
            dtype=np.int64,
        )
        self._run(
            self._tile,
            taken.ctypes.data,
            given.ctypes.data,
            constants.ctypes.data,
            self._library.ctypes.data,
            workspace.ctypes.data,
            len(inputs[0]),
            len(inputs),
            len(outputs),
        )


def compiled(program: Program) -> tuple[list[bytes], int]:
    """Return machine code for this processor as object files, and how many slots it needs.

    Raises:
        Untranslatable: If LLVM refuses.
    """
    import llvmlite.binding as llvm

    _start()
    text, slots = _pieces(program, vector_width())
    # The driver is short and does what loops do, which is worth optimising.
    driver = _driver(sum(program.sizes), sum(program.nonzeros), slots, vector_width())
    objects = []
    for source, level in ((text, 0), (driver, 2)):
        with _refusals():
            module = llvm.parse_assembly(source)
            module.verify()
            objects.append(_machine(level).emit_object(module))
    return objects, slots


def unavailable() -> str:
    """Return why there is no machine code here; empty if there is."""
    if sys.platform == "win32":  # stacks there must be touched page by page; nobody has tried it
        return "machine code is not made on Windows"
    try:
        import llvmlite.binding  # noqa: F401
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] != "llvmlite":
            raise
        return "llvmlite is not installed"
    except (ImportError, OSError) as error:
        return f"llvmlite cannot be loaded: {error}"
    try:
        _start()
        _addresses()
    except (RuntimeError, AttributeError, OSError) as error:
        return f"LLVM does not know this machine: {error}"
    return ""


@contextmanager
def _refusals() -> Iterator[None]:
    """Turn what LLVM refuses into our error."""
    try:
        yield
    except RuntimeError as error:
        raise Untranslatable(f"LLVM refuses: {error}") from error


@cache
def target() -> str:
    """Return what machine code depends on besides the program."""
    import llvmlite
    import llvmlite.binding as llvm

    parts = (VERSION, PIECE, TILE, vector_width(), llvmlite.__version__, llvm.llvm_version_info)
    return " ".join(map(str, (*parts, llvm.get_default_triple(), *_host())))


@cache
def vector_width() -> int:
    """Return how many nodes are evaluated at once."""
    return 8 if "+avx512f" in _host()[1].split(",") else 4


@cache
def _start() -> None:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


@cache
def _host() -> tuple[str, str]:
    """Return this processor's name and features."""
    import llvmlite.binding as llvm

    return llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def _machine(level: int) -> Any:
    import llvmlite.binding as llvm

    cpu, features = _host()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=cpu, features=features, opt=level, reloc="pic", codemodel="default"
    )


@cache
def _addresses() -> tuple[int, ...]:
    """Return where the functions of the C library are."""
    library = ctypes.CDLL(ctypes.util.find_library("m") or ctypes.util.find_library("System"))
    return tuple(int(ctypes.cast(getattr(library, n), ctypes.c_void_p).value or 0) for n in _NAMES)


# Text ---------------------------------------------------------------------------------------------


@no_type_check  # nor of what it calls: shapes are checked in tests, of each of 100 000 calls
def _pieces(program: Program, width: int) -> tuple[str, int]:
    """Return the pieces of a program and ``tile``, which runs them, and the number of slots."""
    operations, operands = program.operations, program.operands
    piece = np.cumsum([n not in FETCHED for n in operations])
    piece = ((piece - 1) // PIECE).tolist()  # that of a fetched value does not matter
    last = list(piece)  # piece that needs a value last
    for k, (a, b) in enumerate(operands):
        if operations[k] not in FETCHED:
            last[a] = piece[k]  # pieces only grow
            if b >= 0:
                last[b] = piece[k]
    places: dict[int, list[int]] = {}
    for place, value in enumerate(program.outputs):
        places.setdefault(value, []).append(place)
    starts = np.cumsum([0, *program.sizes]).tolist()
    V = f"<{width} x double>"
    slots: dict[int, int] = {}
    free: list[int] = []
    ending: dict[int, list[int]] = {}
    n_slots = n_pieces = 0
    body: list[str] = []
    have: dict[int, str] = {}
    text = [_library_calls(V, width)]

    def close() -> None:
        nonlocal n_pieces
        if body:
            head = (
                f"define internal void @piece{n_pieces}(ptr %in, ptr %out, ptr %w, ptr %c, ptr %f)"
            )
            text.extend((head + " {", *body, "ret void\n}"))
            n_pieces += 1
            body.clear()
            have.clear()

    def fetch(value: int) -> str:
        """Return the name of a value, loaded first where this piece does not have it yet."""
        if value not in have:
            name, (a, b) = operations[value], operands[value]
            if name == "constant":
                body.append(
                    f"%p{value} = getelementptr double, ptr %c, i32 {a}\n"
                    f"%s{value} = load double, ptr %p{value}\n"
                    f"%i{value} = insertelement {V} poison, double %s{value}, i32 0\n"
                    f"%v{value} = shufflevector {V} %i{value}, {V} poison, "
                    f"<{width} x i32> zeroinitializer"
                )
            else:
                base, at = ("in", starts[a] + b) if name == "input" else ("w", slots[value])
                body.append(
                    f"%p{value} = getelementptr {V}, ptr %{base}, i32 {at}\n"
                    f"%v{value} = load {V}, ptr %p{value}, align {8 * width}"
                )
            have[value] = f"%v{value}"
        return have[value]

    def store(name: str, value: int, base: str, at: int) -> None:
        pointer = f"%{base}{at}.{value}"
        body.append(
            f"{pointer} = getelementptr {V}, ptr %{base}, i32 {at}\n"
            f"store {V} {name}, ptr {pointer}, align {8 * width}"
        )

    current = 0
    for k, name in enumerate(operations):
        if name in FETCHED:
            continue
        if piece[k] != current:
            close()
            current = piece[k]
            free += ending.pop(current - 1, [])
        a, b = operands[k]
        first = fetch(a)
        body.append(_operation(name, k, first, fetch(b) if b >= 0 else "", V, width))
        have[k] = f"%v{k}"
        if last[k] > current:
            if not free:
                free.append(n_slots)
                n_slots += 1
            slots[k] = free.pop()
            ending.setdefault(last[k], []).append(slots[k])
            store(have[k], k, "w", slots[k])
        for place in places.get(k, ()):
            store(have[k], k, "out", place)
    close()
    for value, where in places.items():  # outputs that are inputs or constants
        if operations[value] in FETCHED:
            for place in where:
                store(fetch(value), value, "out", place)
    close()
    blocks = [("in", starts[-1]), ("out", len(program.outputs)), ("w", n_slots)]
    tile = _Loops("define void @tile(ptr %in, ptr %out, ptr %w, ptr %c, ptr %f, i64 %n) {")
    for i in range(n_pieces):
        with tile.loop(f"k{i}", "%n"):
            for base, size in blocks:
                tile.line(f"%{base}{i} = getelementptr [{size} x {V}], ptr %{base}, i64 %k{i}")
            arguments = ", ".join(f"ptr %{base}{i}" for base, _ in blocks)
            tile.line(f"call void @piece{i}({arguments}, ptr %c, ptr %f)")
    tile.line("ret void\n}")
    return "\n".join((*text, *tile.text)), n_slots


@no_type_check
def _operation(name: str, k: int, a: str, b: str, V: str, width: int) -> str:
    """Return the text that makes value k."""
    zero, one, minus = "zeroinitializer", _splat("1.0", width), _splat("-1.0", width)
    M, v = f"<{width} x i1>", f"%v{k}"
    if name in _ARITHMETIC:
        return f"{v} = {_ARITHMETIC[name]} contract {V} {a}, {b}"
    if name in _SQUARES:
        return f"{v} = {_SQUARES[name]} contract {V} {a}, {a}"
    if name in _CALLS:
        pointer = f"%f{k} = getelementptr ptr, ptr %f, i32 {_CALLS[name]}\n"
        pointer += f"%g{k} = load ptr, ptr %f{k}\n"
        if b:
            return pointer + f"{v} = call {V} @library2(ptr %g{k}, {V} {a}, {V} {b})"
        return pointer + f"{v} = call {V} @library1(ptr %g{k}, {V} {a})"
    if name in _COMPARISONS:
        m = f"%m{k} = fcmp {_COMPARISONS[name]} {V} {a}, {b}\n"
        return m + f"{v} = uitofp {M} %m{k} to {V}"
    if name in ("and", "or"):
        m = f"%a{k} = fcmp une {V} {a}, {zero}\n%b{k} = fcmp une {V} {b}, {zero}\n"
        return m + f"%m{k} = {name} {M} %a{k}, %b{k}\n{v} = uitofp {M} %m{k} to {V}"
    if name == "sign":  # of zero and of what is no number the argument itself
        m = f"%a{k} = fcmp olt {V} {a}, {zero}\n%b{k} = fcmp ogt {V} {a}, {zero}\n"
        m += f"%p{k} = select {M} %b{k}, {V} {one}, {V} {a}\n"
        return m + f"{v} = select {M} %a{k}, {V} {minus}, {V} %p{k}"
    if name == "if_else_zero":
        m = f"%m{k} = fcmp une {V} {a}, {zero}\n"
        return m + f"{v} = select {M} %m{k}, {V} {b}, {V} {zero}"
    if name == "not":
        return f"%m{k} = fcmp oeq {V} {a}, {zero}\n{v} = uitofp {M} %m{k} to {V}"
    if name == "neg":
        return f"{v} = fneg {V} {a}"
    if name == "inv":
        return f"{v} = fdiv {V} {one}, {a}"
    if name == "copysign":
        return f"{v} = call {V} @llvm.copysign.v{width}f64({V} {a}, {V} {b})"
    return f"{v} = call {V} @llvm.{name}.v{width}f64({V} {a})"  # sqrt, fabs


def _splat(number: str, width: int) -> str:
    return "<" + ", ".join([f"double {number}"] * width) + ">"


def _library_calls(V: str, width: int) -> str:
    """Return functions that call a function of the C library lane by lane."""
    text = [f"declare {V} @llvm.{n}.v{width}f64({V})" for n in ("sqrt", "fabs")]
    text.append(f"declare {V} @llvm.copysign.v{width}f64({V}, {V})")
    for n in (1, 2):
        taken = [f"%x{i}" for i in range(n)]
        arguments = ", ".join(f"{V} {x}" for x in taken)
        text.append(f"define internal {V} @library{n}(ptr %f, {arguments}) noinline {{")
        so_far = "poison"
        for lane in range(width):
            for x in taken:
                text.append(f"{x}.{lane} = extractelement {V} {x}, i32 {lane}")
            arguments = ", ".join(f"double {x}.{lane}" for x in taken)
            text.append(f"%r{lane} = call double %f({arguments})")
            text.append(f"%y{lane} = insertelement {V} {so_far}, double %r{lane}, i32 {lane}")
            so_far = f"%y{lane}"
        text.append(f"ret {V} {so_far}\n}}")
    return "\n".join(text)


class _Loops:
    """Text of a function of nested loops."""

    def __init__(self, head: str):
        self.text, self._block, self._count = [head, "entry:"], "entry", 0

    def line(self, text: str) -> None:
        """Add a line."""
        self.text.append(text)

    @contextmanager
    def loop(self, index: str, count: str) -> Iterator[None]:
        """Repeat what is added within, with an index from zero to less than a count."""
        before, i = self._block, f"%{index}"
        head, inside, after = (f"{index}.{n}" for n in ("head", "inside", "after"))
        self.text.append(f"br label %{head}\n{head}:\n{i} = phi i64 [0, %{before}], [{i}.1, @@]")
        mark = len(self.text) - 1
        self.text.append(f"{i}.more = icmp ult i64 {i}, {count}")
        self.text.append(f"br i1 {i}.more, label %{inside}, label %{after}\n{inside}:")
        self._block = inside
        yield
        self.text[mark] = self.text[mark].replace("@@", f"%{self._block}")
        self.text.append(f"{i}.1 = add i64 {i}, 1\nbr label %{head}\n{after}:")
        self._block = after


def _driver(n_in: int, n_out: int, n_slots: int, width: int) -> str:
    """Return ``run``, which takes nodes into vectors, runs the program and writes results back.

    Lanes that are left over repeat the last node, so that they read and write what is right.
    """
    V = f"<{width} x double>"
    f = _Loops(
        "declare i64 @llvm.umin.i64(i64, i64)\n"
        "define void @run(ptr %tile, ptr %inputs, ptr %outputs, ptr %c, ptr %f, ptr %work, "
        "i64 %n, i64 %n_in, i64 %n_out) {"
    )

    def row(i: str, table: str, *names: str) -> None:
        f.line(f"%{i}.row = mul i64 %{i}, {len(names)}")
        for k, name in enumerate(names):
            kind = "ptr" if name.endswith("_at") else "i64"
            f.line(f"%{i}.a{k} = add i64 %{i}.row, {k}")
            f.line(f"%{i}.p{k} = getelementptr i64, ptr %{table}, i64 %{i}.a{k}")
            f.line(f"%{name} = load {kind}, ptr %{i}.p{k}")

    def lanes(base: str, name: str, first: str, stride: str) -> None:
        """Point every lane to its node."""
        for lane in range(width):
            f.line(f"%{name}n{lane} = add i64 %{first}, {lane}")
            f.line(f"%{name}m{lane} = call i64 @llvm.umin.i64(i64 %{name}n{lane}, i64 %last)")
            f.line(f"%{name}o{lane} = mul i64 %{name}m{lane}, %{stride}")
            f.line(f"%{name}{lane} = getelementptr double, ptr %{base}, i64 %{name}o{lane}")

    f.line(f"%out = getelementptr {V}, ptr %work, i64 {TILE * n_in}")
    f.line(f"%slots = getelementptr {V}, ptr %work, i64 {TILE * (n_in + n_out)}")
    f.line("%last = sub i64 %n, 1")
    f.line(f"%up = add i64 %n, {width - 1}\n%blocks = udiv i64 %up, {width}")
    f.line(f"%up.t = add i64 %blocks, {TILE - 1}\n%tiles = udiv i64 %up.t, {TILE}")
    with f.loop("t", "%tiles"):
        f.line(f"%t.first = mul i64 %t, {TILE}\n%left = sub i64 %blocks, %t.first")
        f.line(f"%count = call i64 @llvm.umin.i64(i64 %left, i64 {TILE})")
        with f.loop("b", "%count"):
            f.line(f"%b.in = add i64 %t.first, %b\n%b.first = mul i64 %b.in, {width}")
            f.line(f"%b.start = mul i64 %b, {n_in}")
            with f.loop("i", "%n_in"):
                row("i", "inputs", "i_at", "i_size", "i_start")
                f.line("%i.start = add i64 %b.start, %i_start")
                lanes("i_at", "x", "b.first", "i_size")
                with f.loop("e", "%i_size"):
                    so_far = "poison"
                    for lane in range(width):
                        f.line(f"%q{lane} = getelementptr double, ptr %x{lane}, i64 %e")
                        f.line(f"%l{lane} = load double, ptr %q{lane}")
                        made = f"insertelement {V} {so_far}, double %l{lane}, i32 {lane}"
                        f.line(f"%y{lane} = {made}")
                        so_far = f"%y{lane}"
                    f.line("%e.at = add i64 %i.start, %e")
                    f.line(f"%e.to = getelementptr {V}, ptr %work, i64 %e.at")
                    f.line(f"store {V} {so_far}, ptr %e.to, align {8 * width}")
        f.line("call void %tile(ptr %work, ptr %out, ptr %slots, ptr %c, ptr %f, i64 %count)")
        with f.loop("d", "%count"):
            f.line(f"%d.in = add i64 %t.first, %d\n%d.first = mul i64 %d.in, {width}")
            f.line(f"%d.start = mul i64 %d, {n_out}")
            with f.loop("o", "%n_out"):
                names = ("o_at", "o_stride", "source_at", "place_at", "o_set", "o_add", "o_in")
                row("o", "outputs", *names)
                f.line("%o.start = add i64 %d.start, %o_in")
                lanes("o_at", "z", "d.first", "o_stride")
                for m, count in (("m", "%o_set"), ("k", "%o_add")):
                    with f.loop(m, count):
                        f.line(f"%{m}.s = getelementptr i64, ptr %source_at, i64 %{m}")
                        f.line(f"%{m}.source = load i64, ptr %{m}.s")
                        f.line(f"%{m}.p = getelementptr i64, ptr %place_at, i64 %{m}")
                        f.line(f"%{m}.place = load i64, ptr %{m}.p")
                        f.line(f"%{m}.at = add i64 %o.start, %{m}.source")
                        f.line(f"%{m}.from = getelementptr {V}, ptr %out, i64 %{m}.at")
                        f.line(f"%{m}.v = load {V}, ptr %{m}.from, align {8 * width}")
                        for lane in range(width):
                            x, to = f"%{m}.x{lane}", f"%{m}.to{lane}"
                            f.line(f"{x} = extractelement {V} %{m}.v, i32 {lane}")
                            f.line(f"{to} = getelementptr double, ptr %z{lane}, i64 %{m}.place")
                            if m == "k":  # what is left over adds nothing
                                f.line(f"{x}.in = icmp ule i64 %zn{lane}, %last")
                                f.line(f"{x}.or = select i1 {x}.in, double {x}, double 0.0")
                                f.line(f"{x}.old = load double, ptr {to}")
                                f.line(f"{x}.sum = fadd double {x}.old, {x}.or")
                                x += ".sum"
                            f.line(f"store double {x}, ptr {to}")
    f.line("ret void\n}")
    return "\n".join(f.text)
