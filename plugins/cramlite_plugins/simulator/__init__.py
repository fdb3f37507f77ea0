"""The simulator as a plugin: one front for all that is simulated."""
