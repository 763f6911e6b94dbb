"""Methods of databases, meshes, holes and networks whose work is done in higher layers.

``db.fills(...)`` is done by ``query``, ``db.ingest(...)`` by ``ingest``: packages that themselves
import databases and meshes. The classes here are bases of those that have such methods. They import
what does the work when it is asked for. With :mod:`patterndb` and :mod:`patterndb.notebook` this is
the only module of the package that imports from higher layers.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from ingest.pipeline import IngestReport, MeshReport
    from patterndb.core.polygonmesh import PolygonMesh
    from patterndb.geometry.surface import Surface
    from patterndb.store import Database, LearningOptions
    from patterndb_sketch.curvenetwork.network import CurveNetwork, Cycle
    from patterndb_sketch.surfacing import FoundCycles, SurfaceRequest, Surfacing
    from query.boundary import Boundary
    from query.engine import PatternSource
    from query.fill import Fill
    from query.holes import Hole, HoleFills, HoleOptions
    from query.listing.fills import Fills
    from query.request import FillRequest
    from viewer.plotting import Plotter, PolyData


class PlotVerbs:
    """Methods of everything that pyvista can show."""

    __slots__ = ()

    def to_pyvista(self) -> PolyData:
        """Return a mesh of pyvista; see :func:`viewer.plotting.to_pyvista`, also for its arrays.

        Raises MissingExtraError where pyvista is not installed.

        Example: ``patterndb.read("head.obj").to_pyvista().plot(scalars="valence")``
        """
        from viewer.plotting import to_pyvista

        return to_pyvista(self)

    def plot(self, *, plotter: Plotter | None = None, **options: Any) -> Plotter:
        """Return a pyvista plotter that shows this: ``.show()`` it, or ``.screenshot(path)``.

        plotter: one to add it to. options: shading, wire, x_ray, sharp, perspective, clip, toward
        and up; see :class:`viewer.plotting.PlotOptions`.

        Raises MissingExtraError where pyvista is not installed, and ValueError for a shading there
        is not.

        Example: ``db.best((3, 5, 4, 6)).plot().screenshot("fill.png")``
        """
        from viewer.plotting import plot

        return plot(self, plotter=plotter, **options)


class QueryVerbs:
    """Methods of everything that has patterns: a database, or several as one."""

    def fills(
        self,
        boundary: Boundary | Iterable[int],
        request: FillRequest | None = None,
        **options: Any,
    ) -> Fills:
        """Return an iterator over the fills of a boundary, best first.

        boundary: a Boundary, or the numbers of edges of sides between convex corners. request,
        options: see :class:`query.request.FillRequest`; options are its entries, alone or in place
        of those of a request.

        Raises InvalidBoundaryError, InvalidQueryError and NotFoundError as :func:`query.fills`.

        Example: ``next(db.fills((3, 5, 4, 6), max_irregular=2))``
        """
        from query.engine import fills

        return fills(cast("PatternSource", self), boundary, request, **options)

    def best(
        self,
        boundary: Boundary | Iterable[int],
        request: FillRequest | None = None,
        **options: Any,
    ) -> Fill | None:
        """Return the first of :meth:`fills`, or None."""
        from query.engine import best

        return best(cast("PatternSource", self), boundary, request, **options)


class DatabaseVerbs(QueryVerbs):
    """Methods of one database."""

    def ingest(
        self,
        paths: Sequence[Path | str],
        options: LearningOptions | None = None,
        **choices: Any,
    ) -> IngestReport:
        """Learn the patterns of mesh files; the database must be open for writing.

        options: what is learned of each mesh. choices: jobs, scheduler, provenance, limits,
        skip_bad, progress and report; see :func:`ingest.pipeline.ingest`, also for what it raises.

        Example: ``patterndb.open("my.db", "create").ingest(["head.obj", "hand.obj"])``
        """
        from ingest.pipeline import ingest

        return ingest(cast("Database", self), paths, options, **choices)

    def learn(
        self,
        faces: PolygonMesh | ArrayLike | Sequence[Sequence[int]],
        name: str,
        options: LearningOptions | None = None,
        **choices: Any,
    ) -> MeshReport:
        """Learn the patterns of one mesh of a program; the database must be open for writing.

        faces: a PolygonMesh, (q, 4) vertex indices, or a list of faces of any arity. name: of the
        mesh in the database. choices: provenance, jobs and progress; see
        :func:`ingest.pipeline.learn_mesh`, also for what it raises.

        Example: ``db.learn(quads, "head, finished")``
        """
        from ingest.pipeline import learn_mesh

        return learn_mesh(cast("Database", self), faces, name=name, options=options, **choices)


class MeshVerbs(PlotVerbs):
    """Methods of a polygon mesh."""

    __slots__ = ()

    def holes(self) -> list[Hole]:
        """Return the border loops of the mesh, those of the fewest edges first.

        Raises InvalidMeshError for a one-sided mesh and for faces that share no vertices.

        Example: ``next(patterndb.read("head.obj").holes()[0].fills(db)).weld()``
        """
        from query.holes import find_holes

        return find_holes(cast("PolygonMesh", self))

    def hole(
        self, *, loop: int | Sequence[int] | None = None, faces: Iterable[int] | None = None
    ) -> Hole:
        """Return the hole at a border loop, named by one or more of its vertices, or around faces
        that are to be replaced; without both the mesh must have exactly one border loop.

        Raises InvalidMeshError where no loop, or more than one, is meant.
        """
        from query.holes import choose_hole

        return choose_hole(cast("PolygonMesh", self), loop=loop, faces=faces)

    def flaws(self) -> tuple[str, ...]:
        """Return what hinders filling holes of the mesh, a sentence for each flaw.

        Raises InvalidMeshError for a one-sided mesh.
        """
        from query.holes import list_mesh_flaws

        return list_mesh_flaws(cast("PolygonMesh", self))

    def write(self, path: Path | str) -> None:
        """Write the mesh into a file, in the format of its suffix.

        Raises what :func:`ingest.formats.write_mesh` raises.
        """
        from ingest.formats import write_mesh

        write_mesh(path, cast("PolygonMesh", self))

    def surface(self) -> Surface:
        """Return the surface of the mesh, its faces cut into triangles that are turned alike, to
        place fills on and to draw on.

        Raises InvalidMeshError for a mesh that has no area, or one side only.
        """
        from patterndb.geometry.surface import Surface

        return Surface.from_polygons(cast("PolygonMesh", self)).orient()


class HoleVerbs(PlotVerbs):
    """Methods of a hole of a mesh."""

    __slots__ = ()

    def fills(
        self, db: PatternSource, options: HoleOptions | None = None, **choices: Any
    ) -> HoleFills:
        """Return an iterator over the fills of the hole, placed, best first.

        db: a database. options, choices: see :class:`query.holes.HoleOptions`; choices are its
        entries, alone or in place of those of options.

        Raises InvalidMeshError and InvalidQueryError as :func:`query.holes.fill_holes`.
        """
        from query.holes import fill_holes

        return fill_holes(db, cast("Hole", self), options, **choices)


class NetworkVerbs(PlotVerbs):
    """Methods of a curve network."""

    __slots__ = ()

    def find_cycles(self) -> FoundCycles:
        """Return the cycles that bound patches; see
        :func:`patterndb_sketch.surfacing.find_cycles`."""
        from patterndb_sketch.surfacing import find_cycles

        return find_cycles(cast("CurveNetwork", self))

    def surface(
        self,
        request: SurfaceRequest | None = None,
        *,
        cycles: Sequence[Cycle] | None = None,
        db: PatternSource | None = None,
        **options: Any,
    ) -> Surfacing:
        """Return the surface of the network: of its own cycles, or, where it has none, of those
        that are found.

        request, options: see :class:`patterndb_sketch.surfacing.SurfaceRequest`; options are its
        entries, alone or in place of those of a request. cycles, db: see
        :func:`patterndb_sketch.surfacing.surface`, also for what it raises.

        Example: ``read_network("chair.obj").surface(fair=True).mesh()``
        """
        from patterndb_sketch.surfacing import surface

        network = cast("CurveNetwork", self)
        if not network.cycles and cycles is None:
            cycles = self.find_cycles().cycles
        return surface(network, cycles, request, db=db, **options)
