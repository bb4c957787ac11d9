"""The engine: scenarios in, runs out. The only time loop, on CPU threads or a GPU."""
