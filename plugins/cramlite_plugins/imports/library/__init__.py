"""Libraries of known kinds: meshes with textures and MJCF bodies become object models."""
