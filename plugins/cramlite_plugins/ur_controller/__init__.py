"""A virtual UR controller on the network: RTDE, dashboard and script ports, on loopback only."""
