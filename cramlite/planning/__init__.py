"""Task and motion planning: a goal becomes task sequences, and a sequence is grounded by search."""
