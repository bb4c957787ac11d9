"""Two cameras: synthetic pictures, calibration with refraction, tracking, measured trajectories."""
