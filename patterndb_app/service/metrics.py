"""What the service counts, in the text that Prometheus reads, and its line of log for a request."""

from __future__ import annotations

import json
import logging
import os
import threading
import time
from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

LOG = logging.getLogger("patterndb.service")

#: Upper bounds of the histograms' buckets, seconds.
BUCKETS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)

#: What each counter and histogram counts, by its name.
HELP = {
    "patterndb_requests_total": "Requests answered, by method, route and status.",
    "patterndb_request_seconds": "Seconds from a request's headers to its last byte, by route.",
    "patterndb_first_line_seconds": "Seconds from a question to the first line of its stream.",
    "patterndb_ended_total": "Requests whose work was ended early, by what ended it.",
    "patterndb_errors_total": "Errors that no one foresaw, those of databases included.",
}

Labels = tuple[tuple[str, str], ...]


class Metrics:
    """Counters and histograms; any thread may count."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counters: dict[str, Counter[Labels]] = {}
        self._buckets: dict[str, dict[Labels, list[float]]] = {}
        self._began = time.time()

    def count(self, name: str, by: float = 1, **labels: str) -> None:
        """Add to a counter."""
        with self._lock:
            self._counters.setdefault(name, Counter())[tuple(labels.items())] += by  # type: ignore[assignment]

    def measure(self, name: str, seconds: float, **labels: str) -> None:
        """Add to a histogram: its counts by bucket, with the sum of all at the end."""
        with self._lock:
            held = self._buckets.setdefault(name, {})
            row = held.setdefault(tuple(labels.items()), [0.0] * (len(BUCKETS) + 2))
            row[bisect_left(BUCKETS, seconds)] += 1
            row[-1] += seconds

    def format(self, gauges: Mapping[str, tuple[str, float]]) -> str:
        """All of it as text; gauges: what they show, and their values now, by name."""
        lines: list[str] = []
        with self._lock:
            for name, counter in self._counters.items():
                lines += [f"# HELP {name} {HELP[name]}", f"# TYPE {name} counter"]
                lines += [f"{name}{_braced(key)} {value:g}" for key, value in counter.items()]
            for name, rows in self._buckets.items():
                lines += [f"# HELP {name} {HELP[name]}", f"# TYPE {name} histogram"]
                for key, row in rows.items():
                    total = 0.0
                    for bound, value in zip((*BUCKETS, "+Inf"), row[:-1], strict=True):
                        total += value
                        lines.append(
                            f"{name}_bucket{_braced((*key, ('le', str(bound))))} {total:g}"
                        )
                    lines.append(f"{name}_sum{_braced(key)} {row[-1]:.6f}")
                    lines.append(f"{name}_count{_braced(key)} {total:g}")
        own = {
            "process_start_time_seconds": ("When the process began, of the epoch.", self._began),
            "process_resident_memory_bytes": ("Memory of the process.", float(read_memory())),
        }
        for name, (what, value) in {**gauges, **own}.items():
            lines += [f"# HELP {name} {what}", f"# TYPE {name} gauge", f"{name} {value:.10g}"]
        return "\n".join((*lines, ""))


def _braced(labels: Labels) -> str:
    inner = ",".join(f"{name}={json.dumps(value)}" for name, value in labels)
    return f"{{{inner}}}" if inner else ""


def read_memory() -> int:
    """Bytes of memory that this process has; 0 where the system does not tell."""
    try:
        pages = Path("/proc/self/statm").read_text().split()[1]
    except (OSError, IndexError):
        return 0
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


def log_request(**entries: object) -> None:
    """Write one line of log: a JSON object."""
    LOG.info(json.dumps({"time": round(time.time(), 3), **entries}, separators=(",", ":")))
