"""Calibration of cameras: from pictures of a printed board, where a camera is and how it sees."""
