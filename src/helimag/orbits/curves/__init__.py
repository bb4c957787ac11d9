"""Orbits followed through inputs: branches, stable intervals, maps and boundaries of stability."""
