"""What stands in for the functions that NumPy, joblib and torch name in pickles of arrays.

Each checks type, shape and length of what it gets; nothing of those libraries is called.
"""

import math
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

_DTYPE = re.compile(r"[<>|=]?(?:[biuf][1248]|[bSUV?]\d{0,4}|f16|c8|c16)")
_KEYS = (str, int, float, bytes, np.generic)  # a nested tuple takes exponential time to hash
STORAGES = {"FloatStorage": "<f4", "DoubleStorage": "<f8", "HalfStorage": "<f2",
             "LongStorage": "<i8", "IntStorage": "<i4", "ShortStorage": "<i2",
             "CharStorage": "i1", "ByteStorage": "u1", "BoolStorage": "?"}  # fmt: skip


class Refused(Exception):
    """The pickle needs something that is not allowed; the message says what."""


@dataclass(frozen=True)
class Maker:
    """Replacement of a function that a pickle may name."""

    make: Callable[..., Any]


@dataclass
class Type:
    """NumPy data type under construction."""

    dtype: np.dtype


@dataclass
class JoblibArray:
    """Header of an array whose bytes follow in the stream of joblib."""

    state: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Storage:
    """Numbers of torch tensors, a flat array."""

    numbers: np.ndarray


class EmptyArray:
    """Array under construction by NumPy's pickles."""


def set_items(target: Any, items: list) -> None:
    """Set entries of a dictionary, given as keys and values in turn."""
    if not isinstance(target, dict):
        raise Refused("gives entries to something that is no dictionary")
    keys = items[::2]
    if not all(isinstance(key, _KEYS) for key in keys):
        raise Refused("holds a dictionary whose keys are neither words nor numbers")
    target.update(zip(keys, items[1::2], strict=True))


def list_of(target: Any) -> list:
    """Return what must be a list."""
    if not isinstance(target, list):
        raise Refused("appends to something that is no list")
    return target


def _dictionary(*given: Any) -> dict:
    """Return a dictionary of pairs; a default factory before them is ignored."""
    made: dict = {}
    pairs = given[-1] if given and isinstance(given[-1], list) else []
    set_items(made, [each for key, value in pairs for each in (key, value)])
    return made


def _data_type(name: Any, *_: Any) -> Type:
    name = name.decode("latin1") if isinstance(name, bytes) else name
    if not (isinstance(name, str) and _DTYPE.fullmatch(name)):
        raise Refused("holds an array of objects")
    return Type(np.dtype(name))


def plain(made: Any) -> np.dtype:
    """Return the data type of what must be one."""
    if not isinstance(made, Type):
        raise Refused("holds an array of an unknown type")
    return made.dtype


def count(shape: Any) -> int:
    """Return the number of entries of a shape."""
    if not (isinstance(shape, tuple) and all(type(n) is int and n >= 0 for n in shape)):
        raise Refused("holds an array of an impossible shape")
    return math.prod(shape)


def filled(_: Any, shape: Any, made: Any, fortran: Any, raw: Any) -> np.ndarray:
    """Return the array that NumPy's pickles and joblib's describe."""
    raw = raw.encode("latin1") if isinstance(raw, str) else raw
    if not isinstance(raw, bytes):
        raise Refused("holds an array of objects")
    if len(raw) != count(shape) * plain(made).itemsize:
        raise Refused("holds an array with another number of bytes than its shape needs")
    array = np.frombuffer(raw, plain(made)).reshape(shape, order="F" if fortran else "C")
    if array.dtype.kind == "U" and array.size and array.itemsize:
        native = np.ascontiguousarray(array, array.dtype.newbyteorder("="))
        if np.frombuffer(native.tobytes(), np.uint32).max() > sys.maxunicode:
            raise Refused("holds words with characters that do not exist")
    return array


def _tensor(storage: Any, offset: Any, shape: Any, stride: Any, *_: Any) -> np.ndarray:
    """Return a tensor, a view of a storage."""
    if not isinstance(storage, Storage) or type(offset) is not int:
        raise Refused("holds a tensor of an unknown kind")
    n, numbers = count(shape), storage.numbers
    count(stride)
    last = offset + sum((size - 1) * step for size, step in zip(shape, stride, strict=True))
    if offset < 0 or n > numbers.size or (n and last >= numbers.size):
        raise Refused("holds a tensor that reaches beyond its storage")
    strides = [step * numbers.itemsize for step in stride]
    return np.lib.stride_tricks.as_strided(numbers[offset:], shape, strides, writeable=False)


def _encoded(text: Any, encoding: Any) -> bytes:
    if not isinstance(text, str) or encoding != "latin1":
        raise Refused("holds words in an unknown encoding")
    return text.encode("latin1")


MAKERS: dict[tuple[str, str], Maker] = {
    **{
        (module, name): Maker(_dictionary)
        for module, name in (
            ("collections", "OrderedDict"),
            ("collections", "defaultdict"),
            ("builtins", "dict"),
            ("builtins", "list"),  # a default factory, which is not called
            ("__builtin__", "dict"),
            ("__builtin__", "list"),
        )
    },
    ("__builtin__", "bytes"): Maker(lambda: b""),  # an empty one: Python 3 writes it as a call
    ("_codecs", "encode"): Maker(_encoded),
    ("numpy", "ndarray"): Maker(EmptyArray),
    ("numpy", "dtype"): Maker(_data_type),
    **{
        (f"numpy.{core}.{module}", name): Maker(make)
        for core in ("core", "_core")
        for module, name, make in (
            ("multiarray", "_reconstruct", lambda *_: EmptyArray()),
            ("multiarray", "scalar", lambda made, raw=b"": filled(1, (), made, False, raw)[()]),
            (
                "numeric",
                "_frombuffer",
                lambda raw, made, shape, order: filled(1, shape, made, order == "F", raw),
            ),
        )
    },
    ("joblib.numpy_pickle", "NumpyArrayWrapper"): Maker(JoblibArray),
    ("torch._utils", "_rebuild_tensor_v2"): Maker(_tensor),
    ("torch._utils", "_rebuild_parameter"): Maker(lambda data, *_: data),
    ("torch", "Size"): Maker(tuple),
    ("torch", "device"): Maker(lambda *_: None),
}
