"""Learning of tasks from demonstrations: a rule, who fills its roles, and the evidence for each condition."""
