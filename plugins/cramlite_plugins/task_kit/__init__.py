"""What task types share: bases of tasks and preconditions."""
