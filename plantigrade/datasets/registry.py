"""The public data sets: names, licences, and the address and checksum of every file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from plantigrade.errors import ParameterError, known_names
from plantigrade.toml import parse_toml, read_toml

REGISTRY = Path(__file__).with_name("public_data.toml")  # File that lists the data sets
HOST = "https://raw.githubusercontent.com"
"""Address of the public files; mirrors serve the same paths."""
PAGE = "https://github.com"  # Address of the web pages of the same files


@dataclass(frozen=True)
class PublicFile:
    """A file of a public data set."""

    to: str  #: Place in the folder of the data, with slashes
    address: str  #: Path below :data:`HOST` or a mirror, quoted: /owner/repository/commit/path
    n_bytes: int  #: Length [bytes]
    sha256: str  #: Checksum, 64 hexadecimal digits

    def url(self, mirror: str = HOST) -> str:
        """Return the address of the file on a mirror."""
        return mirror.rstrip("/") + self.address


@dataclass(frozen=True)
class DataSet:
    """A public data set."""

    name: str  #: Name on the command line
    about: str  #: Its contents
    use: str  #: Purpose
    licence: str  #: Name of the licence, or what it allows
    terms: tuple[str, ...]  #: Files of the set that hold the text of the licence
    cite: str  #: Citation
    folder: str  #: Folder of its recordings in the folder of the data
    pages: tuple[str, ...]  #: Addresses of its sources, for people
    files: tuple[PublicFile, ...]  #: Its files, the text of the licence among them

    @property
    def n_bytes(self) -> int:
        """Length of all files [bytes]."""
        return sum(file.n_bytes for file in self.files)

    @property
    def licence_urls(self) -> tuple[str, ...]:
        """Addresses of the text of the licence."""
        return tuple(file.url() for file in self.files if file.to in self.terms)


def data_sets() -> dict[str, DataSet]:
    """Return the public data sets by name."""
    document = parse_toml(read_toml(REGISTRY), REGISTRY)
    sets = [_data_set(entry) for entry in document["set"]]
    return {each.name: each for each in sets}


def data_set(name: str) -> DataSet:
    """Return a public data set.

    Raises:
        ParameterError: If there is none of that name; the message lists the nearest first.
    """
    known = data_sets()
    if not isinstance(name, str) or name not in known:
        raise ParameterError(f"no data set {name!r}; {known_names(str(name), list(known))}")
    return known[name]


def _data_set(entry: Mapping[str, Any]) -> DataSet:
    places = [f"{source['repository']}/tree/{source['commit']}" for source in entry["source"]]
    files = [_file(each, source) for source in entry["source"] for each in source["files"]]
    words = {key: entry[key] for key in ("name", "about", "use", "licence", "cite", "folder")}
    pages = tuple(f"{PAGE}/{place}" for place in places)
    return DataSet(**words, terms=tuple(entry["terms"]), pages=pages, files=tuple(files))


def _file(entry: Mapping[str, Any], source: Mapping[str, Any]) -> PublicFile:
    address = quote(f"/{source['repository']}/{source['commit']}/{entry['path']}")
    return PublicFile(entry["to"], address, entry["bytes"], entry["sha256"])
