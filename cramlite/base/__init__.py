"""Values, errors, YAML, JSON, units, seeds and run directories: no word of robots."""
