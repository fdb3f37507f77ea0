"""Recording of a simulation: samples, contacts, pictures."""
