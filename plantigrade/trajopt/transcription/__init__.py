"""From a problem to what solvers read: mesh, variables, linear map, derivatives, evaluation."""
