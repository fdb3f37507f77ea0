"""Values, errors, YAML, JSON, units, seeds and run directories: what knows nothing of robots."""
