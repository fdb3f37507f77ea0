"""Predicates that rules may use: relations, motions, phases of poses."""
