"""Interactive simulation in real time, independent of its display.

A :class:`~plantigrade.live.session.Session` is a world and a controller that a user changes while
it runs; a :class:`~plantigrade.live.clock.Clock` keeps it in real time. Drawing and controls are in
:mod:`plantigrade.pages`.
"""
