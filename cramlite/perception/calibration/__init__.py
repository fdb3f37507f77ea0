"""Calibration of cameras: pose and intrinsics from pictures of a printed board."""
