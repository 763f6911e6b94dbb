"""Time the readers on a generated grid of 500,000 quads.

    python benchmarks/read_speed.py

Prints one JSON document: for each format the size of the file, and the median of three reads
from disk in seconds. ``split`` is the baseline: the time Python takes to cut the OBJ text into
lines and tokens, and convert nothing.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ingest.formats import read_mesh

REPEATS = 3

Writer = Callable[[NDArray[np.float64], NDArray[np.int64]], bytes]


def grid(n_quads: int, seed: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points (v, 3) with random heights, and quads (q, 4) of a square grid of about n quads."""
    side = round(n_quads**0.5)
    x, y = np.meshgrid(np.arange(side + 1), np.arange(side + 1))
    z = np.random.default_rng(seed).normal(size=x.shape)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    return (
        np.stack([x, y, z], axis=-1).reshape(-1, 3) / side,
        first[:, None] + (0, 1, side + 2, side + 1),
    )


def obj(points: NDArray[np.float64], quads: NDArray[np.int64]) -> bytes:
    vertices = "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points.tolist())
    return (
        vertices + "".join(f"f {a} {b} {c} {d}\n" for a, b, c, d in (quads + 1).tolist())
    ).encode()


def obj_seams(points: NDArray[np.float64], quads: NDArray[np.int64]) -> bytes:
    vertices = "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points.tolist())
    vertices += "".join(f"vt {x:.6f} {y:.6f}\n" for x, y, _ in points.tolist())
    faces = (" ".join(f"{i}/{i}" for i in quad) for quad in (quads + 1).tolist())
    return (vertices + "".join(f"f {face}\n" for face in faces)).encode()


def _ply_header(order: str, n_points: int, n_faces: int) -> bytes:
    return (
        f"ply\nformat {order} 1.0\nelement vertex {n_points}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {n_faces}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()


def ply_text(points: NDArray[np.float64], quads: NDArray[np.int64]) -> bytes:
    vertices = "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points.tolist())
    faces = "".join(f"4 {a} {b} {c} {d}\n" for a, b, c, d in quads.tolist())
    return _ply_header("ascii", len(points), len(quads)) + (vertices + faces).encode()


def ply_binary(points: NDArray[np.float64], quads: NDArray[np.int64]) -> bytes:
    rows = np.empty(len(quads), [("n", "u1"), ("v", "<i4", 4)])
    rows["n"], rows["v"] = 4, quads
    header = _ply_header("binary_little_endian", len(points), len(quads))
    return header + points.astype("<f4").tobytes() + rows.tobytes()


def ply_binary_mixed(points: NDArray[np.float64], quads: NDArray[np.int64]) -> bytes:
    """Every other quad cut into two triangles."""
    triangle, quad = (
        np.dtype([("n", "u1"), ("v", "<i4", 3)]),
        np.dtype([("n", "u1"), ("v", "<i4", 4)]),
    )
    row = np.dtype([("a", quad), ("b", triangle), ("c", triangle)])
    even, odd = quads[0::2], quads[1::2][: len(quads[0::2])]
    rows = np.empty(min(len(even), len(odd)), row)
    even = even[: len(rows)]
    for name, n, corners in (
        ("a", 4, even),
        ("b", 3, odd[:, [0, 1, 2]]),
        ("c", 3, odd[:, [0, 2, 3]]),
    ):
        rows[name]["n"], rows[name]["v"] = n, corners
    header = _ply_header("binary_little_endian", len(points), 3 * len(rows))
    return header + points.astype("<f4").tobytes() + rows.tobytes()


FORMATS: dict[str, tuple[str, Writer]] = {
    "obj": (".obj", obj),
    "obj_seams": (".obj", obj_seams),
    "ply_text": (".ply", ply_text),
    "ply_binary": (".ply", ply_binary),
    "ply_binary_mixed": (".ply", ply_binary_mixed),
}


def median_seconds(task: Callable[[], object]) -> float:
    times: list[float] = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        task()
        times.append(time.perf_counter() - begin)
    return round(statistics.median(times), 3)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quads", type=int, default=500_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    points, quads = grid(options.quads, options.seed)
    text = obj(points, quads)
    result: dict[str, object] = {
        "quads": len(quads),
        "split": {"seconds": median_seconds(lambda: [line.split() for line in text.split(b"\n")])},
    }
    with tempfile.TemporaryDirectory() as folder:
        for name, (suffix, write) in FORMATS.items():
            path = Path(folder) / f"{name}{suffix}"
            path.write_bytes(write(points, quads))
            result[name] = {
                "bytes": path.stat().st_size,
                "seconds": median_seconds(lambda path=path: read_mesh(path)),
            }
    print(json.dumps(result, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
