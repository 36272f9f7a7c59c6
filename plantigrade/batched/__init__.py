"""CasADi functions evaluated at many nodes at once, with vector instructions.

:class:`BatchedFunction` is all the rest of the package uses; the other modules of this room serve
it alone.
"""

from plantigrade.batched.function import BatchedFunction

__all__ = ["BatchedFunction"]
