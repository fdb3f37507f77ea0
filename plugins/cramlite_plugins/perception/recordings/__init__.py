"""Recorded views of real cameras: readers of image, depth and point cloud files."""
