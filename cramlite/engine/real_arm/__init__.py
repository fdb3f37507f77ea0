"""Real arms: what to expect of a program on one, and the comparison of its log with the proof."""
