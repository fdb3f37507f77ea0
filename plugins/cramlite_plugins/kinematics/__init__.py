"""Kinematics and timing of arms: forward and inverse kinematics, blends, velocity profiles."""
