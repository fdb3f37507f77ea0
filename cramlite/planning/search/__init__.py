"""Search: the actions of a task sequence are grounded, designator by designator, until all are bound or the budget is spent."""
