"""`python -m realitygap`: the command line."""

from realitygap.cli.main import main

main()
