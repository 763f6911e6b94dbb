"""What is drawn in space, and the VTK actors that show it: in windows, pictures and notebooks.

A picture in space is a list of layers, all of them in the coordinates of the model: faces
(:class:`Faces`), curves (:class:`Curves`) and marks that face the viewer (:class:`Marks`). A
:class:`LayerStage` keeps one actor for each layer of a pyvista plotter, by the layer's name. It
sends arrays to VTK only if they are other arrays than before: where only the view changes, only
matrices do.

Quads and curves lie on a surface, and flat ones cut through what is round. Each layer has a lift:
it is drawn that much nearer to the viewer than it is, without moving in the picture.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from patterndb.geometry.points import Points
from viewer import style
from viewer.camera import PLAIN, StageLook, View
from viewer.paper import list_font_files
from viewer.scene import Scene, ScenePolygons

Indices = NDArray[np.integer[Any]]

#: A model, matte and lit from both sides alike.
MATTE = "#eceef0"

#: Where the light comes from, seen by the viewer: much of it from the upper left, and some from
#: the other side; how bright is what neither reaches, and what each adds.
KEY, FILL = (-0.38, 0.6, 0.7), (0.7, 0.1, 0.5)
AMBIENT, OF_KEY, OF_FILL = 0.6, 0.4, 0.16

#: How much is seen of faces that can be seen through, and how many of them behind each other.
X_RAY, PEELS = 0.35, 8

#: Faces of which a coarse likeness is shown while the view turns, and how many cells it has along
#: each side of its box.
LARGE, CELLS = 300_000, 96

#: The shader of clay: bright from above, warm where it faces the viewer, dark at its outline.
MATCAP = """//VTK::Light::Impl
  float facing = clamp(normalVCVSOutput.z, 0.0, 1.0);
  float sky = 0.5 + 0.5 * normalVCVSOutput.y;
  vec3 clay = mix(vec3(0.42, 0.36, 0.36), vec3(1.06, 1.0, 0.95), pow(facing, 0.7));
  gl_FragData[0] = vec4(diffuseColor * clay * (0.72 + 0.34 * sky), opacity);
"""

#: Faces that meet at a smaller angle, in degrees, are shaded as one smooth surface.
CREASE = 37.0

#: White that a model one can see through is mixed with, and how far it is behind all else: this
#: many times its size, and this many points.
FADED, BEHIND = 0.62, (2.0, 100.0)

#: What faces away from the viewer by more than this cosine is hidden by the surface.
AWAY = -0.12

#: Curves that turn by less than this cosine at a point need no round joint; curves narrower than
#: ROUND points are of one colour, others look round: how bright they are where no light reaches.
STRAIGHT, ROUND, RIM = 0.985, 2.0, 0.72

#: Room for flat polygons before all else, as a part of the depth shown.
ROOM = 0.02

#: From the baseline of a text to the lower end of its letters, as a part of its size.
DESCENT = 0.236


class Lift(NamedTuple):
    """How much nearer than it is something is drawn: in points of the picture, and in space."""

    points: float
    space: float = 0.0

    def above(self, points: float) -> Lift:
        """Return a lift that is greater by this many points."""
        return Lift(self.points + points, self.space)

    def measure(self, view: View) -> float:
        """Measure all of it, in space."""
        return self.space + self.points / view.scale


#: Where it is.
FLAT = Lift(0.0)


class LineLook(NamedTuple):
    """How curves are drawn: width in points; the length of a dash in space, 0 for none."""

    colour: str
    width: float
    lift: Lift
    dash: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Triangles or quads.

    points: (n, 3) float64. faces: (f, 3) or (f, 4). colour: of all of them, unless there are
    colours of faces (f, 3) or of points (n, 3), 0 to 1. normals: (n, 3) unit normals at the points;
    without, they are computed, and faces that meet at a crease look so. lift: how much nearer they
    are drawn; those that face away are as much farther off if they are ``sheets``. back: the colour
    of what faces away, where that is another. faded: pale, and behind all else.
    """

    name: str
    points: Points
    faces: Indices
    colour: str = MATTE
    face_colours: NDArray[Any] | None = None
    point_colours: NDArray[Any] | None = None
    normals: Points | None = None
    lift: Lift = FLAT
    sheets: bool = False
    back: str = ""
    faded: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """Polylines.

    points: (n, 3) of all of them. sizes: how many each has. normals: (n, 3) of the surface there;
    what faces away is left out.
    """

    name: str
    points: Points
    sizes: tuple[int, ...]
    look: LineLook
    normals: Points | None = None

    @classmethod
    def of(
        cls,
        name: str,
        lines: Sequence[Points],
        look: LineLook,
        normals: Sequence[Points] | None = None,
    ) -> Curves:
        """Of polylines (k, 3), with the surface's normals (k, 3) at their points."""
        rows = [
            np.asarray(line, np.float64) if normals is None else np.hstack([line, normals[number]])
            for number, line in enumerate(lines)
            if len(line) > 1
        ]
        if look.dash > 0.0:
            rows = [dash for row in rows for dash in _cut_dashes(row, look.dash)]
        whole = np.concatenate([np.zeros((0, 3 if normals is None else 6)), *rows])
        sizes = tuple(len(row) for row in rows)
        return cls(name, whole[:, :3], sizes, look, None if normals is None else whole[:, 3:])

    def find_shown(self, view: View) -> NDArray[np.bool_]:
        """Find (n,) the points that do not face away from the viewer."""
        return _face(self.points, self.normals, view)

    def find_joined(self, view: View) -> NDArray[np.integer[Any]]:
        """Find (k,) the points that are shown and joined to the next one."""
        joined = np.ones(max(len(self.points) - 1, 0), np.bool_)
        joined[np.cumsum(np.array(self.sizes, np.int64))[:-1] - 1] = False
        shown = self.find_shown(view)
        return np.flatnonzero(joined & shown[:-1] & shown[1:])


def _face(points: Points, normals: Points | None, view: View) -> NDArray[np.bool_]:
    if normals is None:
        return np.ones(len(points), np.bool_)
    return normals @ view.axes[2] > AWAY


def _cut_dashes(row: Points, dash: float) -> list[Points]:
    """Cut a polyline (k, 3 + c) into dashes of this length with gaps as long."""
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(row[:, :3], axis=0), axis=1))]
    if along[-1] <= dash:
        return [row]
    count = max(1, round(along[-1] / (2.0 * dash)))
    step = along[-1] / count
    dashes: list[Points] = []
    for k in range(count):
        first, last = k * step, (k + 0.55) * step
        inner = along[(along > first) & (along < last)]
        at = np.r_[first, inner, last]
        dashes.append(
            np.stack([np.interp(at, along, row[:, c]) for c in range(row.shape[1])], axis=1)
        )
    return dashes


@dataclass(frozen=True, slots=True, eq=False)
class Marks:
    """Flat shapes that face the viewer.

    places: (n, 3). outline: (k, 2) around each in points of the picture, seen whole from its
    middle, or (n, k, 2) one of its own for each. hole: the part of it that is left out, for rings.
    normals: as of :class:`Curves`.
    """

    name: str
    places: Points
    outline: Points
    colour: str
    lift: Lift
    normals: Points | None = None
    hole: float = 0.0

    def find_shown(self, view: View) -> NDArray[np.bool_]:
        """Find (n,) the places that do not face away from the viewer."""
        return _face(self.places, self.normals, view)


Layer = Faces | Curves | Marks


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A whole picture: layers in space, and a flat scene over them.

    view: from where the layers are looked at. middle: of the view, in points of the scene. look:
    how faces are shown.
    """

    scene: Scene
    layers: Sequence[Layer]
    view: View
    middle: tuple[float, float]
    look: StageLook = PLAIN

    @classmethod
    def flat(cls, scene: Scene) -> Drawn:
        """Of a scene alone."""
        return cls(scene, (), View(np.eye(3), np.zeros(3), 1.0), (0.0, 0.0))


def make_discs(
    name: str,
    places: Points,
    colour: str,
    radius: float,
    lift: Lift,
    normals: Points | None = None,
) -> Marks:
    """Make discs at places (n, 3), their radius in points."""
    return Marks(name, places, style.make_circle() * radius, colour, lift, normals)


def make_rings(
    name: str, places: Points, colour: str, radii: tuple[float, float], lift: Lift
) -> Marks:
    """Make rings at places (n, 3); radii: the inner and the outer one, in points."""
    outline = style.make_circle() * radii[1]
    return Marks(name, places, outline, colour, lift, hole=radii[0] / radii[1])


def make_valence_marks(
    name: str,
    places: Points,
    valences: Indices,
    radius: float,
    lift: Lift,
    normals: Points | None = None,
) -> list[Layer]:
    """Make the markers of irregular vertices (n, 3), their shape and colour by their valence."""
    layers: list[Layer] = []
    for valence in np.unique(valences).tolist():
        at = valences == valence
        up = None if normals is None else normals[at]
        shape, colour = style.choose_valence_shape(valence), style.choose_valence_colour(valence)
        for part, size, ink, raised in (
            ("rim", radius + 1.1, style.PAPER, lift),
            ("mark", radius, colour, lift.above(0.4)),
        ):
            layers.append(
                Marks(f"{name} {valence} {part}", places[at], shape * size, ink, raised, up)
            )
    return layers


@dataclass(frozen=True, slots=True, eq=False)
class SmoothFaces:
    """Faces cut apart at their creases, turned alike.

    points: (m, 3). faces: (f, 3) or (f, 4). normals: (m, 3). place: (m,) which point each was.
    """

    points: Points
    faces: Indices
    normals: Points
    place: Indices

    @classmethod
    def of(cls, points: Points, faces: Indices) -> SmoothFaces:
        """Of points (n, 3) and faces (f, 3) or (f, 4)."""
        import pyvista as pv

        if not len(faces):
            return cls(points, faces, np.zeros_like(points), np.arange(len(points)))
        mesh: Any = pv.PolyData.from_regular_faces(
            np.asarray(points, np.float32), np.asarray(faces, np.int64)
        )
        mesh.point_data["place"] = np.arange(len(points))
        mesh = mesh.compute_normals(
            cell_normals=False,
            split_vertices=True,
            feature_angle=CREASE,
            consistent_normals=True,
            non_manifold_traversal=False,
        )
        place = np.asarray(mesh.point_data["place"])
        return cls(
            points[place],
            np.asarray(mesh.regular_faces),
            np.asarray(mesh.point_normals),
            place,
        )


class LayerCache:
    """Keeps what was made of the same inputs: a stage need not send it to VTK again."""

    def __init__(self) -> None:
        self._kept: dict[str, tuple[tuple[Any, ...], Any]] = {}

    def get(self, name: str, inputs: tuple[object, ...], make: Callable[[], Any]) -> Any:
        """Return what was made under a name, made again if an input is not the same object, or an
        equal number or text."""
        before = self._kept.get(name)
        if before is None or not _are_same(before[0], inputs):
            before = self._kept[name] = (inputs, make())
        return before[1]


def _are_same(one: tuple[Any, ...], other: tuple[Any, ...]) -> bool:
    plain = (int, float, str, frozenset)
    return len(one) == len(other) and all(
        a is b or (isinstance(a, plain) and a == b) for a, b in zip(one, other, strict=True)
    )


class LayerStage:
    """Shows layers, and a flat scene over them, on a pyvista plotter.

    texts: are the flat scene's texts written by VTK, too? A window writes them itself.
    """

    def __init__(self, plotter: Any, *, texts: bool = True) -> None:
        from vtkmodules.vtkRenderingCore import vtkLight

        self._plotter = plotter
        self._look = PLAIN
        self._actors: dict[str, _LayerActor] = {}
        self._flat = _FlatActor(plotter.renderer)
        self._texts: list[Any] | None = [] if texts else None
        plotter.renderer.RemoveAllLights()
        plotter.renderer.SetAutomaticLightCreation(False)
        for direction, strength in ((KEY, OF_KEY), (FILL, OF_FILL)):
            light = vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*direction)
            light.SetFocalPoint(0.0, 0.0, 0.0)
            light.SetIntensity(strength)
            plotter.renderer.AddLight(light)

    def show(self, drawn: Drawn, density: float = 1.0, *, turning: bool = False) -> bool:
        """Show a picture instead of what was there; return whether all of it is shown.

        density: pixels to a point. turning: does the view change just now? Of more than LARGE
        faces only a coarse likeness is shown then.
        """
        layers, view, scene, middle = drawn.layers, drawn.view, drawn.scene, drawn.middle
        gone = set(self._actors) - {layer.name for layer in layers}
        if drawn.look != self._look:
            self._look, gone = drawn.look, set(self._actors)
            self._plotter.renderer.SetUseDepthPeeling(drawn.look.x_ray)
            self._plotter.renderer.SetMaximumNumberOfPeels(PEELS)
        for name in gone:
            self._actors.pop(name).remove()
        for layer in layers:
            actor = self._actors.get(layer.name)
            if actor is None or actor.kind is not type(layer):
                if actor is not None:
                    actor.remove()
                actor = ACTORS[type(layer)](self._plotter.renderer, self._look)
                self._actors[layer.name] = actor
            actor.show(layer, view, density)
        shown = [actor.simplify(turning=turning) for actor in self._actors.values()]
        low, high = self._aim(view, scene, middle)
        self._flat.show(scene.patches, view, middle, high, ROOM * (high - low))
        if self._texts is not None:
            self._write(scene, density)
        return all(shown)

    def follow(self, drawn: Drawn, *, aim: bool = True) -> None:
        """Show a picture, and from now on keep to the plotter's camera, whoever moves it.

        aim: point the camera as the picture's view does.
        """
        camera: Any = self._plotter.renderer.GetActiveCamera()
        before = [np.array(camera.GetPosition()), np.array(camera.GetFocalPoint())]
        up, angle = camera.GetViewUp(), camera.GetParallelScale()
        self.show(drawn)
        if not aim:
            camera.SetPosition(*before[0])
            camera.SetFocalPoint(*before[1])
            camera.SetViewUp(*up)
            camera.SetParallelScale(angle)
        self._plotter.camera_set = True
        self._plotter.renderer.ResetCameraClippingRange()
        seen = [drawn.view]

        def keep(*_: object) -> None:
            view = self._find_view()
            if not (np.allclose(view.axes, seen[0].axes) and view.scale == seen[0].scale):
                seen[0] = view
                for layer in drawn.layers:
                    self._actors[layer.name].show(layer, view, 1.0)

        self._plotter.renderer.AddObserver("StartEvent", keep)

    def _find_view(self) -> View:
        """Find the view of the plotter's camera."""
        camera: Any = self._plotter.renderer.GetActiveCamera()
        focus, eye = np.array(camera.GetFocalPoint()), np.array(camera.GetPosition())
        away = float(np.linalg.norm(eye - focus))
        z = (eye - focus) / max(away, 1e-300)
        x = np.cross(camera.GetViewUp(), z)
        x /= max(float(np.linalg.norm(x)), 1e-300)
        half = camera.GetParallelScale()
        if not camera.GetParallelProjection():
            half = away * np.tan(np.radians(camera.GetViewAngle() / 2.0))
        height = self._plotter.render_window.GetSize()[1]
        return View(np.stack([x, np.cross(z, x), z]), focus, height / 2.0 / half)

    def _aim(self, view: View, scene: Scene, middle: tuple[float, float]) -> tuple[float, float]:
        """Point the camera; returns how deep what is shown lies, along the line of sight."""
        ranges = [actor.find_depths(view) for actor in self._actors.values()]
        ranges = [one for one in ranges if one is not None]
        focus = float(view.focus @ view.axes[2])
        low = min([focus - 1.0 / view.scale, *(one[0] for one in ranges)])
        high = max([focus + 1.0 / view.scale, *(one[1] for one in ranges)])
        room = ROOM * (high - low)
        x, y = scene.width / 2.0 - middle[0], scene.height / 2.0 - middle[1]
        at = view.under(x, y)
        at = at + (high + 4.0 * room - float(at @ view.axes[2])) * view.axes[2]
        # Not by pyvista's properties, each of which looks how large all of the scene is.
        camera: Any = self._plotter.renderer.GetActiveCamera()
        half = scene.height / 2.0 / view.scale
        camera.SetViewUp(*view.axes[1])
        camera.SetParallelScale(half)
        camera.SetParallelProjection(not self._look.perspective)
        if self._look.perspective:
            # As large as without perspective, where the focus is.
            away = half / np.tan(np.radians(camera.GetViewAngle() / 2.0))
            camera.SetPosition(*(view.under(x, y) + away * view.axes[2]))
            camera.SetFocalPoint(*view.under(x, y))
            near = max(away + focus - high - 2.0 * room, 0.01 * away)
            camera.SetClippingRange(near, max(away + focus - low + 2.0 * room, 2.0 * near))
        else:
            camera.SetPosition(*at)
            camera.SetFocalPoint(*(at - (high - low + 4.0 * room) * view.axes[2]))
            camera.SetClippingRange(room, high - low + 6.0 * room)
        return low, high

    def _write(self, scene: Scene, density: float) -> None:
        from vtkmodules.vtkRenderingCore import vtkTextActor

        renderer = self._plotter.renderer
        for actor in self._texts or ():
            renderer.RemoveActor(actor)
        self._texts = []
        for text in scene.texts:
            actor = vtkTextActor()
            actor.SetInput(text.text)
            actor.SetPosition(text.x * density, (text.y - DESCENT * text.size) * density)
            letters: Any = actor.GetTextProperty()
            # 4 is a font of one's own.
            letters.SetFontFamily(4)
            letters.SetFontFile(find_font(bold=text.bold, mono=text.mono))
            letters.SetFontSize(round(text.size * density))
            letters.SetColor(*style.parse_colour(text.colour))
            letters.SetJustification({"left": 0, "center": 1, "right": 2}[text.align])
            renderer.AddActor(actor)
            self._texts.append(actor)


def find_font(*, bold: bool, mono: bool) -> str:
    """Find the file of a font of pictures."""
    name = f"DejaVuSans{'Mono' if mono else ''}{'-Bold' if bold else ''}.ttf"
    return next(file for file in list_font_files() if Path(file).name == name)


class _LayerActor:
    """The actor of a layer. kind: of which layers."""

    kind: type[Any]

    def __init__(self, renderer: Any, look: StageLook) -> None:
        from vtkmodules.vtkCommonDataModel import vtkPlane
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        self._renderer, self._look = renderer, look
        self._mapper = vtkPolyDataMapper()
        self._mapper.ScalarVisibilityOff()
        if look.clip is not None:
            plane = vtkPlane()
            plane.SetOrigin(*look.clip[0])
            plane.SetNormal(*(-look.clip[1]))
            self._mapper.AddClippingPlane(plane)
        self._actors: list[Any] = [vtkActor()]
        self._mesh: Any = None
        self._corners: Points | None = None
        self._lift = 0.0
        self._layer: Any = None
        for actor in self._actors:
            actor.SetMapper(self._mapper)
            renderer.AddActor(actor)

    def remove(self) -> None:
        """Take it away."""
        for actor in self._actors:
            self._renderer.RemoveActor(actor)

    def show(self, layer: Any, view: View, density: float) -> None:
        """Show a layer of its kind."""
        raise NotImplementedError

    def simplify(self, *, turning: bool) -> bool:
        """Show a coarse likeness while the view turns, if it is large; is all of it shown?"""
        return True

    def find_depths(self, view: View) -> tuple[float, float] | None:
        """Find how near it is along the line of sight: least and most; None if it is empty."""
        if self._corners is None:
            return None
        deep = self._corners @ view.axes[2]
        return float(deep.min()) - abs(self._lift), float(deep.max()) + abs(self._lift)

    def _put(self, mesh: Any) -> None:
        self._mesh = mesh
        self._mapper.SetInputData(mesh)
        self._corners = None
        if mesh.n_points:
            box = np.array(mesh.bounds).reshape(3, 2)
            self._corners = np.stack(np.meshgrid(*box), axis=-1).reshape(-1, 3)

    def _raise(self, view: View, lift: float) -> None:
        """Draw it nearer by so much of space; the second actor as much farther off."""
        self._lift = lift
        for actor, way in zip(self._actors, (1.0, -1.0), strict=False):
            actor.SetPosition(*(way * lift * view.axes[2]))

    def _paint(self, colour: str) -> None:
        for actor in self._actors:
            actor.GetProperty().SetColor(*style.parse_colour(colour))


class _FacesActor(_LayerActor):
    kind = Faces
    _place: Indices | None = None
    _coarse: Any = None

    def show(self, layer: Faces, view: View, density: float) -> None:
        before: Faces | None = self._layer
        self._layer = layer
        if before is None or not (
            layer.points is before.points
            and layer.faces is before.faces
            and layer.normals is before.normals
        ):
            self._send(layer)
            before = None
        if before is None or (layer.faded, layer.sheets) != (before.faded, before.sheets):
            self._finish(layer)
        if before is None or not (
            layer.face_colours is before.face_colours
            and layer.point_colours is before.point_colours
            and (layer.colour, layer.back) == (before.colour, before.back)
        ):
            self._colour(layer)
        lift = layer.lift.measure(view)
        if layer.faded and self._corners is not None:
            size = float(np.linalg.norm(np.ptp(self._corners, axis=0)))
            lift = -BEHIND[0] * size - BEHIND[1] / view.scale
        self._raise(view, lift)

    def _send(self, layer: Faces) -> None:
        import pyvista as pv

        if layer.normals is None:
            smooth = SmoothFaces.of(layer.points, layer.faces)
            self._place = smooth.place
            points, faces, normals = smooth.points, smooth.faces, smooth.normals
        else:
            self._place = None
            points, faces, normals = layer.points, layer.faces, layer.normals
        mesh: Any = pv.PolyData.from_regular_faces(
            np.asarray(points, np.float32), np.asarray(faces, np.int64)
        )
        mesh.point_data.active_normals = np.asarray(normals, np.float32)
        self._coarse = None
        self._put(mesh)

    def _colour(self, layer: Faces) -> None:
        from vtkmodules.vtkRenderingCore import vtkProperty

        mesh = self._mesh
        for data in (mesh.point_data, mesh.cell_data):
            if "colour" in data:
                del data["colour"]
        colours = layer.face_colours if len(layer.faces) else None
        self._mapper.SetScalarModeToUseCellFieldData()
        if colours is None and layer.point_colours is not None and len(layer.points):
            colours = layer.point_colours
            if self._place is not None:
                colours = colours[self._place]
            self._mapper.SetScalarModeToUsePointFieldData()
            mesh.point_data.set_array(_to_bytes(colours), "colour")
        elif colours is not None:
            mesh.cell_data.set_array(_to_bytes(colours), "colour")
        self._mapper.SetScalarVisibility(colours is not None)
        self._mapper.SelectColorArray("colour")
        self._mapper.SetColorModeToDirectScalars()
        self._paint(layer.colour)
        back = None
        if layer.back:
            back = vtkProperty()
            back.DeepCopy(self._actors[0].GetProperty())
            back.SetColor(*style.parse_colour(layer.back))
        self._actors[0].SetBackfaceProperty(back)

    def _finish(self, layer: Faces) -> None:
        from vtkmodules.vtkRenderingCore import vtkActor

        while len(self._actors) < 1 + layer.sheets:
            actor = vtkActor()
            actor.SetMapper(self._mapper)
            actor.GetProperty().SetColor(*style.parse_colour(layer.colour))
            self._renderer.AddActor(actor)
            self._actors.append(actor)
        while len(self._actors) > 1 + layer.sheets:
            self._renderer.RemoveActor(self._actors.pop())
        pale = FADED if layer.faded else 0.0
        for actor, culled in zip(self._actors, ("back", "front"), strict=False):
            finish = actor.GetProperty()
            finish.SetInterpolation(0 if self._look.shading == "flat" else 2)
            finish.SetRepresentation(1 if self._look.wire else 2)
            finish.SetOpacity(X_RAY if self._look.x_ray else 1.0)
            if self._look.shading == "matcap":
                actor.GetShaderProperty().AddFragmentShaderReplacement(
                    "//VTK::Light::Impl", True, MATCAP, False
                )
            finish.SetAmbient(pale + (1.0 - pale) * AMBIENT)
            finish.SetDiffuse(1.0 - pale)
            finish.SetBackfaceCulling(layer.sheets and culled == "back")
            finish.SetFrontfaceCulling(layer.sheets and culled == "front")

    def simplify(self, *, turning: bool) -> bool:
        large = self._mesh.n_cells > LARGE and not self._mapper.GetScalarVisibility()
        if not (turning and large):
            self._mapper.SetInputData(self._mesh)
            return True
        if self._coarse is None:
            self._coarse = _coarsen(self._mesh)
        self._mapper.SetInputData(self._coarse)
        return False


def _coarsen(mesh: Any) -> Any:
    """Make a likeness of a large mesh, of some ten thousand faces."""
    import pyvista as pv
    from vtkmodules.vtkFiltersCore import vtkQuadricClustering

    clusters = vtkQuadricClustering()
    clusters.SetInputData(mesh)
    clusters.SetNumberOfDivisions(CELLS, CELLS, CELLS)
    clusters.Update()
    coarse: Any = pv.wrap(clusters.GetOutput())
    return coarse.compute_normals(cell_normals=False, feature_angle=CREASE, split_vertices=True)


class _CurvesActor(_LayerActor):
    kind = Curves
    _joined: Indices | None = None

    def show(self, layer: Curves, view: View, density: float) -> None:
        import pyvista as pv

        before: Curves | None = self._layer
        self._layer = layer
        fresh = before is None or layer.points is not before.points or layer.sizes != before.sizes
        if fresh:
            mesh = pv.PolyData()
            mesh.points = np.asarray(layer.points, np.float32)
            self._put(mesh)
        joined = layer.find_joined(view)
        if fresh or self._joined is None or not np.array_equal(joined, self._joined):
            self._joined = joined
            self._connect(layer, joined)
        look = layer.look
        if fresh or before is None or look.colour != before.look.colour:
            self._paint(look.colour)
        finish = self._actors[0].GetProperty()
        width = max(look.width * density, 1.0)
        finish.SetLineWidth(width)
        finish.SetPointSize(width)
        finish.SetRenderPointsAsSpheres(True)
        is_round = look.width >= ROUND
        finish.SetRenderLinesAsTubes(is_round)
        finish.SetLighting(is_round)
        finish.SetAmbient(RIM if is_round else 1.0)
        finish.SetDiffuse(is_round)
        # Round ones are nearer in their middle: those that cross lie as their lifts say.
        lift = look.lift.above(-look.width / 2.0) if is_round else look.lift
        self._raise(view, lift.measure(view))

    def _connect(self, layer: Curves, first: Indices) -> None:
        """Join points to their next ones, and round their corners."""
        self._mesh.lines = np.stack([np.full(len(first), 2), first, first + 1], axis=1).ravel()
        rounded = np.zeros(0, np.int64)
        if layer.look.width >= ROUND and len(first):
            step = np.zeros((len(layer.points) + 1, 3))
            way = layer.points[first + 1] - layer.points[first]
            size = np.linalg.norm(way, axis=1, keepdims=True)
            step[first + 1] = way / np.where(size > 0.0, size, 1.0)
            bent = (step[:-1] * step[1:]).sum(axis=1) < STRAIGHT
            touched = np.union1d(first, first + 1)
            rounded = touched[bent[touched]]
        self._mesh.verts = np.stack([np.ones(len(rounded), np.int64), rounded], axis=1).ravel()


class _MarksActor(_LayerActor):
    kind = Marks
    _seen: tuple[Any, ...] = ()

    def show(self, layer: Marks, view: View, density: float) -> None:
        before: Marks | None = self._layer
        self._layer = layer
        now = (layer.places, layer.outline, layer.normals, view.axes, view.scale, layer.hole)
        if not _are_same(self._seen, now):
            self._seen = now
            corners = _face_viewer(layer, view)
            self._put(_make_triangles(corners))
        if before is None or layer.colour != before.colour:
            self._paint(layer.colour)
            self._actors[0].GetProperty().SetLighting(False)
        self._raise(view, layer.lift.measure(view))


ACTORS: dict[type[Any], type[_LayerActor]] = {
    Faces: _FacesActor,
    Curves: _CurvesActor,
    Marks: _MarksActor,
}


def _face_viewer(layer: Marks, view: View) -> Points:
    """(t, 3, 3) the triangles of marks in space."""
    shown = layer.find_shown(view)
    places = layer.places[shown]
    outline = layer.outline[shown] if layer.outline.ndim == 3 else layer.outline
    rim = outline @ view.axes[:2] / view.scale
    around = places[:, None] + np.broadcast_to(rim, (len(places), *rim.shape[-2:]))
    inner = places[:, None] + layer.hole * (around - places[:, None])
    after = np.roll(around, -1, axis=1)
    fan = [np.stack([inner, around, after], axis=2)]
    if layer.hole > 0.0:
        fan.append(np.stack([inner, after, np.roll(inner, -1, axis=1)], axis=2))
    return np.concatenate(fan, axis=1).reshape(-1, 3, 3)


def _make_triangles(corners: Points) -> Any:
    """Make a mesh of triangles (t, 3, 3)."""
    import pyvista as pv

    if not len(corners):
        return pv.PolyData()
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    return pv.PolyData.from_regular_faces(corners.reshape(-1, 3).astype(np.float32), faces)


def _to_bytes(colours: NDArray[Any]) -> NDArray[np.uint8]:
    return np.clip(colours * 255.0 + 0.5, 0.0, 255.0).astype(np.uint8)


class _FlatActor:
    """The flat polygons of a picture, before everything else."""

    def __init__(self, renderer: Any) -> None:
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        self._mapper = vtkPolyDataMapper()
        self._actor = vtkActor()
        self._actor.SetMapper(self._mapper)
        self._actor.GetProperty().SetLighting(False)
        renderer.AddActor(self._actor)

    def show(
        self,
        patches: list[ScenePolygons],
        view: View,
        middle: tuple[float, float],
        depth: float,
        room: float,
    ) -> None:
        """Show polygons in points of the picture, later ones nearer: from ``depth`` on, along the
        line of sight, in ``room`` of space."""
        from vtkmodules.vtkCommonMath import vtkMatrix4x4

        corners, colours = fan_polygons(patches)
        mesh = _make_triangles(corners)
        if len(corners):
            mesh.point_data.set_array(_to_bytes(colours.reshape(-1, 3)), "colour")
        self._mapper.SetInputData(mesh)
        self._mapper.SetScalarModeToUsePointFieldData()
        self._mapper.SelectColorArray("colour")
        self._mapper.SetColorModeToDirectScalars()
        self._actor.SetVisibility(len(corners) > 0)
        place = np.eye(4)
        place[:3, :2] = view.axes[:2].T / view.scale
        place[:3, 2] = view.axes[2] * room / max(len(patches), 1)
        deep = depth + room - float(view.focus @ view.axes[2])
        place[:3, 3] = view.under(-middle[0], -middle[1]) + deep * view.axes[2]
        matrix = vtkMatrix4x4()
        matrix.DeepCopy(place.ravel().tolist())
        self._actor.SetUserMatrix(matrix)


def fan_polygons(patches: list[ScenePolygons]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Cut polygons into triangles about their middles: (t, 3, 3) corners and (t, 3, 3) colours.

    Later layers are nearer. What is painted over a scene (lines, discs, stars, boxes) is seen
    whole from its middle; a polygon that is not would be filled beyond its outline.
    """
    corners: list[NDArray[Any]] = [np.zeros((0, 3, 3))]
    colours: list[NDArray[Any]] = [np.zeros((0, 3, 3))]
    for layer, patch in enumerate(patches):
        outline = patch.corners
        n, c = outline.shape[:2]
        if c == 3:
            flat = outline[:, None]
        elif c == 4:
            flat = outline[:, [[0, 1, 2], [0, 2, 3]]]
        else:
            middle = np.broadcast_to(outline.mean(axis=1, keepdims=True), outline.shape)
            flat = np.stack([middle, outline, np.roll(outline, -1, axis=1)], axis=2)
        flat = flat.reshape(-1, 3, 2)
        z = np.full((*flat.shape[:2], 1), float(layer))
        corners.append(np.concatenate([flat, z], axis=2))
        each = np.repeat(patch.colours, len(flat) // max(n, 1), axis=0)
        colours.append(np.broadcast_to(each[:, None], (len(flat), 3, 3)))
    return np.concatenate(corners), np.concatenate(colours)
