"""Compile the kernels, on two cores, so that the first real use need not wait for it.

    python scripts/compile_kernels.py [--times]     --times: say how long each process took

Compiled code is kept in the user's cache folder (patterndb.system.kernels), so that only kernels
whose code has changed are compiled again. Each part below uses kernels of one kind; what two parts
share is compiled by both if they run at once.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from patterndb.system.caches import KERNELS_VARIABLE, kernel_folder

EXAMPLE = Path(__file__).parents[1] / "examples" / "jug.obj"


def learn(folder: str, example: str) -> None:
    """Learn a mesh, and exchange a database with the authors' layout."""
    import ingest
    import patterndb
    from patterndb.store import read_table

    with patterndb.open(folder + "/a.db", "create") as database:
        ingest.ingest(database, [example])
        assert not database.verify()
        database.export_ddq(folder + "/ddq.db")
    with patterndb.open(folder + "/b.db", "create") as database:
        database.import_ddq(read_table(folder + "/ddq.db"))


def place_fills(folder: str, example: str) -> None:
    """Place fills in the plane and on a surface, along strokes and out of tangles, and draw them.

    The fills are put together by hand, so that no query is waited for.
    """
    import numpy as np

    from patterndb.core.pattern import Pattern
    from query import Boundary, Fill, Stroke
    from query.expand import expand_pattern
    from query.placing import Surface, find_loops, lay_flat, measure_flow_distance, place, quality
    from viewer import embed_disk
    from viewer.solid import fill_triangles

    square = Pattern.from_code(np.zeros(4, np.uint16))
    fill = expand_pattern(square, (3, 2), rotation=0, mirrored=False)
    embed_disk(fill.disk())
    points = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 2], [2, 2], [1, 0.2], [0, 2], [0, 1]]
    boundary = Boundary((3, 2, 3, 2), points=points)
    stroke = Stroke((0, 1), (2, 1), [[1.5, 0, 0], [1.7, 1, 0], [1.5, 2, 0]])
    flat = lay_flat(fill, boundary.points)
    measure_flow_distance(fill, flat, [stroke], 1)
    quality(fill.quads, flat)
    place(fill, points, None, [stroke])
    x, y = np.meshgrid(np.linspace(-1, 4, 9), np.linspace(-1, 4, 9))
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    quads = np.array([(i, i + 1, i + 10, i + 9) for i in range(71) if i % 9 < 8])
    surface = Surface.from_arrays(vertices, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))
    place(fill, points, surface, [stroke])
    five = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]]
    ring = Fill(
        quads=np.array(five, np.int32),
        n_vertices=8,
        lengths=(4,),
        pattern=square,
        widths=(1,),
        rotation=0,
        mirrored=False,
        n_irregular=4,
        origin="constructed",
    )
    assert len(find_loops(ring)) == 1
    outline = [[0, 0], [3, 0], [3, 3], [0, 3]]
    loop = Stroke.loop([[0.5, 0.5, 0], [2.5, 0.5, 0], [2.5, 2.5, 0], [0.5, 2.5, 0]])
    place(ring, outline, None, [loop])
    picture = np.zeros((4, 4, 3), np.float32)
    triangle = np.array([[[0, 0, 0], [4, 0, 0], [0, 4, 0]]], np.float64)
    fill_triangles(
        triangle, np.zeros((1, 3, 3), np.float32), np.full((4, 4), -np.inf, np.float32), picture
    )


def ask(folder: str, example: str) -> None:
    """Ask for fills: strict, relaxed, of the family, constructed, with strokes and loops."""
    import numpy as np

    # The family may be in the cache folder already; here it is grown.
    os.environ["PATTERNDB_CACHE"] = folder
    from patterndb.core.pattern import Pattern
    from patterndb.core.patternclass import PatternClass
    from query import Boundary, Stroke, best, fills

    square = Pattern.from_code(np.zeros(4, np.uint16))
    squares = PatternClass.from_patterns(4, [square])
    list(fills(squares, (3, 2, 3, 2), limit=5, order="symmetric"))
    list(fills(squares, (3, 2, 3, 2), strokes=[Stroke((0, 1), (2, 1))], limit=5))

    def ask(boundary, **options):
        return best(PatternClass.from_patterns(boundary.n_sides, []), boundary, **options)

    ask(Boundary.closed(8))
    ask(Boundary((3, 5, 4, 6)), strokes=[Stroke.loop()])
    ask(Boundary((1, 2) * 6))
    corners = ["reflex" if i in (2, 5, 9) else "convex" for i in range(10)]
    ask(Boundary((4, 3, 4, 3, 5, 4, 3, 4, 3, 5), corners), origins=("constructed",))


def make_surfaces(folder: str, example: str) -> None:
    """Join curves, find cycles, cut them along chords and make them into meshes."""
    import numpy as np

    from patterndb_sketch.surfacing import (
        Canvas,
        Settings,
        find_cycles,
        network_of_polylines,
        surface,
    )

    bent = [[x, 0, x * x] for x in np.linspace(-1, 1, 9)]
    ends = [[[x, y, 1] for y in np.linspace(0, 1, 5)] for x in (-1, 1)]
    sides = [bent, [[x, 1, z] for x, _, z in bent], *ends]
    network = network_of_polylines([*sides, [[0, -1, 0], [0, 2, 0]], bent])
    cycles = find_cycles(network).cycles
    made = surface(network, cycles, settings=Settings(area_price=None, alpha=0.0))
    surface(network, cycles, settings=Settings(method="area"))
    Canvas.of(made.points, made.triangles).pick([0.5, 0.5, 5], [0, 0, -1])


def snap_features(folder: str, example: str) -> None:
    """Snap a stroke to a clean and to a messy body, and drag the curve."""
    sys.path.insert(0, str(Path(example).parent))
    from bodies import CARS, body, degrade, stroke

    from patterndb.geometry.polyline import sampled
    from patterndb_sketch.features.drag import MatrixCamera, begin_drag, move_drag
    from patterndb_sketch.features.model import Model
    from patterndb_sketch.features.ribs import build_ribs
    from patterndb_sketch.features.snap import Snap

    car = body(sorted(CARS)[0], resolution=0.4)
    mess = degrade(car, 1, gaps=0.001, crossings=0.003)
    line = sampled(car.feature("shoulder").smooth, 11)
    for points, triangles in ((car.points, car.triangles), (mess.points, mess.triangles)):
        model = Model.from_arrays(points, triangles)
        build_ribs(model, line[1:-1], line[2:] - line[:-2])
    snapped = Snap.begin(model, stroke(car, "shoulder"))
    view = MatrixCamera.parallel([3, 2, 1], [0, 0, 0], [0, 0, 1], 3.0, (99, 99), (0.1, 9.0))
    samples = snapped.curve.samples
    move_drag(begin_drag(view, model, samples, view.seen_at(samples)[5]), model, [50, 50])
    model.outermost(line[:2], line[1:3] - line[:2])
    import numpy as np

    from viewer.camera import View
    from viewer.skin import Skin, shade_model

    skin = Skin.of(model.corners, model.triangles)
    shade_model(skin, View(np.eye(3), np.zeros(3), 1.0), (0.0, 0.0), through=False)


def draw_network(folder: str, example: str) -> None:
    """Draw strokes that cross on a sheet, a loop, a path, a patch beside others; choose counts."""
    import numpy as np

    from patterndb_sketch.retopo.counts import CountsProblem, change_count, solve_counts
    from patterndb_sketch.retopo.filling.edgecounts import count_fewest_edges
    from patterndb_sketch.retopo.ground import Ground, clean_stroke, cut_by_plane, trace_geodesic
    from patterndb_sketch.retopo.network import Network, add_borders
    from patterndb_sketch.retopo.network.flooding import flood_triangles
    from patterndb_sketch.retopo.sizes import Sizes
    from patterndb_sketch.retopo.tools.autocomplete import find_completions
    from patterndb_sketch.retopo.tools.corner import toggle_corner
    from patterndb_sketch.retopo.tools.erase import erase_crossed_chains
    from patterndb_sketch.retopo.tools.salience import Salience
    from patterndb_sketch.retopo.tools.stroke import insert_stroke

    x, y = np.meshgrid(np.linspace(0, 9, 28), np.linspace(0, 9, 28))
    vertices = np.stack([x, y, 0.1 * np.sin(x)], axis=-1).reshape(-1, 3)
    i = np.array([k for k in range(27 * 28) if k % 28 < 27])
    quads = np.stack([i, i + 1, i + 29, i + 28], axis=1)
    ground = Ground.of(vertices, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))
    sizes = Sizes.of(9.0)
    network = add_borders(Network(longest=99.0), ground, sizes.sampling)
    ring = [(4 + np.cos(t), 4 + np.sin(t), 0) for t in np.linspace(0, 6.2, 50)]
    lines = [[(2, 4, 0), (7, 4, 0)], [(3, 2, 0), (3, 7, 0)], [(2, 2, 0), (2, 7, 0), (7, 7, 0)]]
    for line in (*lines, ring):
        network = insert_stroke(network, ground, sizes, clean_stroke(line, ground, sizes)).network
    ground.project([[4, 4, 9.0]], [[0, 0, 1.0]])
    one, two = ground.nearest([[1, 1, 0.0]]), ground.nearest([[8, 8, 0.0]])
    trace_geodesic(ground, one, two).sample(ground, sizes.sampling)
    cut_by_plane(ground, one, (1, 0.3, 0))
    find_completions(network, ground, (4.99, 4, 0), (0, 0, 1), sizes)
    network = toggle_corner(network, sizes, (5, 4.1, 0), (0, 0, 1)).network
    erase_crossed_chains(network, clean_stroke([(4.5, 3, 0), (4.5, 6, 0)], ground, sizes))
    count_fewest_edges(next(iter(network.chains.values())), sizes.edge)
    flood_triangles(ground, np.zeros(len(ground.triangles), bool), np.array([0], np.int32), 1e9)
    Salience.of(ground, sizes.edge).feel(ground.vertices[:2], ground.normals[:2], "both")
    patches = [[[0], [1], [2], [3]], [[1], [4], [4]]]
    problem = CountsProblem.of([3.0, 4, 3, 4, 2], patches, [0, 0, 2, 0, 0])
    change_count(problem, solve_counts(problem).counts, 0, 5)


#: What runs side by side, about as long each.
RUNS = (
    (learn, place_fills, make_surfaces, snap_features),
    (ask, draw_network),
)


def main() -> None:
    if sys.argv[1:2] == ["--run"]:
        begun = time.perf_counter()
        for part in RUNS[int(sys.argv[2])]:
            part(sys.argv[3], str(EXAMPLE))
        if "--times" in sys.argv:
            print(f"{time.perf_counter() - begun:.1f} s")
        return
    with tempfile.TemporaryDirectory() as folder:
        # Queries above name another cache folder, to grow the family anew.
        named = {**os.environ, KERNELS_VARIABLE: str(kernel_folder())}
        command = [sys.executable, __file__, "--run"]
        runs = [
            subprocess.Popen([*command, str(run), folder, *sys.argv[1:]], env=named)
            for run in range(len(RUNS))
        ]
        codes = [run.wait() for run in runs]
    if any(codes):
        sys.exit("the kernels could not be compiled; see above")


if __name__ == "__main__":
    main()
