"""``python -m patterndb``: the command line."""

from patterndb_app.cli import main

main()
