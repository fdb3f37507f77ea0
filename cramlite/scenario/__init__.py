"""Scenarios: YAML becomes specifications and worlds."""
