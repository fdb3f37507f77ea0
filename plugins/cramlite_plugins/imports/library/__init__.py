"""Libraries of object models, which are made from meshes with textures and from MJCF bodies."""
