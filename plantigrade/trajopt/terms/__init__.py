"""What a task is made of: conditions and costs, each a small class, by subject."""
