"""Values, errors, YAML, JSON, units, seeds and run directories; nothing here knows of robots."""
