"""Exporters: recorded runs in formats that other software opens."""
