"""Run the command line: `python -m ghostball` is the same as `ghostball`."""

from ghostball.cli import main

main()
