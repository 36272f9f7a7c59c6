"""Contact sites, contact plans, ground and scene objects."""
