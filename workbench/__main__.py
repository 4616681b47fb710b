"""The command line as a module: `python -m workbench`."""

from workbench.cli.command import main

main()
