"""Detection of contacts, supports, grasps and similar states in recorded poses and contact forces."""
