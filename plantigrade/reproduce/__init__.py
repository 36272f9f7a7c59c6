"""Motion from ordered tasks: a gait rebuilt from a recording's few, or any movement of your own."""
