"""6D pose estimation: registration of a model with a point cloud, its priors and its score."""
