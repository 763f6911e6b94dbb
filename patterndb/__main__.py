"""``python -m patterndb``: the command line."""

from patterndb.cli import main

main()
