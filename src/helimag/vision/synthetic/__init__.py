"""Synthetic pictures: a rig with known truth, rendered films, scores."""
