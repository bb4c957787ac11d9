"""Tracking: from two films to a measured trajectory."""
