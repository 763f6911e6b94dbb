"""Run every verb on small examples, to see which kernels it calls and which it has to compile.

    python scripts/verb_runs.py query fill       what these verbs call, as JSON
    python scripts/verb_runs.py --shared         all verbs; scripts on surfaces of ../shared as well

``compiled`` counts kernels that were in neither the pack nor the user's folder. ``calls`` are lines
of patterndb/data/kernels.jsonl, which scripts/record_kernels.py puts together.

A verb is run as its command line is, in a process of its own; beside that the functions below call,
for some verbs, what only other data or a window would lead to.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared"


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
    from patterndb.geometry.embedding import embed_disk
    from query import Boundary, Fill, Stroke
    from query.expand import expand_pattern
    from query.placing import Surface, find_loops, lay_flat, measure_flow_distance, place, quality
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


def ask_for_fills(folder: str, example: str) -> None:
    """Ask for fills: strict, relaxed, of the family, constructed, with strokes and loops."""
    import numpy as np

    from patterndb.core.pattern import Pattern
    from patterndb.core.patternclass import PatternClass
    from query import Boundary, Stroke, best, fills
    from query.solving.systems import make_systems

    square = Pattern.from_code(np.zeros(4, np.uint16))
    squares = PatternClass.from_patterns(4, [square])
    list(fills(squares, (3, 2, 3, 2), limit=5, order="symmetric"))
    list(fills(squares, (3, 2, 3, 2), strokes=[Stroke((0, 1), (2, 1))], limit=5))
    # As for a class that is so large that it is kept.
    make_systems(squares.lengths, squares.joins, jointly=True)

    def ask(boundary, **options):
        return best(PatternClass.from_patterns(boundary.n_sides, []), boundary, **options)

    ask(Boundary.closed(8))
    ask(Boundary((3, 5, 4, 6)), strokes=[Stroke.loop()])
    ask(Boundary((1, 2) * 6))
    corners = ["reflex" if i in (2, 5, 9) else "convex" for i in range(10)]
    ask(Boundary((4, 3, 4, 3, 5, 4, 3, 4, 3, 5), corners), origins=("constructed",))


def make_surfaces(folder: str, example: str) -> None:
    """Join curves, find cycles, and make surfaces of them by every method without a database."""
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
    made = surface(network, cycles)
    surface(network, cycles, settings=Settings("chords", area_price=None, alpha=0.0))
    surface(network, cycles, settings=Settings("area"))
    Canvas.of(made.points, made.triangles).pick([0.5, 0.5, 5], [0, 0, -1])


def snap_features(folder: str, example: str) -> None:
    """Snap a stroke to a clean and to a messy body, and drag the curve."""
    sys.path.insert(0, str(Path(example).parent))
    from bodies import CARS, body, degrade, stroke

    from patterndb.geometry.polyline import sample_polyline
    from patterndb_sketch.features.drag import MatrixCamera, begin_drag, move_drag
    from patterndb_sketch.features.model import Model
    from patterndb_sketch.features.ribs import build_ribs
    from patterndb_sketch.features.snap import Snap

    car = body(sorted(CARS)[0], resolution=0.4)
    mess = degrade(car, 1, gaps=0.001, crossings=0.003)
    line = sample_polyline(car.feature("shoulder").smooth, 11)
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


@dataclass(frozen=True, slots=True)
class VerbRun:
    """What is run for a verb: calls of the command line in one folder, then functions. The first
    call is the plainest: what it needs is compiled first.

    {root} stands for the checkout, {shared} for the shared folder, {out} for the folder of the
    calls. shared_calls: those that need the shared folder, run in the checkout beside it.
    """

    calls: Sequence[str] = ()
    functions: Sequence[Callable[[str, str], None]] = ()
    shared_calls: Sequence[str] = ()


#: A boundary on a slope with a stroke, one with a reflex corner, and one on the head's face.
SQUARE = [[0, 0, 0], [4, 0, 0], [4, 3, 1], [0, 3, 1]]
ELL = [[0, 0, 0], [4, 0, 0], [4, 2, 0], [2, 2, 0], [2, 4, 0], [0, 4, 0]]

QUERY = "query --sides 3,5,4,6 --limit 8"

RUNS: dict[str, VerbRun] = {
    "ingest": VerbRun(
        (
            "ingest examples/ --db all.db --jobs 2",
            "ingest examples/jug.obj --db small.db --basic 3 --side 0 --convex 0",
            "ingest sheet.ply --db small.db --no-prepare",
        ),
        (learn,),
    ),
    "list": VerbRun(("list --class 5", "list --class 4 --db db.db")),
    "export": VerbRun(
        (
            "export three/ --class 3 --limit 5",
            "export some.csv --class 5",
            "export all.jsonl --db db.db",
        )
    ),
    "diff": VerbRun(("diff db.db db.db",)),
    "stats": VerbRun(("stats", "stats --db db.db")),
    "meshes": VerbRun(("meshes", "meshes --db db.db --json")),
    "verify": VerbRun(("verify --db db.db",)),
    "merge": VerbRun(("merge db.db --db merged.db",)),
    "remove": VerbRun(("remove jug.obj --db db.db",)),
    "export-ddq": VerbRun(("export-ddq out.ddq.db --db db.db",)),
    "import-ddq": VerbRun(("export-ddq ddq.db --db db.db", "import-ddq ddq.db --db new.db")),
    "query": VerbRun(
        (
            f"{QUERY} --image fills.png --obj fills",
            f"{QUERY} --image fills.svg --json --order regular",
            f"{QUERY} --order regular --strict",
            f"{QUERY} --order small --solver cp-sat",
            f"{QUERY} --order symmetric --per-pattern 1",
            f"{QUERY} --from-licence cc0* --valence 3..5 --max-quads 99 --no-loop",
            f"{QUERY} --flow 0:1-2:2 --tolerance 2",
            f"{QUERY} --loop --image loop.png",
            f"{QUERY} --db db.db --learned-only --use-counts",
            "query --sides 12 --closed --image closed.svg",
            "query --sides 4,3,4,3,5,5 --corners c,c,r,c,c,c --limit 9",
            "query --sides 2,2,2,2,2,2,2,2,2,2,2,2 --limit 3 --db db.db",
            "query --sides 31,3,2 --limit 5",
            "query --sides 5,3 --limit 5",
            "query --batch boundaries.txt --limit 3",
        ),
        (place_fills, ask_for_fills),
    ),
    "fill": VerbRun(
        (
            "fill square.json -o flat.obj",
            "fill square.json -o second.obj --rank 2 --order quality --db db.db --record",
            "fill ell.json -o ell.obj",
            "fill sheet.json --surface sheet.obj -o sheet-fill.obj",
        ),
        (place_fills, ask_for_fills),
    ),
    "holes": VerbRun(
        (
            "holes {root}/docs/meshes/head.obj",
            "holes {root}/docs/meshes/head.obj --all -o filled.obj --picture filled.png",
        ),
        (place_fills,),
    ),
    "show": VerbRun(
        ("show --sides 3,5,4,6 -o show.png", "show --sides 5,4,5,4,4 --rank 2 -o show.svg")
    ),
    "gallery": VerbRun(
        (
            "gallery --class 5 --convex --limit 40 -o five.png",
            "gallery --class 3 --limit 9 -o three.svg --db db.db",
            "gallery --sides 3,5,4,6 -o fills.png --limit 6",
        )
    ),
    "browse": VerbRun(("browse --class 5 -o page.png", "browse --class 0 -o zero.png --db db.db")),
    "explore": VerbRun(
        (
            "explore --sides 3,5,4,6 -o one.png",
            "explore sheet.json --surface sheet.obj --rank 2 -o two.png",
        ),
        (place_fills,),
    ),
    "surface": VerbRun(
        (
            "surface examples/networks/teacup.json -o cup.obj --picture cup.png",
            "surface examples/networks/teacup.json --method quads -o quads.obj",
            "surface examples/networks/teacup.json --method smooth -o smooth.obj",
            "surface examples/networks/teacup.json --find-cycles --method area -o area.obj",
        ),
        (make_surfaces,),
        (
            "surface {shared}/data/curves/salvi/trebol_network.json --find-cycles "
            "-o {out}/trebol.obj",
        ),
    ),
    "retopo": VerbRun(
        (
            "retopo --script sheet.jsonl -o sheet-quads.obj --session s.retopo --picture s.png",
            "retopo examples/jug.obj --from-quads -o jug-quads.obj",
            "retopo examples/dog.obj --draft -o dog-draft.obj",
            "retopo --script jug.jsonl -o jug-sleeve.obj --picture jug.png",
        ),
        (draw_network,),
        ("retopo --script {root}/examples/retopo/penguin.tutorial.jsonl -o {out}/penguin.obj",),
    ),
    "features": VerbRun(
        (
            "features cars/sedan.obj --strokes cars/sedan.strokes.json -o sedan.json "
            "--picture f.png",
            "features cars/coupe.obj --strokes cars/coupe.strokes.json --strict -o coupe.json",
        ),
        (snap_features,),
    ),
    "register": VerbRun(
        (
            "register cars/sedan.obj --network cars/sedan.network.json --template box:car?r=3 "
            "-o sedan.quads.obj --picture r.png",
        )
    ),
    "shape-model": VerbRun(
        (
            "shape-model build --template box:roof?r=4 -o cars.npz "
            "cars/sedan.obj=cars/sedan.network.json cars/wagon.obj=cars/wagon.network.json "
            "cars/coupe.obj=cars/coupe.network.json",
            "shape-model sample cars.npz --mode 1=2.0 -o long.obj --picture long.png",
            "shape-model edit cars.npz --drag roof_rail=0,0,0.1 -o tall.obj",
        )
    ),
}

#: Verbs whose examples are bodies of cars, which take a moment to make.
WITH_CARS = ("features", "register", "shape-model")


def prepare_folder(folder: Path, verb: str) -> None:
    """Put into a folder what the calls of a verb read."""
    import numpy as np

    import patterndb
    from ingest.formats import read_mesh, write_mesh

    shutil.copytree(ROOT / "examples", folder / "examples")
    x, y = np.meshgrid(np.linspace(0, 9, 28), np.linspace(0, 9, 28))
    points = np.stack([x, y, 0.3 * np.sin(x)], axis=-1).reshape(-1, 3)
    i = np.array([k for k in range(27 * 28) if k % 28 < 27])
    quads = np.stack([i, i + 1, i + 29, i + 28], axis=1)
    (folder / "sheet.obj").write_text(
        "".join(f"v {a:.6f} {b:.6f} {c:.6f}\n" for a, b, c in points.tolist())
        + "".join(f"f {a + 1} {b + 1} {c + 1} {d + 1}\n" for a, b, c, d in quads.tolist())
    )
    write_mesh(folder / "sheet.ply", read_mesh(folder / "examples" / "jug.obj"))
    stroke = [[2, 0, 0], [2.2, 1.5, 0.5], [2, 3, 1]]
    write_boundary(folder / "square.json", SQUARE, [4, 3, 4, 3], [stroke])
    write_boundary(folder / "ell.json", ELL, [4, 2, 2, 2, 2, 4], [])
    near = [[x, y, 0.3 * float(np.sin(x))] for x, y in ((2, 2), (6, 2), (6, 5), (2, 6))]
    write_boundary(folder / "sheet.json", near, [4, 3, 5, 4], [])
    (folder / "boundaries.txt").write_text(
        '3,5,4,6\n4,4,4,4\n{"sides": [3, 5, 4, 6], "strokes": [[[0, 1], [2, 2]]], "loops": 1}\n'
    )
    lines = [[[1, y, 0.1], [8, y, 0.1]] for y in (2, 4, 6)] + [
        [[x, 1, 0.1], [x, 8, 0.1]] for x in (2, 4.5, 7)
    ]
    script = [
        {"tool": "open", "surface": str(folder / "sheet.obj")},
        {"tool": "sizes", "edge": 0.7},
    ]
    script += [{"tool": "stroke", "points": line} for line in lines]
    script += [{"tool": "brush", "at": [4.5, 4, 0.0], "to": [4.7, 4.2, 0.0]}]
    (folder / "sheet.jsonl").write_text("".join(json.dumps(call) + "\n" for call in script))
    # README's: coarse triangles, loops cut by planes, a sleeve between them.
    script = [
        {"tool": "open", "surface": "examples/jug.obj"},
        {"tool": "loop", "at": [0, -6.5, 5], "normal": [0, 0, 1]},
        {"tool": "loop", "at": [0, -6.5, 2], "normal": [0, 0, 1]},
        {"tool": "cylinder", "points": [[0, -6.5, 5], [0, -6.5, 2]], "division": 4},
    ]
    (folder / "jug.jsonl").write_text("".join(json.dumps(call) + "\n" for call in script))
    from ingest import ingest as learn_meshes
    from patterndb.store import LearningOptions

    with patterndb.open(folder / "db.db", "create") as database:
        meshes = [folder / "examples" / "jug.obj", folder / "examples" / "hand.obj"]
        learn_meshes(database, meshes, LearningOptions(basic=4, side=4, convex=8))
    if verb in WITH_CARS:
        sys.path.insert(0, str(ROOT / "examples"))
        import car_bodies

        names = ["sedan", "wagon", "coupe"]
        car_bodies.main([*names, "--resolution", "0.5", "--out", str(folder / "cars")])


def write_boundary(path: Path, corners: Any, lengths: list[int], strokes: list[Any]) -> None:
    """Write a boundary of straight sides for the verb fill."""
    sides = [[a, b] for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    path.write_text(json.dumps({"sides": sides, "lengths": lengths, "strokes": strokes}))


@dataclass(slots=True)
class CallRecorder:
    """The kernels that Python has called, with the types of their arguments.

    plain: the verbs whose plainest call is run at this moment.
    """

    calls: dict[tuple[str, str, str], Any] = field(default_factory=dict)
    plain: tuple[str, ...] = ()

    def install(self) -> None:
        """Note every call that looks for a compiled version from now on."""
        from patterndb.system.compiling import COMPILED
        from patterndb.system.kernellist import ListedKernel
        from patterndb.system.kernels import ContentCache
        from patterndb.system.kerneltypes import spell_type

        load = ContentCache.load_overload

        def load_noted(cache: Any, sig: Any, context: Any) -> Any:
            outermost = not COMPILED.is_compiling()
            made = load(cache, sig, context)
            if outermost:
                function = cache._function
                types = sig if isinstance(sig, tuple) else sig.args
                spelled = json.loads(json.dumps([spell_type(one) for one in types]))
                kernel = ListedKernel(
                    function.__module__, function.__name__, spelled, (), 1, self.plain
                )
                self.calls.setdefault(kernel.key, kernel)
            return made

        ContentCache.load_overload = load_noted  # type: ignore[method-assign]


def run_verb(verb: str, *, shared: bool) -> dict[str, Any]:
    """Run what is listed for a verb in this process; what it called and compiled."""
    from patterndb.system.caches import KERNELS_VARIABLE, kernel_folder
    from patterndb.system.compiling import COMPILED
    from patterndb.system.kernellist import format_kernel
    from patterndb_app.cli import cli

    recorder = CallRecorder()
    failed: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        # In a process of its own: what the examples themselves need is not the verb's.
        subprocess.run(
            [sys.executable, __file__, "--prepare", name, verb],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        # What queries keep beside kernels shall be made here, as in a fresh installation.
        os.environ.setdefault(KERNELS_VARIABLE, str(kernel_folder() or ""))
        os.environ["PATTERNDB_CACHE"] = str(Path(name) / "cache")
        before = COMPILED.kernels
        recorder.install()
        listed = RUNS[verb]
        calls = [(call, name) for call in listed.calls]
        if shared:
            calls += [(call, str(ROOT)) for call in listed.shared_calls]
        for number, (call, folder) in enumerate(calls):
            recorder.plain = () if number else (verb,)
            text = call.replace("{root}", str(ROOT)).replace("{out}", name)
            with contextlib.chdir(folder):
                code = call_verb(cli, text.replace("{shared}", str(SHARED)).split())
            if code:
                failed.append(f"{call}: exit code {code}")
        recorder.plain = ()
        for function in listed.functions:
            function(name, str(ROOT / "examples" / "jug.obj"))
    return {
        "verb": verb,
        "compiled": COMPILED.kernels - before,
        "seconds": round(COMPILED.seconds, 2),
        "failed": failed,
        "calls": [format_kernel(kernel) for kernel in recorder.calls.values()],
    }


def call_verb(cli: Any, arguments: list[str]) -> int:
    """Run a call of the command line in this process; its exit code."""
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            cli.main(arguments, prog_name="patterndb")
    except SystemExit as end:
        return int(end.code or 0)
    return 0


def run_apart(verb: str, *, shared: bool, environment: dict[str, str] | None = None) -> Any:
    """As :func:`run_verb`, in a process of its own; RuntimeError if it ends without an answer."""
    command = [sys.executable, __file__, "--here", verb, *(["--shared"] if shared else [])]
    done = subprocess.run(
        command, env={**os.environ, **(environment or {})}, stdout=subprocess.PIPE, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{verb} ended with {done.returncode}")
    return json.loads(done.stdout)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("verbs", nargs="*", metavar="VERB", help="all if not given")
    parser.add_argument("--shared", action="store_true", help="run what needs ../shared, too")
    parser.add_argument(
        "--none-compiled", action="store_true", help="tell less; fail if a kernel was compiled"
    )
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--prepare", metavar="FOLDER", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.prepare is not None:
        prepare_folder(given.prepare, given.verbs[0])
        return
    missed: list[str] = []
    for verb in given.verbs or RUNS:
        run = run_verb if given.here else run_apart
        answer = run(verb, shared=given.shared)
        if given.none_compiled:
            print(
                f"{verb}: {len(answer['calls'])} kernels, {answer['compiled']} compiled", flush=True
            )
            missed += [verb] if answer["compiled"] or answer["failed"] else []
        else:
            print(json.dumps(answer), flush=True)
    if missed:
        sys.exit("compiled or failed: " + ", ".join(missed))


if __name__ == "__main__":
    main()
