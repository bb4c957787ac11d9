"""Orbits beside runs: what becomes of a run, and verdicts of sweeps against orbits."""
