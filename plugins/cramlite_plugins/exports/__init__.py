"""Exporters: recorded runs in formats that other programs open."""
