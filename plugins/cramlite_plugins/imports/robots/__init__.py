"""Arms that other programs describe, MJCF and URDF, as robots of cramlite."""
