"""Detection of force-dynamic events in poses and contacts."""
