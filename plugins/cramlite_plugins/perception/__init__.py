"""Perception experts: segmentation, classification, pose estimation and relations from RGB-D views."""
