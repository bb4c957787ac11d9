"""The stroboscopic map of one turn of the magnet, its fixed points and their stability."""
