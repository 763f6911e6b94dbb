"""Commands of several windows: how a model is looked at, and what a crash left."""

from __future__ import annotations

from typing import Any

from viewer.commands import Command

#: For windows whose state has the ``files`` that work is kept in, and a ``recover``.
RECOVER: Command[Any] = Command(
    "recover", "Open what a crash left", "File", ("R",), lambda s: s.recover(),
    "Take the work that a crash left, in place of what is here",
    enabled=lambda s: s.files is not None and s.files.lost is not None,
)  # fmt: skip

#: For all windows: how faces are shown.
LOOKS: tuple[Command[Any], ...] = (
    Command("shading", "Next shading", "View", ("Y",), lambda s: s.next_shading(),
            "Light from both sides, clay, or every face by itself"),
    Command("x-ray", "X-ray", "View", ("X",), lambda s: s.toggle_look("x_ray"),
            "See through faces", checked=lambda s: s.camera.face_look.x_ray),
    Command("wire", "Wire frame", "View", ("W",), lambda s: s.toggle_look("wire"),
            "Only the edges of triangles", checked=lambda s: s.camera.face_look.wire),
)  # fmt: skip

#: A direction (3,).
Direction = tuple[float, float, float]

#: What is seen along each of the three directions.
NAMES = ("front", "side", "above")


def model_commands(
    keys: tuple[str, str, str],
    directions: tuple[Direction, Direction, Direction],
    others: tuple[str, str, str, str],
) -> tuple[Command[Any], ...]:
    """Make the commands of a state with a :class:`viewer.camera.ModelCamera`.

    keys: that look along the directions, from the front, the side and above. others: the keys of
    the model's look, of framing all, of the axis that is upright, and of rolling.
    """
    look, frame, upright, roll = others
    return (
        *LOOKS,
        Command("model-look", "Next look of the model", "View", (look,),
                lambda s: s.next_model_look(),
                "The model solid, transparent, or hidden"),
        Command("frame-all", "Frame all", "View", (frame, "Home"), lambda s: s.camera.fit(),
                "All into the middle, as seen at first", bar=True),
        *(
            Command(f"view-{name}", f"From the {name}" if name != "above" else "From above",
                    "View", (key,), lambda s, way=way: s.camera.look_along(way),
                    "Again: from the other side")
            for name, key, way in zip(NAMES, keys, directions, strict=True)
        ),
        Command("upright", "Next upright axis", "View", (upright,),
                lambda s: s.camera.next_upright(), "Another axis of the model is upright"),
        Command("roll", "Roll the view", "View", (roll,), lambda s: s.camera.roll(),
                "A quarter turn about the line of sight"),
    )  # fmt: skip
