"""Public data sets: which there are, and their download; nothing is downloaded without being asked.

The files of a set stand at fixed commits of public repositories (``public_data.toml``); each is
checked by its length and SHA-256 before it gets its name.
"""

from plantigrade.datasets.get import get_data
from plantigrade.datasets.registry import DataSet, PublicFile, data_set, data_sets

__all__ = ["DataSet", "PublicFile", "data_set", "data_sets", "get_data"]
