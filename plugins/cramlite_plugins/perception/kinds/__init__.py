"""Kinds that are told apart by their print: appearance, explanation of clusters, hypotheses."""
