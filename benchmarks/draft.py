"""Drafts of whole surfaces next to QuadriFlow and Instant Meshes, at equal numbers of quads.

    python benchmarks/draft.py [--quads N | --edge SHARE] [--by draft,quadriflow,...]
        [--peers PYTHON] [--meshes FOLDER] SURFACE.obj ...

Every draft is a whole process, `patterndb retopo SURFACE --draft`, after one that is not counted
(the database is unpacked); CPU seconds are user and system time, with the start.
Peers run in another Python (`--peers`) that has pyQuadriFlow and pyinstantmeshes, which are no
dependencies; their CPU seconds are of the call alone. With --quads all are asked for as many quads;
else the draft has edges of a share of the diagonal, and the peers are asked for as many quads as it
has. --meshes keeps what was made. A run of more CPU seconds than --limit is ended. With --rows each
row is added to a file as it comes, and those that are in it already are not made again. Prints
Markdown, then medians:

- irregular: vertices with other than 4 quads (2 on a border), per 1,000 quads
- spread: standard deviation of edge lengths over their mean
- below .3: quads with a scaled Jacobian below .3, per 1,000; turned: 0 or less
- Euler: of the mesh, and of the surface
- to, from: greatest distance from the surface to the quads and back, % of the diagonal, at samples
- kept: the share of the surface's edges above 40 degrees, by length, that lie within .3 % of the
  diagonal of an edge of the mesh
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ingest.formats import read_mesh, write_mesh
from patterndb.core.halfedge import Int32Array
from patterndb.geometry.points import Points
from patterndb.geometry.quadshape import scaled_jacobian
from patterndb.geometry.surface import Surface
from patterndb_sketch.retopo.draft.creases import measure_dihedrals
from patterndb_sketch.retopo.filling.report import cut_quads

ROOT = Path(__file__).parents[1]

#: Degrees above which an edge of the surface counts as sharp, and shares of the diagonal: spacing
#: of samples, and how near an edge of the mesh must be.
SHARP, SPACING, NEAR = 40.0, 0.002, 0.003

#: Samples of a surface for distances.
SAMPLES = 150_000

METHODS = ("draft", "quadriflow", "quadriflow-sharp", "instant-meshes")

#: What the other Python runs: triangles in, faces and CPU seconds out. Instant Meshes gives quads
#: as pairs of triangles.
PEER = """
import sys, time
import numpy as np
given = np.load(sys.argv[1], allow_pickle=False)
by, wanted = sys.argv[2], int(sys.argv[3])
began = time.process_time()
if by.startswith("quadriflow"):
    from pyQuadriFlow.pyQuadriFlow import pyquadriflow
    made = pyquadriflow(wanted, 0, given["vertices"], given["triangles"], by.endswith("sharp"),
                        False, False, False, False)
    vertices, faces = made["vertices"], made["faces"]
else:
    import pyinstantmeshes
    vertices, faces = pyinstantmeshes.remesh(
        given["vertices"].astype(np.float32), given["triangles"].astype(np.int32),
        target_face_count=max(wanted // 4, 8), align_to_boundaries=True, pure_quad=True,
        deterministic=True)
seconds = time.process_time() - began
vertices = np.asarray(vertices, float)
np.savez(sys.argv[4], vertices=vertices, faces=np.asarray(faces), seconds=seconds)
"""


@dataclass(frozen=True, slots=True)
class Row:
    """The measures of one mesh; see the module."""

    quads: int
    irregular: float
    spread: float
    below: float
    turned: int
    open: int
    euler: int
    euler_surface: int
    to: float
    back: float
    kept: float
    cpu: float


def list_edges(faces: Int32Array) -> tuple[Int32Array, NDArray[np.integer]]:
    """Return (e, 2) the edges of faces (f, n), and how many faces each has."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    return np.unique(np.sort(ends, axis=1), axis=0, return_counts=True)


def count_euler(faces: Int32Array) -> int:
    """Return V - E + F."""
    return len(np.unique(faces)) - len(list_edges(faces)[0]) + len(faces)


def sample_triangles(corners: Points, n: int, seed: int) -> Points:
    """Return (n, 3) random points on triangles (t, 3, 3), by area."""
    rng = np.random.default_rng(seed)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    chosen = corners[rng.choice(len(corners), n, p=area / area.sum())]
    share = rng.random((n, 2, 1))
    share = np.where(share.sum(axis=1, keepdims=True) > 1.0, 1.0 - share, share)
    first = chosen[:, 0]
    return first + share[:, 0] * (chosen[:, 1] - first) + share[:, 1] * (chosen[:, 2] - first)


def sample_edges(ends: Points, spacing: float) -> tuple[Points, NDArray[np.float64]]:
    """Return points along edges (e, 2, 3), and the length that each stands for."""
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    parts = np.maximum(np.ceil(length / spacing), 1).astype(int)
    edge = np.repeat(np.arange(len(ends)), parts)
    share = np.concatenate([(np.arange(n) + 0.5) / n for n in parts.tolist()] or [np.empty(0)])
    points = ends[edge, 0] + share[:, None] * (ends[edge, 1] - ends[edge, 0])
    return points, (length / parts)[edge]


def measure(surface: Surface, vertices: Points, quads: Int32Array, cpu: float) -> Row:
    """Measure a mesh of quads on a surface."""
    diagonal = surface.diagonal
    edges, uses = list_edges(quads)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    shape = scaled_jacobian(quads, vertices)
    valence = np.bincount(quads.ravel(), minlength=len(vertices))
    border = np.zeros(len(vertices), np.bool_)
    border[edges[uses == 1]] = True
    # A border vertex with one quad is a corner.
    odd = (valence != np.where(border, 2, 4)) & (valence > 0) & ~(border & (valence == 1))
    given = surface.vertices[surface.triangles]
    made = vertices[cut_quads(vertices, quads)]
    to = KDTree(sample_triangles(made, SAMPLES, 0)).query(sample_triangles(given, SAMPLES // 5, 1))
    back = KDTree(sample_triangles(given, SAMPLES, 2)).query(
        sample_triangles(made, SAMPLES // 5, 3)
    )
    ends, angle = measure_dihedrals(surface)
    sharp, weight = sample_edges(surface.vertices[ends[angle > SHARP]], SPACING * diagonal)
    kept = float("nan")
    if len(sharp):
        near, _ = sample_edges(vertices[edges], 0.2 * SPACING * diagonal)
        off, _ = KDTree(near).query(sharp)
        kept = float(weight[off < NEAR * diagonal].sum() / weight.sum())
    per = 1000.0 / len(quads)
    return Row(
        quads=len(quads),
        irregular=per * int(odd.sum()),
        spread=float(length.std() / length.mean()),
        below=per * int((shape < 0.3).sum()),
        turned=int((shape <= 0.0).sum()),
        open=int((uses == 1).sum()),
        euler=count_euler(quads),
        euler_surface=count_euler(surface.triangles),
        to=100.0 * float(to[0].max()) / diagonal,
        back=100.0 * float(back[0].max()) / diagonal,
        kept=kept,
        cpu=cpu,
    )


def run(command: Sequence[str], limit: float) -> tuple[subprocess.CompletedProcess[str], float]:
    """Run a command, ended after a limit of CPU seconds; return it, and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    limited = ["prlimit", f"--cpu={limit:.0f}", *command]
    done = subprocess.run(limited, check=False, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def make_draft(path: Path, size: Sequence[str], made: Path, limit: float) -> tuple[float, str]:
    """Draft a surface into a file; return the CPU seconds, and what was reported."""
    command = [sys.executable, "-m", "patterndb", "retopo", str(path), "--draft", *size]
    done, cpu = run([*command, "-o", str(made)], limit)
    lines = [line for line in done.stderr.splitlines() if not line.startswith("compil")]
    return cpu, "; ".join(line for line in lines if line.startswith(("draft:", "patterndb:")))


def run_peer(
    python: str, by: str, surface: Surface, wanted: int, made: Path, limit: float
) -> tuple[Points, Int32Array, float] | None:
    """Return a peer's vertices, quads and CPU seconds; None where it fails."""
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder) / "given.npz", Path(folder) / "made.npz"
        np.savez(given, vertices=surface.vertices, triangles=surface.triangles)
        run([python, "-c", PEER, str(given), by, str(wanted), str(found)], limit)
        if not found.exists():
            return None
        with np.load(found, allow_pickle=False) as arrays:
            faces = arrays["faces"].astype(np.int32)
            quads = join_triangles(faces) if faces.shape[1] == 3 else faces
            whole = (np.diff(np.sort(quads, axis=1), axis=1) > 0).all(axis=1)
            vertices, quads = arrays["vertices"], quads[whole]
            seconds = float(arrays["seconds"])
    if not len(quads):
        return None
    write_mesh(made, (vertices, quads))
    return vertices, quads, seconds


def join_triangles(triangles: Int32Array) -> Int32Array:
    """Return the quads that triangles 2 k and 2 k + 1 make."""
    quads: list[list[int]] = []
    for one, two in zip(triangles[0::2].tolist(), triangles[1::2].tolist(), strict=True):
        for k in range(3):
            tail, head = one[k], one[(k + 1) % 3]
            if tail in two and head in two:
                other = next(v for v in two if v not in (tail, head))
                quads.append([one[(k + 2) % 3], tail, other, head])
                break
    return np.array(quads, np.int32).reshape(-1, 4)


def format_row(name: str, by: str, asked: int | None, row: Row) -> str:
    """Format the table's row of a mesh."""
    cells = [
        name,
        by,
        "" if asked is None else f"{asked:,}",
        f"{row.quads:,}",
        f"{row.irregular:.1f}",
        f"{row.spread:.2f}",
        f"{row.below:.1f}",
        f"{row.turned}",
        f"{row.open}",
        f"{row.euler} ({row.euler_surface})",
        f"{row.to:.2f}",
        f"{row.back:.2f}",
        "" if np.isnan(row.kept) else f"{row.kept:.3f}",
        f"{row.cpu:.1f}",
    ]
    return "| " + " | ".join(cells) + " |"


HEAD = (
    "| surface | by | asked | quads | irregular | spread | below .3 | turned | open | Euler | to | "
    "from | kept | CPU s |\n|---|---|" + "---:|" * 12
)


class Rows:
    """Rows by surface and method, kept in a file of JSON lines if one is given."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.rows: dict[tuple[str, str], tuple[Row | None, str]] = {}
        if path is not None and path.exists():
            for line in path.read_text().splitlines():
                found = json.loads(line)
                row = None if found["row"] is None else Row(**found["row"])
                self.rows[found["surface"], found["by"]] = row, found["said"]

    def add(self, surface: str, by: str, row: Row | None, said: str) -> None:
        """Add a row; None for a surface that was refused."""
        self.rows[surface, by] = row, said
        if self.path is not None:
            line = {"surface": surface, "by": by, "row": row and asdict(row), "said": said}
            with self.path.open("a") as file:
                file.write(json.dumps(line) + "\n")


def mesh_surface(
    path: Path, by: str, asked: int | None, folder: Path, options: argparse.Namespace
) -> tuple[Row | None, str]:
    """Mesh a surface; return its row, None if it was refused, and what was reported."""
    surface = Surface.from_polygons(read_mesh(path)).orient()
    made = folder / f"{path.stem}.{by}.obj"
    made.unlink(missing_ok=True)
    if by != "draft":
        found = run_peer(options.peers, by, surface, asked or 1200, made, options.limit)
        return (None, "failed") if found is None else (measure(surface, *found), "")
    wish = ["--quads", str(options.quads)]
    if options.quads is None:
        wish = ["--edge", f"{options.edge * surface.diagonal:.6g}"]
    cpu, said = make_draft(path, [*wish, "--sharp", options.sharp], made, options.limit)
    if not made.exists():
        return None, f"{said or 'ended'} ({cpu:.1f} s)"
    mesh = read_mesh(made)
    return measure(surface, mesh.points, mesh.quads()[0], cpu), said


def main() -> None:
    """Mesh all surfaces by all methods, and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quads", type=int, help="how many quads all are asked for")
    size.add_argument("--edge", type=float, default=0.03, help="share of the diagonal")
    parser.add_argument("--by", default="draft", help=f"of {','.join(METHODS)}")
    parser.add_argument("--peers", default=sys.executable, metavar="PYTHON")
    parser.add_argument("--meshes", type=Path, metavar="FOLDER", help="where meshes are kept")
    parser.add_argument("--rows", type=Path, metavar="FILE", help="where rows are kept")
    parser.add_argument("--limit", type=float, default=600.0, help="CPU seconds of a run")
    parser.add_argument("--sharp", default="auto", help="as of patterndb retopo")
    parser.add_argument("surfaces", nargs="+", type=Path)
    options = parser.parse_args()
    methods = options.by.split(",")
    kept = Rows(options.rows)
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.meshes or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        if any((path.stem, "draft") not in kept.rows for path in options.surfaces):
            warm = ["--edge", "6", "--sharp", options.sharp]
            dog = ROOT / "examples" / "dog.obj"
            make_draft(dog, warm, Path(temporary) / "warm.obj", options.limit)
        print(HEAD, flush=True)
        for path in options.surfaces:
            asked = options.quads
            for by in methods:
                if (path.stem, by) not in kept.rows:
                    kept.add(path.stem, by, *mesh_surface(path, by, asked, folder, options))
                row, said = kept.rows[path.stem, by]
                if row is None:
                    print(f"| {path.stem} | {by} | refused |", flush=True)
                else:
                    print(format_row(path.stem, by, asked, row), flush=True)
                    asked = asked or row.quads
                if said:
                    print(f"{path.stem}: {said}", file=sys.stderr, flush=True)
    for by in methods:
        print_medians(by, [kept.rows[path.stem, by][0] for path in options.surfaces])


def print_medians(by: str, rows: Sequence[Row | None]) -> None:
    """Print the medians of a method's rows, None where it refused a surface."""
    own = [row for row in rows if row is not None]
    right = sum(row.euler == row.euler_surface for row in own)
    said = [f"{len(own)} done, {len(rows) - len(own)} not, Euler number right {right}"]
    for field in fields(Row):
        if field.name in ("irregular", "spread", "below", "to", "back", "kept", "cpu"):
            values = np.array([getattr(row, field.name) for row in own])
            if not np.isnan(values).all():
                said.append(f"{field.name} {np.nanmedian(values):.3g}")
    print(f"\n{by}: {'; '.join(said)} (medians)")


if __name__ == "__main__":
    main()
