"""Python with ur_rtde: a typed program as a client of a UR controller."""
