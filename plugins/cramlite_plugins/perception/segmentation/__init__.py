"""Segmentation of depth images: planes, segments, obstacles."""
