"""`python -m ghostball` is the command `ghostball`."""

from ghostball.cli import main

main()
