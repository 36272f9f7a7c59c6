"""Terms of a task: constraints and costs, each a small class, by subject."""
