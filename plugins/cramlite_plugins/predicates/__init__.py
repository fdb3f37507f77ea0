"""Predicates that rules may use: relations, motions, places."""
