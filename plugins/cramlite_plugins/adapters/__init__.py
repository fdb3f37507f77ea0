"""Adapters of cramlite to behaviour trees (py_trees) and symbolic planners (unified-planning)."""
