"""cramlite inside other frameworks: behaviour trees (py_trees) and symbolic planners (unified-planning)."""
