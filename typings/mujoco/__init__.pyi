# MuJoCo's compiled modules say nothing about their types: what is taken from them is unknown to the
# checker, rather than an error at every use.
from typing import Any

def __getattr__(name: str) -> Any: ...
