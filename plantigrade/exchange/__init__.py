"""Runs as files of other programs: :func:`export`, and every format in :data:`FORMATS`."""

from typing import TYPE_CHECKING

from plantigrade.lazy import lazy

if TYPE_CHECKING:
    from plantigrade.exchange.formats import FORMATS, ExportFormat, export

__all__ = ["FORMATS", "ExportFormat", "export"]

__getattr__ = lazy(__name__)
