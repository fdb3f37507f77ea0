"""Programs on real arms: what to expect of a program, and the comparison of an arm's log with the proof."""
