"""Values of options on feature curves and shapes: directions, shapes to learn, modes, drags."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import click

from patterndb_app.cli.options import FileName, ParamType


def three_numbers(text: str) -> tuple[float, float, float] | None:
    """The numbers of 1,0,0.5; None if the text is not three finite ones."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        return None
    return (x, y, z) if all(map(math.isfinite, (x, y, z))) else None


#: Directions by the names of axes.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class Direction(ParamType):
    """A direction: x, y, z or three numbers, 1,0,0.5."""

    name = "direction"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float, float]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        found = AXES.get(str(value)) or three_numbers(str(value))
        if found is None or not any(found):
            self.fail(f"{value!r} is no direction like z or 1,0,0.5", param, ctx)
        return found


class Source(ParamType):
    """A shape to learn: MODEL=NETWORK, or a mesh that has the template's quads."""

    name = "source"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[Path, Path | None]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        # A file whose name has a = is that file.
        model, equals, network = (str(value), "", "")
        if not Path(str(value)).exists():
            model, equals, network = str(value).rpartition("=")
            if not equals:
                model, network = network, ""
        file = FileName()
        mesh = file.convert(model, param, ctx)
        return mesh, file.convert(network, param, ctx) if equals else None


class Mode(ParamType):
    """A mode and its standard deviations: 1=2.0."""

    name = "k=sigmas"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, float]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        match = re.fullmatch(r"([0-9]{1,9})=(.+)", str(value))
        try:
            number, sigmas = (int(match[1]), float(match[2])) if match else (0, math.nan)
        except ValueError:
            number, sigmas = 0, math.nan
        if number < 1 or not math.isfinite(sigmas):
            self.fail(f"{value!r} is not a mode and its deviations like 1=2.0", param, ctx)
        return number, sigmas


class Drag(ParamType):
    """A feature and how it is displaced: roof_rail=0,0,0.1."""

    name = "feature=dx,dy,dz"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, tuple[float, float, float]]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        feature, _, numbers = str(value).rpartition("=")
        by = three_numbers(numbers)
        if not feature or by is None:
            self.fail(f"{value!r} is not like roof_rail=0,0,0.1", param, ctx)
        return feature, by


class Hold(ParamType):
    """A feature and the weight that holds it: sill=0.5; 1 if only the feature is given."""

    name = "feature[=weight]"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, float]:
        if isinstance(value, tuple):
            return value  # pyright: ignore[reportUnknownVariableType]
        feature, equals, number = str(value).partition("=")
        try:
            weight = float(number) if equals else 1.0
        except ValueError:
            weight = math.nan
        if not feature or not (math.isfinite(weight) and weight >= 0.0):
            self.fail(f"{value!r} is not a feature and a weight like sill=0.5", param, ctx)
        return feature, weight
