"""A trajectory problem: rows at nodes, their limits and costs."""
