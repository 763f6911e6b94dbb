"""Where the program begins: the command line, and what is said where it cannot even be loaded."""

from __future__ import annotations

import sys
import time


def main() -> None:
    """Run the command line."""
    # A time limit counts from here.
    began = time.perf_counter()
    try:
        from patterndb_app.cli import main as run
    except OSError as error:
        # Too few descriptors (ulimit -n) to read one module after another, say.
        sys.stderr.write(f"patterndb: the program cannot be loaded: {error}\n")
        sys.exit(3)
    except KeyboardInterrupt:
        sys.stderr.write("\ninterrupted\n")
        sys.exit(130)
    run(began)


if __name__ == "__main__":
    main()
