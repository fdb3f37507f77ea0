"""Scenarios: specifications and worlds from YAML."""
