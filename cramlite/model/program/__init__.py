"""Typed programs: their steps, their text, safety rules, and slower copies."""
