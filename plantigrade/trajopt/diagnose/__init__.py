"""Why a problem was not solved, in words."""
