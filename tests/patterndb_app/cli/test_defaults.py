"""What the help says of defaults is what the program does without the option."""

from __future__ import annotations

from collections.abc import Iterator
from inspect import signature
from math import degrees

import click
import pytest

from patterndb_app.cli import cli
from patterndb_app.cli.features import AXES
from patterndb_sketch.features.registration import register
from patterndb_sketch.features.snap import SnapSettings
from patterndb_sketch.retopo.sizes import EDGE
from patterndb_sketch.retopo.tools.draft import DRAFT
from patterndb_sketch.surfacing.methods import DEFAULT_METHOD, SurfaceRequest
from tests.support.cli.commandline import run

SNAP, SURFACE = SnapSettings(), SurfaceRequest()
DELTA, ROUNDS = (signature(register).parameters[name].default for name in ("delta", "rounds"))

#: What the sketch verbs do without an option: the library's own defaults, as help writes them.
#: Every option of theirs that has a default is here.
USED = {
    ("features", "alpha"): SNAP.alpha,
    ("features", "beta"): degrees(SNAP.beta),
    ("features", "axis"): next(name for name, axis in AXES.items() if axis == SNAP.axis),
    ("features", "stiffness"): SNAP.stiffness,
    ("features", "degree"): SNAP.degree,
    ("features", "reach"): SNAP.radius,
    ("features", "rounds"): SNAP.rounds,
    ("register", "delta"): DELTA,
    ("register", "rounds"): ROUNDS,
    ("shape-model build", "delta"): DELTA,
    ("shape-model build", "rounds"): ROUNDS,
    ("shape-model sample", "seed"): 0,
    ("surface", "method"): DEFAULT_METHOD,
    ("surface", "alpha"): SURFACE.alpha,
    ("surface", "tolerance"): "what follows from the drawing",
    ("surface", "up"): "y",
    ("retopo", "sides"): "home",
    ("retopo", "sharp"): DRAFT.arguments["sharp"].default,
    ("retopo", "edge"): f"{100.0 * EDGE:g} % of the diagonal",
}

SKETCH = ("features", "register", "shape-model", "surface", "retopo")


def list_commands(group: click.Group, name: str = "") -> Iterator[tuple[str, click.Command]]:
    """Every verb by its whole name."""
    context = click.Context(group)
    for one in group.list_commands(context):
        command = group.get_command(context, one)
        assert command is not None
        whole = f"{name} {one}".strip()
        if isinstance(command, click.Group):
            yield from list_commands(command, whole)
        else:
            yield whole, command


COMMANDS = dict(list_commands(cli))


def tell_default(command: click.Command, option: click.Option) -> str | None:
    """What the help of an option says of its default."""
    record = option.get_help_record(click.Context(command))
    text = "" if record is None else record[1]
    said = text.partition("[default: ")[2].partition("]")[0]
    # click writes a default that it was told in brackets, and limits after it.
    return said.removeprefix("(").partition("); x")[0].removesuffix(")") or None


@pytest.mark.parametrize("name", COMMANDS)
def test_every_default_is_told_as_it_is(name: str) -> None:
    """Options with a default say it, and what they say is the default; of flags, and of those for
    which nothing is nothing, there is nothing to say."""
    command = COMMANDS[name]
    for option in command.params:
        if not isinstance(option, click.Option) or option.is_flag or option.count:
            continue
        default = option.default
        if isinstance(default, bool) or not isinstance(default, (int, float, str)) or default == "":
            continue
        told = tell_default(command, option)
        assert told is not None, f"{name} --{option.name} does not tell its default, {default!r}"
        if option.show_default is True:
            assert told.split(";")[0] == str(default), f"{name} --{option.name}"


@pytest.mark.parametrize("name", [one for one in COMMANDS if one.split()[0] in SKETCH])
def test_sketch_verbs_tell_what_the_library_does(name: str) -> None:
    """All that is told is in the table, from the library's own signatures, and as it is there."""
    command = COMMANDS[name]
    told = {
        (name, str(option.name)): text
        for option in command.params
        if isinstance(option, click.Option) and (text := tell_default(command, option)) is not None
    }
    wanted = {key: value for key, value in USED.items() if key[0] == name}
    assert set(told) == set(wanted)
    for key, value in wanted.items():
        shown = told[key]
        if isinstance(value, str):
            assert shown == value, key
        else:
            assert float(shown.split(";")[0]) == pytest.approx(float(value)), key


def test_the_page_says_the_same() -> None:
    """What the program prints, not only what its options hold."""
    text = " ".join(run("features", "--help").out.split())
    assert f"[default: {SNAP.rounds}; 1<=x<=100]" in text
    assert f"[default: {SNAP.radius:g}; " in text
