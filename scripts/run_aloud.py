"""Run a command, and say every second and a half that it still runs while it says nothing itself.

    python scripts/run_aloud.py "installing patterndb" python -m pip install .

For installers that are silent while they download and unpack. Needs no package. What the command
writes goes through as it comes; its exit code is that of this program.
"""

from __future__ import annotations

import subprocess
import sys
import threading
import time

#: Seconds of silence that are filled.
SILENCE = 1.5


def main() -> None:
    what, *command = sys.argv[1:]
    began = time.monotonic()
    said = [began]
    over = threading.Event()

    def fill_silence() -> None:
        while not over.wait(0.1):
            now = time.monotonic()
            if now - said[0] >= SILENCE:
                said[0] = now
                print(f"{what}: {now - began:.0f} s", file=sys.stderr, flush=True)

    threading.Thread(target=fill_silence, daemon=True).start()
    print(what, file=sys.stderr, flush=True)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        assert process.stdout is not None
        while piece := process.stdout.read1(65536):
            said[0] = time.monotonic()
            sys.stdout.buffer.write(piece)
            sys.stdout.buffer.flush()
    over.set()
    print(f"{what}: done in {time.monotonic() - began:.0f} s", file=sys.stderr)
    sys.exit(process.returncode)


if __name__ == "__main__":
    main()
