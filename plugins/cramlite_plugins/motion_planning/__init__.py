"""Collision-free motion planning: joint-space paths, straight lines, base motions."""
