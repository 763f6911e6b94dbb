"""Models the example meshes and writes them as OBJ files, and the example network as JSON.

    python examples/make_examples.py [--out DIR]
    python examples/make_examples.py --holes docs/meshes/head.obj

The files are the same, byte for byte, on every run.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from dog import dog
from hand import hand
from head import head
from jug import jug
from modelling import Mesh, write_obj
from teacup import write as write_teacup

HERE = Path(__file__).resolve().parent

EXAMPLES: dict[str, tuple[str, Callable[[], Mesh]]] = {
    "head": (
        "a human head with loops around eyes and mouth, ears, and an opening at the neck",
        head,
    ),
    "hand": ("a left hand with four fingers and a thumb, and an opening at the wrist", hand),
    "jug": ("a jug with spout and handle, a closed surface of genus 1", jug),
    "dog": ("a dog with ears and tail, a closed surface", dog),
}
"""Per file: what it is, and the function that models it."""

#: Around these points of the head, in centimetres, as many rings of quads are taken out: on the
#: bridge of the nose, which has no other side, and on a cheek.
HOLES = (((0.0, 0.0, 10.0), 2), ((-5.5, -1.5, 6.0), 2))

COMMENT = """{what}
A coarse quad mesh, coordinates in centimetres, made by examples/make_examples.py.
Licence: CC0-1.0 (https://creativecommons.org/publicdomain/zero/1.0/)"""


def cut_hole(mesh: Mesh, place: Sequence[float], rings: int) -> Mesh:
    """Take out the quads at the vertex nearest to a place, and as many rings around them."""
    gone = np.zeros(len(mesh.quads), bool)
    chosen = {int(np.linalg.norm(mesh.points - np.asarray(place), axis=1).argmin())}
    for _ in range(rings):
        gone |= np.isin(mesh.quads, list(chosen)).any(axis=1)
        chosen = set(mesh.quads[gone].ravel().tolist())
    kept = mesh.quads[~gone]
    used, quads = np.unique(kept, return_inverse=True)
    return Mesh(mesh.points[used], quads.reshape(-1, 4))


def write_holes(path: Path) -> None:
    """Write the head with holes: docs/meshes/head.obj."""
    mesh = head()
    for place, rings in HOLES:
        mesh = cut_hole(mesh, place, rings)
    write_obj(path, mesh, COMMENT.format(what="The head with two holes in it"))
    print(f"{path}\t{len(mesh.quads)} quads")


def main(arguments: Sequence[str] | None = None) -> None:
    """Writes every example into the directory given by ``--out``, by default beside this file."""
    parser = argparse.ArgumentParser(
        description="Model the example meshes and write them as OBJ files."
    )
    parser.add_argument(
        "--out", type=Path, default=HERE, metavar="DIR", help="where to write (default: examples)"
    )
    parser.add_argument(
        "--holes", type=Path, metavar="FILE", help="write the head with two holes in it, alone"
    )
    given = parser.parse_args(arguments)
    if given.holes is not None:
        write_holes(given.holes)
        return
    out: Path = given.out
    out.mkdir(parents=True, exist_ok=True)
    for name, (what, model) in EXAMPLES.items():
        mesh = model()
        path = out / f"{name}.obj"
        write_obj(path, mesh, COMMENT.format(what=what[0].upper() + what[1:]))
        print(f"{path}\t{len(mesh.quads)} quads")
    networks = out / "networks"
    networks.mkdir(exist_ok=True)
    print(f"{networks / 'teacup.json'}\t{write_teacup(networks / 'teacup.json')} strokes")


if __name__ == "__main__":
    main()
