"""Worlds: things with their shapes, joints, colours, kinds and friction, and the robots among them."""
