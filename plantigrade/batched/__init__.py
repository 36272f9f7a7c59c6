"""Functions of CasADi evaluated at many nodes at once, with vector instructions."""
