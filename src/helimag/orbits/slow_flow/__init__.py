"""The slow flow: the motion averaged over a turn, its fixed points, and basins of attraction."""
