"""Kinds that are told apart by what is printed on them: appearance, explanation of clusters, hypotheses."""
