"""Pickle, joblib and torch files of plain arrays, read without running anything of the file.

A pickle is a program for a small machine, and the usual reader runs every function it names. The
reader here knows only the instructions that arrays, tensors, numbers, words, lists, tuples and
dictionaries need, and a table of the functions that NumPy, joblib and torch write for their arrays;
each is replaced by one of this module that checks shape, type and length. Any other instruction or
name is refused and nothing is called.

joblib stores the bytes of an array between the instructions (uncompressed, or zlib or gzip around
all of it). torch stores a zip archive of a pickle and one file per tensor storage.
"""

import io
import pickle
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.errors import FileError
from plantigrade.io.pickle_arrays import (
    MAKERS,
    STORAGES,
    EmptyArray,
    JoblibArray,
    Maker,
    Refused,
    Storage,
    Type,
    count,
    filled,
    list_of,
    plain,
    set_items,
)
from plantigrade.io.text import read_bytes

MAX_BYTES = 400 * 2**20  # [bytes] of a file, and of what it decompresses to
MAX_RATIO = 100  # [1] decompressed size over compressed size; arrays of motions stay below 5
MAX_INSTRUCTIONS = 1_000_000  # of a pickle; a motion has some hundreds, a few per array
_ALWAYS_ALLOWED = 2**20  # [bytes] of a decompressed file, whatever the ratio
_COMPRESSED = (b"\x78", b"\x1f\x8b")  # zlib, gzip
_Usual: Any = pickle._Unpickler  # in Python: joblib's arrays lie between the instructions


def read_pickle(path: str | Path, remedy: str) -> Any:
    """Return the contents of a pickle, joblib or torch file of plain arrays.

    Returns:
        Dictionaries, lists and tuples of arrays, numbers and words.
    """
    raw = read_bytes(path, MAX_BYTES)
    try:
        if raw[:4] == b"PK\x03\x04":
            return _read_torch(raw)
        return _Reader(io.BytesIO(_decompressed(raw))).load()
    except Refused as refused:
        raise FileError(path, f"{refused}; nothing of it was run", remedy=remedy) from refused
    except MemoryError:
        raise
    except Exception as error:  # damaged bytes make the machine fail in almost any way
        reason = type(error).__name__
        problem = f"is not a whole pickle of plain arrays ({reason})"
        raise FileError(path, problem, remedy=remedy) from error


def is_compressed(head: bytes) -> bool:
    """Return whether a file starts as one that joblib compressed with zlib or gzip."""
    return head.startswith(_COMPRESSED)


def _decompressed(raw: bytes) -> bytes:
    if not is_compressed(raw):
        return raw
    most = min(MAX_BYTES, max(_ALWAYS_ALLOWED, MAX_RATIO * len(raw)))
    stream = zlib.decompressobj(wbits=47)  # 32 + 15: zlib or gzip
    out = stream.decompress(raw, most)
    if not stream.eof:
        raise Refused("is cut off or decompresses to more than a motion holds")
    return out


def _read_torch(raw: bytes) -> Any:
    """Return the contents of a file of ``torch.save`` (version 1.6 or later)."""
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        names = set(archive.namelist())
        main = next((name for name in sorted(names) if name.endswith("/data.pkl")), None)
        if main is None:
            raise Refused("is a zip archive, but not one of torch.save")
        if sum(info.file_size for info in archive.infolist()) > MAX_BYTES:
            raise Refused("decompresses to more than a motion holds")
        base, storages = main.removesuffix("data.pkl"), {}
        if f"{base}byteorder" in names and archive.read(f"{base}byteorder") != b"little":
            raise Refused("has tensors in big-endian byte order")

        def storage(key: str) -> bytes:
            if key not in storages:  # one copy, however often a pickle names it
                storages[key] = archive.read(f"{base}data/{key}")
            return storages[key]

        return _Reader(io.BytesIO(archive.read(main)), storage).load()


class _Reader(_Usual):
    """Machine with few instructions; everything that is called is in ``MAKERS``."""

    def __init__(self, stream: io.BytesIO, storage: Callable[[str], bytes] | None = None):
        super().__init__(stream, encoding="latin1")
        self.stream, self.storage = stream, storage
        self.n_instructions = self.n_bytes = 0

    def find_class(self, module: str, name: str) -> Any:
        """Return the replacement of a function or type."""
        if module == "torch" and name in STORAGES:
            return Type(np.dtype(STORAGES[name]))
        if (module, name) not in MAKERS:
            raise Refused(f"names {module}.{name}, and only arrays, numbers and words are read")
        return MAKERS[module, name]

    def persistent_load(self, pid: Any) -> Storage:
        """Return the storage of a tensor."""
        if self.storage is None or not (isinstance(pid, tuple) and len(pid) == 5):
            raise Refused("refers to something outside the file")
        _, kind, key, _, n = pid
        if not isinstance(kind, Type):
            raise Refused("holds a tensor of an unknown type")
        return Storage(np.frombuffer(self.storage(str(key)), kind.dtype, count=int(n)))

    def load_reduce(self) -> None:
        """Call a replacement."""
        arguments, maker = self.stack.pop(), self.stack[-1]
        if not (isinstance(maker, Maker) and isinstance(arguments, tuple)):
            raise Refused("calls what is no function")
        self.stack[-1] = self._limited(maker.make(*arguments))

    def load_build(self) -> None:
        """Give an array, a type or a header of joblib its contents."""
        state, made = self.stack.pop(), self.stack[-1]
        if isinstance(made, EmptyArray):
            self.stack[-1] = self._limited(filled(*state))
        elif isinstance(made, Type):
            if state[1] in ("<", ">"):
                made.dtype = made.dtype.newbyteorder(state[1])
        elif isinstance(made, JoblibArray) and isinstance(state, dict):
            made.state = state
            self.stack[-1] = self._following(made)
        else:
            raise Refused("gives contents to something that is no array")

    def _limited(self, made: Any) -> Any:
        """Return what was made, unless all of it together is larger than a file may be."""
        self.n_bytes += made.nbytes if isinstance(made, np.ndarray) else 0
        self.n_bytes += len(made) if isinstance(made, bytes) else 0
        if self.n_bytes > 2 * MAX_BYTES:  # the bytes of an array and the array itself
            raise Refused("uses the same numbers again and again")
        return made

    def _following(self, header: JoblibArray) -> np.ndarray:
        """Return the array whose bytes follow in the stream."""
        if header.state.get("numpy_array_alignment_bytes") is not None:
            self.stream.read(self.stream.read(1)[0])
        shape, dtype = header.state["shape"], header.state["dtype"]
        size = count(shape) * plain(dtype).itemsize
        raw = self.stream.read(size)
        if len(raw) != size:
            raise Refused("ends within an array")
        return filled(1, shape, dtype, header.state["order"] == "F", raw)

    def load_bytearray8(self) -> None:
        """Push bytes; the usual reader reserves the memory before it reads them."""
        (size,) = np.frombuffer(self.read(8), "<u8")
        self.append(self.read(int(size)))

    def load_setitem(self) -> None:
        """Set one entry of a dictionary."""
        value, key = self.stack.pop(), self.stack.pop()
        set_items(self.stack[-1], [key, value])

    def load_setitems(self) -> None:
        """Set entries of a dictionary."""
        items = self.pop_mark()
        set_items(self.stack[-1], items)

    def load_dict(self) -> None:
        """Make a dictionary."""
        made: dict = {}
        set_items(made, self.pop_mark())
        self.append(made)

    def load_appends(self) -> None:
        """Append to a list."""
        items = self.pop_mark()
        list_of(self.stack[-1]).extend(items)

    def load_append(self) -> None:
        """Append one item to a list."""
        item = self.stack.pop()
        list_of(self.stack[-1]).append(item)

    def load_refused(self) -> None:
        """Refuse an instruction."""
        raise Refused("holds an instruction that arrays, numbers and words do not need")


_INSTRUCTIONS = (
    "PROTO FRAME STOP MARK POP POP_MARK NONE NEWTRUE NEWFALSE INT BININT BININT1 BININT2 LONG1 "
    "LONG FLOAT BINFLOAT STRING BINSTRING SHORT_BINSTRING UNICODE BINUNICODE SHORT_BINUNICODE "
    "BINUNICODE8 BINBYTES SHORT_BINBYTES BINBYTES8 EMPTY_TUPLE TUPLE1 TUPLE2 TUPLE3 TUPLE "
    "EMPTY_LIST LIST EMPTY_DICT GET BINGET LONG_BINGET PUT BINPUT LONG_BINPUT MEMOIZE GLOBAL "
    "STACK_GLOBAL BINPERSID"
).split()  # those that Python's reader runs as it is


def _dispatch() -> dict[int, Callable]:
    own = {
        pickle.REDUCE: _Reader.load_reduce,
        pickle.NEWOBJ: _Reader.load_reduce,  # of a header of joblib: the same, without arguments
        pickle.BUILD: _Reader.load_build,
        pickle.BYTEARRAY8: _Reader.load_bytearray8,
        pickle.SETITEM: _Reader.load_setitem,
        pickle.SETITEMS: _Reader.load_setitems,
        pickle.DICT: _Reader.load_dict,
        pickle.APPEND: _Reader.load_append,
        pickle.APPENDS: _Reader.load_appends,
    }
    usual = _Usual.dispatch
    codes = {getattr(pickle, name)[0] for name in _INSTRUCTIONS}
    refused = dict.fromkeys(range(256), _Reader.load_refused)
    kept = {code: usual[code] for code in codes}
    known = refused | kept | {code[0]: function for code, function in own.items()}
    return {code: _counted(function) for code, function in known.items()}


def _counted(function: Callable[["_Reader"], None]) -> Callable[["_Reader"], None]:
    """Return an instruction that ends a pickle of too many: each may make an object."""

    def run(reader: "_Reader") -> None:
        reader.n_instructions += 1
        if reader.n_instructions > MAX_INSTRUCTIONS:
            raise Refused("holds more objects than a motion has")
        function(reader)

    return run


_Reader.dispatch = _dispatch()
