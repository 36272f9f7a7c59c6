"""From a problem to what a solver moves: mesh, variables, derivatives."""
