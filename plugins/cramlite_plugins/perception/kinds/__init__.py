"""Kinds that are told apart by their printed texture: appearance, explanation of clusters, hypotheses."""
