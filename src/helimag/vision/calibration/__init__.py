"""Calibration of two cameras and the walls that they look through."""
