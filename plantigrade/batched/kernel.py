"""Source of the vector machine in LLVM's intermediate representation.

Memory is a row of places, each of which holds some vectors (blocks), each of them the numbers of
four or eight nodes (lanes). ``run`` takes arrays of nodes into the places of inputs, has ``tile``
step through the table once for all blocks, and writes places of outputs to arrays; as often as it
takes to have done all nodes.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from plantigrade.batched.tables import (
    ARITHMETIC,
    CALLS,
    COMPARISONS,
    FUSED,
    NUMBERS,
    PAIRS,
    SQUARES,
)

GROUP = 256  # elements
LINE = 5  # numbers of a line: operation, place of the result, places of operands


def kernel(width: int, blocks: int) -> str:
    """Return the source for a vector width and a number of vectors per memory slot."""
    V = f"<{width} x double>"
    return "\n".join((_library_calls(V, width), _tile(V, width, blocks), _run(V, width, blocks)))


def _tile(V: str, width: int, blocks: int) -> str:
    """Return the function that evaluates a table once."""
    text = [
        f"declare {V} @llvm.fmuladd.v{width}f64({V}, {V}, {V})\n"
        "define internal void @tile(ptr %w, ptr %table, ptr %f) {\n"
        "entry:\n%lines32 = load i32, ptr %table\n%lines = sext i32 %lines32 to i64\n"
        "%first = getelementptr i32, ptr %table, i64 1\n%none = icmp eq i64 %lines, 0\n"
        "br i1 %none, label %done, label %step\n"
        "step:\n%i = phi i64 [0, %entry], [%i.1, %next]\n"
        "%p = phi ptr [%first, %entry], [%p.1, %next]\n%op = load i32, ptr %p"
    ]
    for k, each in enumerate("rabc", start=1):
        text.append(
            f"%{each}.p = getelementptr i32, ptr %p, i64 {k}\n%{each}.i = load i32, ptr %{each}.p\n"
            f"%{each}.l = sext i32 %{each}.i to i64\n"
            f"%{each} = getelementptr [{blocks} x {V}], ptr %w, i64 %{each}.l"
        )
    cases = " ".join(f"i32 {i}, label %op{i}" for i in range(len(NUMBERS)))
    text.append(f"switch i32 %op, label %next [{cases}]")
    for i, name in enumerate(NUMBERS):
        text.append(f"op{i}:")
        for t in range(blocks):
            k = i * blocks + t
            for each in "abc" if name in FUSED else "ab":
                text.append(
                    f"%{each}{k}.p = getelementptr {V}, ptr %{each}, i64 {t}\n"
                    f"%{each}{k}.x = load {V}, ptr %{each}{k}.p, align {8 * width}"
                )
            a, b, c = (f"%{each}{k}.x" for each in "abc")
            if name in FUSED:
                text.append(_fused(name, k, a, b, c, V, width))
            else:
                text.append(_operation(name, k, a, b if name in PAIRS else "", V, width))
            text.append(
                f"%r{k}.p = getelementptr {V}, ptr %r, i64 {t}\n"
                f"store {V} %v{k}, ptr %r{k}.p, align {8 * width}"
            )
        text.append("br label %next")
    text.append(
        f"next:\n%i.1 = add i64 %i, 1\n%p.1 = getelementptr i32, ptr %p, i64 {LINE}\n"
        "%more = icmp ult i64 %i.1, %lines\nbr i1 %more, label %step, label %done\n"
        "done:\nret void\n}"
    )
    return "\n".join(text)


def _fused(name: str, k: int, a: str, b: str, c: str, V: str, width: int) -> str:
    before = ""
    if name == "mulsub":
        before, c = f"%n{k} = fneg {V} {c}\n", f"%n{k}"
    elif name == "submul":
        before, a = f"%n{k} = fneg {V} {a}\n", f"%n{k}"
    call = f"call {V} @llvm.fmuladd.v{width}f64({V} {a}, {V} {b}, {V} {c})"
    return f"{before}%v{k} = {call}"


def _operation(name: str, k: int, a: str, b: str, V: str, width: int) -> str:
    """Return the instructions that compute value k."""
    zero, one, minus = "zeroinitializer", _splat("1.0", width), _splat("-1.0", width)
    M, v = f"<{width} x i1>", f"%v{k}"
    if name in ARITHMETIC:
        return f"{v} = {ARITHMETIC[name]} {V} {a}, {b}"
    if name in SQUARES:
        return f"{v} = {SQUARES[name]} {V} {a}, {a}"
    if name in CALLS:
        pointer = f"%f{k} = getelementptr ptr, ptr %f, i32 {CALLS[name]}\n"
        pointer += f"%g{k} = load ptr, ptr %f{k}\n"
        if b:
            return pointer + f"{v} = call {V} @library2(ptr %g{k}, {V} {a}, {V} {b})"
        return pointer + f"{v} = call {V} @library1(ptr %g{k}, {V} {a})"
    if name in COMPARISONS:
        m = f"%m{k} = fcmp {COMPARISONS[name]} {V} {a}, {b}\n"
        return m + f"{v} = uitofp {M} %m{k} to {V}"
    if name in ("and", "or"):
        m = f"%a{k} = fcmp une {V} {a}, {zero}\n%b{k} = fcmp une {V} {b}, {zero}\n"
        return m + f"%m{k} = {name} {M} %a{k}, %b{k}\n{v} = uitofp {M} %m{k} to {V}"
    if name == "sign":  # of zero and NaN the argument itself
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
        self.text, self._block = [head, "entry:"], "entry"

    def line(self, text: str) -> None:
        """Add a line."""
        self.text.append(text)

    @contextmanager
    def loop(self, index: str, count: str) -> Iterator[None]:
        """Repeat the lines added within, with an index from zero to below a count."""
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


def _run(V: str, width: int, blocks: int) -> str:
    """Return ``run``, which loads nodes into vectors, runs the program and stores the results.

    Lanes that are left over repeat the last node, and write nothing.
    """
    f = _Loops(
        "declare i64 @llvm.umin.i64(i64, i64)\n"
        "define void @run(ptr %inputs, ptr %outputs, ptr %table, ptr %f, ptr %work, "
        "i64 %n, i64 %n_in, i64 %n_out) {"
    )

    def row(i: str, table: str, *names: str) -> None:
        f.line(f"%{i}.row = mul i64 %{i}, {len(names)}")
        for k, name in enumerate(names):
            kind = "ptr" if name.endswith("_at") else "i64"
            f.line(f"%{i}.a{k} = add i64 %{i}.row, {k}")
            f.line(f"%{i}.p{k} = getelementptr i64, ptr %{table}, i64 %{i}.a{k}")
            f.line(f"%{name} = load {kind}, ptr %{i}.p{k}")

    f.line("%last = sub i64 %n, 1")
    f.line(f"%up = add i64 %n, {width - 1}\n%blocks = udiv i64 %up, {width}")
    f.line(f"%up.t = add i64 %blocks, {blocks - 1}\n%tiles = udiv i64 %up.t, {blocks}")
    with f.loop("t", "%tiles"):
        f.line(f"%t.first = mul i64 %t, {blocks}\n%left = sub i64 %blocks, %t.first")
        f.line(f"%count = call i64 @llvm.umin.i64(i64 %left, i64 {blocks})")
        with f.loop("b", "%count"):
            f.line(f"%b.in = add i64 %t.first, %b\n%b.first = mul i64 %b.in, {width}")
            with f.loop("i", "%n_in"):
                row("i", "inputs", "i_at", "i_size", "i_start")
                for lane in range(width):
                    f.line(f"%n{lane} = add i64 %b.first, {lane}")
                    f.line(f"%m{lane} = call i64 @llvm.umin.i64(i64 %n{lane}, i64 %last)")
                    f.line(f"%o{lane} = mul i64 %m{lane}, %i_size")
                    f.line(f"%x{lane} = getelementptr double, ptr %i_at, i64 %o{lane}")
                with f.loop("e", "%i_size"):
                    so_far = "poison"
                    for lane in range(width):
                        f.line(f"%q{lane} = getelementptr double, ptr %x{lane}, i64 %e")
                        f.line(f"%l{lane} = load double, ptr %q{lane}")
                        made = f"insertelement {V} {so_far}, double %l{lane}, i32 {lane}"
                        f.line(f"%y{lane} = {made}")
                        so_far = f"%y{lane}"
                    f.line("%e.in = add i64 %i_start, %e")
                    f.line(f"%e.to = getelementptr [{blocks} x {V}], ptr %work, i64 %e.in, i64 %b")
                    f.line(f"store {V} {so_far}, ptr %e.to, align {8 * width}")
        f.line("call void @tile(ptr %work, ptr %table, ptr %f)")
        with f.loop("o", "%n_out"):
            row("o", "outputs", "o_at", "o_stride", "source_at", "place_at", "o_set", "o_add")
            for kind in ("set", "add"):
                _write(f, width, blocks, kind)
    f.line("ret void\n}")
    return "\n".join(f.text)


def _write(f: _Loops, width: int, blocks: int, kind: str) -> None:
    """Set elements of an output at all nodes of a tile, or add to them.

    That goes by groups of elements, which stay in the innermost cache while they are written to one
    node after the other: neighbours among the places of a node are then written together.
    """
    g, d, lane, m = (f"{kind}.{x}" for x in ("g", "d", "l", "m"))
    f.line(f"%{g}.up = add i64 %o_{kind}, {GROUP - 1}\n%{g}.n = udiv i64 %{g}.up, {GROUP}")
    with f.loop(g, f"%{g}.n"):
        f.line(f"%{g}.first = mul i64 %{g}, {GROUP}\n%{g}.left = sub i64 %o_{kind}, %{g}.first")
        f.line(f"%{g}.few = call i64 @llvm.umin.i64(i64 %{g}.left, i64 {GROUP})")
        for name in ("source", "place"):
            f.line(f"%{g}.{name} = getelementptr i64, ptr %{name}_at, i64 %{g}.first")
        with f.loop(d, "%count"):
            f.line(f"%{d}.in = add i64 %t.first, %{d}\n%{d}.first = mul i64 %{d}.in, {width}")
            f.line(f"%{d}.left = sub i64 %n, %{d}.first")
            f.line(f"%{d}.lanes = call i64 @llvm.umin.i64(i64 %{d}.left, i64 {width})")
            with f.loop(lane, f"%{d}.lanes"):
                f.line(f"%{lane}.node = add i64 %{d}.first, %{lane}")
                f.line(f"%{lane}.at = mul i64 %{lane}.node, %o_stride")
                f.line(f"%{lane}.to = getelementptr double, ptr %o_at, i64 %{lane}.at")
                index = f"i64 0, i64 %{d}, i64 %{lane}"
                place = f"[{blocks} x [{width} x double]]"
                f.line(f"%{lane}.from = getelementptr {place}, ptr %work, {index}")
                with f.loop(m, f"%{g}.few"):
                    for name in ("source", "place"):
                        at = f"%{m}.{name}.at"
                        f.line(f"{at} = getelementptr i64, ptr %{g}.{name}, i64 %{m}")
                        f.line(f"%{m}.{name} = load i64, ptr {at}")
                    f.line(f"%{m}.from = getelementptr {place}, ptr %{lane}.from, i64 %{m}.source")
                    f.line(f"%{m}.x = load double, ptr %{m}.from")
                    f.line(f"%{m}.to = getelementptr double, ptr %{lane}.to, i64 %{m}.place")
                    value = f"%{m}.x"
                    if kind == "add":
                        value = f"%{m}.sum"
                        f.line(f"%{m}.old = load double, ptr %{m}.to")
                        f.line(f"{value} = fadd double %{m}.old, %{m}.x")
                    f.line(f"store double {value}, ptr %{m}.to")
