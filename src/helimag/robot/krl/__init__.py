"""KUKA Robot Language: programmes written, read back and compared with their plan."""
