"""Arms that MJCF and URDF files describe, as robots of cramlite."""
