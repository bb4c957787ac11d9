"""``python -m helimag``: the same as the command ``helimag``."""

from helimag.cli import main

main()
