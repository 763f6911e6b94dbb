"""``python -m patterndb``: the command line."""

from patterndb_app.__main__ import main

main()
