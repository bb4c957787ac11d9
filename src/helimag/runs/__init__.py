"""Runs: what one is, wherever it came from, and how it is judged, measured, compared, read and written."""
