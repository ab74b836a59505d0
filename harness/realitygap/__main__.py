"""`python -m realitygap`: the command line."""

from realitygap.cli.entry import main

main()
