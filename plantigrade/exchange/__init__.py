"""Runs as files of other programs: :func:`export`, and every format in :data:`FORMATS`."""

from plantigrade.exchange.formats import FORMATS, Format, export

__all__ = ["FORMATS", "Format", "export"]
