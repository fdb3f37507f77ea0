"""Perception of things whose kinds differ by their printed texture: clusters of points are explained by
known models at poses."""
