"""A world that runs in real time while somebody looks on and interferes: without any page.

A :class:`~plantigrade.live.session.Session` is a world, a controller and what a person changes of
both; a :class:`~plantigrade.live.clock.Clock` keeps it to real time. What is drawn of it, and how
it is handled, lies in :mod:`plantigrade.pages`.
"""
