"""A simulated depth camera: rays, noise, views."""
