"""Draw a large surface off-screen: first picture, and pictures while the view turns.

    python benchmarks/large_surface.py [--triangles 1100000]

Needs the extra ``viewer``. Prints seconds of processor and the process's greatest memory. The own
part is what this program does for a picture; the rest is VTK's, with the graphics of the machine.
"""

from __future__ import annotations

import argparse
import math
import resource
import time

import numpy as np

from viewer.camera import fit_view
from viewer.picture import make_plotter
from viewer.scene import Scene
from viewer.stage import Drawn, Faces, LayerStage

#: Pixels of a picture, and pictures of which the first is not counted.
WIDTH, HEIGHT, TURNS = 1040, 860, 4


def make_ball(triangles: int) -> Faces:
    """Make a dented ball without caps, of about this many triangles."""
    n = max(2, round(math.sqrt(triangles / 4.0)))
    v, u = np.meshgrid(np.linspace(0.02, 0.98, n + 1), np.linspace(0.0, 2.0, 2 * n, False))
    v, u = np.pi * v.ravel(), np.pi * u.ravel()
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), -np.cos(v)], axis=1)
    i, j = np.meshgrid(np.arange(2 * n), np.arange(n), indexing="ij")
    a, b = i * (n + 1) + j, (i + 1) % (2 * n) * (n + 1) + j
    quads = np.stack([a, b, b + 1, a + 1], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    return Faces("ball", ball * (1.0 + 0.03 * np.sin(9 * u) * np.sin(7 * v))[:, None], faces)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--triangles", type=int, default=1_100_000)
    ball = make_ball(parser.parse_args().triangles)
    view = fit_view(ball.points, (1.0, 0.4, 0.3), (0.0, 0.0, 1.0), float(WIDTH), float(HEIGHT))
    plotter = make_plotter((WIDTH, HEIGHT))
    stage = LayerStage(plotter)

    def draw(turning: bool) -> tuple[float, float]:
        scene = Scene(float(WIDTH), float(HEIGHT))
        begin = time.process_time()
        stage.show(Drawn(scene, [ball], view, (WIDTH / 2.0, HEIGHT / 2.0)), turning=turning)
        own = time.process_time()
        plotter.render()
        return own - begin, time.process_time() - begin

    print(f"{len(ball.faces):,} triangles")
    own, whole = draw(False)
    print(f"first picture: own {own:.2f} s, whole {whole:.2f} s")
    for turning in (True, False):
        taken = []
        for _ in range(TURNS):
            view = view.turned(20.0, 5.0)
            taken.append(draw(turning))
        own, whole = np.mean(taken[1:], axis=0)
        print(f"{'turning' if turning else 'at rest'}: own {own:.4f} s, whole {whole:.3f} s")
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024:,} MB")


if __name__ == "__main__":
    main()
