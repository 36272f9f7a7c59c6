"""LLVM, as llvmlite provides it: from text in its language to machine code in memory.

The code itself is the concern of :mod:`plantigrade.batched.vector_machine`.
"""

import ctypes
import ctypes.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any


class Untranslatable(Exception):
    """A function that cannot become machine code; the message says why."""


def engine(content: bytes) -> Any:
    """Return machine code from an object file, ready to run, or raise :class:`Untranslatable`."""
    import llvmlite.binding as llvm

    _start()
    with _refusals():
        # With LLVM's own memory manager, code and constants may be 2 GB apart where a process has
        # mapped much (torch does), and then LLVM aborts the process.
        loaded = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine(), use_lmm=True)
        loaded.add_object_file(llvm.ObjectFileRef.from_data(content))
        loaded.finalize_object()
    return loaded


def emitted(text: str) -> bytes:
    """Return an object file from LLVM's language, or raise :class:`Untranslatable`."""
    import llvmlite.binding as llvm

    _start()
    with _refusals():
        module = llvm.parse_assembly(text)
        module.verify()
        return _machine().emit_object(module)


def unavailable() -> str:
    """Return why there is no machine code here; empty if there is."""
    if sys.platform == "win32":  # untested
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
    except RuntimeError as error:
        return f"LLVM does not know this machine: {error}"
    return ""


@contextmanager
def _refusals() -> Iterator[None]:
    """Raise errors of LLVM as :class:`Untranslatable`."""
    try:
        yield
    except RuntimeError as error:
        raise Untranslatable(f"LLVM refuses: {error}") from error


@cache
def target() -> str:
    """Return the target of machine code: triple, processor and features."""
    import llvmlite
    import llvmlite.binding as llvm

    parts = (llvmlite.__version__, llvm.llvm_version_info, llvm.get_default_triple())
    return " ".join(map(str, (*parts, *_host())))


@cache
def vector_width() -> int:
    """Return the number of doubles in a vector register."""
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


def _machine() -> Any:
    import llvmlite.binding as llvm

    cpu, features = _host()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=cpu, features=features, opt=2, reloc="pic", codemodel="default"
    )


@cache
def addresses(names: tuple[str, ...]) -> tuple[int, ...]:
    """Return the addresses of functions of the C library, or raise :class:`Untranslatable`."""
    for library in (None, "m", "System"):  # loaded already, Linux, macOS
        try:
            found = ctypes.CDLL(library and ctypes.util.find_library(library))
            pointers = [ctypes.cast(getattr(found, name), ctypes.c_void_p) for name in names]
        except (AttributeError, OSError):
            continue
        return tuple(int(pointer.value or 0) for pointer in pointers)
    raise Untranslatable(f"the C library has not all of {', '.join(names)}")
