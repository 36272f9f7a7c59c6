"""CasADi functions evaluated at many nodes at once, with vector instructions."""

from plantigrade.batched.function import BatchedFunction

__all__ = ["BatchedFunction"]
