"""The command line as a module: `python -m workbench`."""

from workbench.cli import main

main()
