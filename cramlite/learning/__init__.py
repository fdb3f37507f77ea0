"""Learning of tasks from demonstrations: a rule, its roles, and the evidence for each condition."""
