"""What several verbs share: their options and the values of these, and the way to a database, a
boundary and a model."""

from __future__ import annotations

import contextlib
import math
import re
import sys
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast, overload

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem
from msgspec.inspect import BoolType, FloatType, IntType, TupleType, VarTupleType

from patterndb import STARTER_NAME
from patterndb.system.deadline import limit_time
from patterndb.system.extras import require_extra
from patterndb.system.numbers import MOST_COUNT
from patterndb.system.requests import Option, Request, list_options, strip_type
from patterndb_app.cli.progressline import ProgressLine
from patterndb_app.cli.text import say

if TYPE_CHECKING:
    from patterndb.geometry.surface import Surface
    from patterndb.store import Database, DatabaseUnion
    from patterndb.store.connection import Mode
    from patterndb_app.client.remote import RemoteDatabase
    from query import Boundary

    # Generic for the type checker alone: older releases of click have a plain class.
    ParamType = click.ParamType[Any, Any]
else:
    ParamType = click.ParamType


F = TypeVar("F", bound=Callable[..., Any])


class Count(click.IntRange):
    """A whole number from ``least`` to ``most``: of fills, quads, edges, bytes, threads.

    Every option that counts has this type, so that no number is larger than what it is used for.
    """

    def __init__(self, least: int = 0, most: int = MOST_COUNT) -> None:
        super().__init__(least, most)
        self.least, self.most = least, most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        number = click.INT.convert(value, param, ctx)
        if not self.least <= number <= self.most:
            shown = str(value)
            shown = shown if len(shown) <= SHOWN_DIGITS else shown[:SHOWN_DIGITS] + "…"
            self.fail(f"{shown} is not in the range {self.least}<=x<={self.most}.", param, ctx)
        return number

    def _describe_range(self) -> str:
        """Describe the range for the help, which leaves the general bound out."""
        if self.most in (MOST_COUNT, MOST_BYTES):
            return f"x>={self.least}"
        return f"{self.least}<=x<={self.most}"


#: The largest size of a file that a system can report.
MOST_BYTES = 2**63 - 1

#: Digits of a number that a message shows.
SHOWN_DIGITS = 24


class FileName(ParamType):
    """The name of a file or folder, which need not be there.

    reads, writes: does the verb read what is there, and write it?
    """

    name = "file"

    def __init__(self, *, reads: bool = True, writes: bool = False) -> None:
        self.reads = reads
        self.writes = writes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        if not str(value):
            # Path("") would be the present folder: a slip, such as a shell variable unset.
            self.fail("the name is empty", param, ctx)
        if str(value) == "-":
            # Elsewhere it stands for stdin or stdout; here it would be a file of that name.
            self.fail("- is not a file: name one (./- if it is called so)", param, ctx)
        if re.match(r"[A-Za-z][\w+.-]+://", str(value)):
            options = set[str]() if ctx is None else {o for p in ctx.command.params for o in p.opts}
            named = set[str]() if param is None else set(param.opts)
            by = "--server" if "--db" in named and "--server" in options else None
            how = f"give it as {by} to ask a service" if by else "download it, and name the file"
            self.fail(f"{value} is an address, not a file: {how}", param, ctx)
        if not is_text(str(value)):
            self.fail(f"{str(value)!r} is not UTF-8; rename the file", param, ctx)
        return Path(value)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Leave it to the shell, which knows its files; click alone would offer none."""
        return [CompletionItem(incomplete, type="file")]


class MeshName(FileName):
    """The name of a mesh file; what its format needs and is not installed is missed at once."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        path = super().convert(value, param, ctx)
        # Imported here because --help and wrong usage need not wait for it.
        from ingest.formats import FORMATS

        for format in FORMATS:
            if path.suffix.lower() in format.suffixes:
                format.require()
        return path


class FileToWrite(FileName):
    """A file to write, with one of the suffixes.

    what, doing: the words of messages. reads: does the verb go on from it where it is there?
    """

    def __init__(
        self, *suffixes: str, what: str = "file", doing: str = "write", reads: bool = False
    ) -> None:
        super().__init__(reads=reads, writes=True)
        self.suffixes = suffixes
        self.what = what
        self.doing = doing

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        path = super().convert(value, param, ctx)
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            self.fail(f"{value} must end in {' or '.join(self.suffixes)}", param, ctx)
        if path.is_dir():
            self.fail(f"{value} is a folder; name a {self.what} in it", param, ctx)
        if not path.absolute().parent.is_dir():
            self.fail(f"there is no folder {path.parent} to {self.doing} into", param, ctx)
        return path


OBJ = FileToWrite(".obj")


class MeshToWrite(FileToWrite):
    """A mesh file to write, in any format that there is for it."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        # Imported here because --help need not wait for it.
        from ingest.formats import WRITTEN_SUFFIXES

        self.suffixes = WRITTEN_SUFFIXES
        return super().convert(value, param, ctx)


def _refuse_inputs(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    """The callback of --overwrite: without it no file is written that is read.

    click reads what is given before what is not, so that all names of files are known here.
    """
    ctx.meta[_MAY_OVERWRITE] = value
    for reading in ctx.command.params:
        for path in _list_files(ctx.params.get(reading.name or "")):
            if getattr(reading.type, "reads", True):
                refuse_input(path, f"the file of {_name_parameter(reading)}", of=reading)


def refuse_input(path: Path, what: str, *, of: click.Parameter | None = None) -> None:
    """Raise UsageError where the verb that runs would write onto a file that it reads.

    Two names of one file, links and letters in another case, where the file system does not tell
    them apart, are one file. what: the file, for the message. of: the parameter that names it.
    """
    ctx = click.get_current_context(silent=True)
    if ctx is None or ctx.meta.get(_MAY_OVERWRITE, True) or not path.exists():
        return
    for writing in ctx.command.params:
        if writing is of or not getattr(writing.type, "writes", False):
            continue
        for output in _list_files(ctx.params.get(writing.name or "")):
            if output.exists() and output.samefile(path):
                raise click.UsageError(
                    f"{_name_parameter(writing)} {output} is {what}, {path}, which would be lost; "
                    "name another file, or give --overwrite"
                )


def _name_parameter(param: click.Parameter) -> str:
    """An option as it is written, an argument as the help shows it."""
    return param.opts[0] if isinstance(param, click.Option) else param.human_readable_name


#: The entry of the context's meta that keeps whether --overwrite is given.
_MAY_OVERWRITE = "patterndb.may_overwrite"


def _list_files(value: object) -> list[Path]:
    """The files that the value of a parameter names."""
    if isinstance(value, Path):
        return [value]
    if isinstance(value, DatabaseShare):
        return _list_files(value.path)
    if isinstance(value, tuple):
        return [path for one in cast("tuple[object, ...]", value) for path in _list_files(one)]
    return []


#: For every verb that writes a file and reads another.
may_overwrite = click.option(
    "--overwrite",
    is_flag=True,
    expose_value=False,
    callback=_refuse_inputs,
    help="Let a file be written onto one that is read. Other files are replaced in any case.",
)


def is_text(name: str) -> bool:
    """Can the name be kept in a database? Those that are no UTF-8 cannot."""
    return not any("\ud800" <= c <= "\udfff" for c in name)


#: For verbs that draw fills of --sides, or something else.
closed_option = click.option(
    "--closed", is_flag=True, help="With --sides: one closed side without a corner."
)


def provenance_options(things: str) -> Callable[[F], F]:
    """Give a verb the options of what is kept with meshes; things: what it learns."""

    def add_options(verb: F) -> F:
        for flags, help in (
            (("--licence", "--license"), "Their licence; kept with them."),
            (("--source",), "Where they come from; kept with them."),
            (("--author",), f"Who made the {things}; kept with them."),
        ):
            verb = click.option(*flags, metavar="TEXT", help=help)(verb)
        return verb

    return add_options


db_to_read = click.option(
    "--db",
    type=FileName(),
    metavar="FILE",
    help="The database to ask; the starter database if not given.",
)


@dataclass(frozen=True, slots=True)
class DatabaseShare:
    """One of several databases to ask. path: None for the starter database. weight: what its
    frequencies count."""

    path: Path | None
    weight: float = 1.0


#: What --db names: nothing (the starter database), one file, or several databases.
DatabaseChoice = Path | tuple[DatabaseShare, ...] | None


class DatabaseParam(ParamType):
    """A database and what its frequencies count: own.db, own.db=3; 1 if only the file is given."""

    name = "file[=weight]"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> DatabaseShare:
        if isinstance(value, DatabaseShare):
            return value
        # A file whose name has a = is that file.
        text, equals, number = (str(value), "", "")
        if "://" in text:
            FileName().convert(text, param, ctx)
        if not Path(text).exists():
            file, equals, number = text.rpartition("=")
            text = file if equals else text
        try:
            weight = float(number) if equals else 1.0
        except ValueError:
            weight = math.nan
        if not (math.isfinite(weight) and weight > 0):
            self.fail(f"{value!r} is no database and a weight above 0, like own.db=3", param, ctx)
        if text == STARTER_NAME:
            return DatabaseShare(None, weight)
        return DatabaseShare(FileName().convert(text, param, ctx), weight)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return FileName().shell_complete(ctx, param, incomplete)


def _choose_databases(
    ctx: click.Context, param: click.Parameter, value: tuple[DatabaseShare, ...]
) -> DatabaseChoice:
    if not value or value == (DatabaseShare(None),):
        return None
    # One database without a weight is asked as it stands.
    return value[0].path if len(value) == 1 and value[0].weight == 1.0 else value


dbs_to_read = click.option(
    "--db",
    type=DatabaseParam(),
    multiple=True,
    callback=_choose_databases,
    metavar="FILE[=WEIGHT]",
    help="The database to ask; the starter database if not given. Given again, all are asked as "
    f"one, what each has seen times its weight; {STARTER_NAME} is the starter database.",
)

db_to_write = click.option(
    "--db",
    type=FileName(),
    metavar="FILE",
    required=True,
    help="The database to change.",
)

server_to_ask = click.option(
    "--server",
    metavar="URL",
    help="Ask the service at this address instead of a database here.",
)


class SecondsToSpend(click.FloatRange):
    """A number of seconds, within bounds; nan is outside all of them."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        seconds: float = super().convert(value, param, ctx)
        if math.isnan(seconds):
            self.fail(f"{value} is no number of seconds", param, ctx)
        return seconds


#: The option of every command that searches; the command passes it to limit_command.
time_limit_option = click.option(
    "--time-limit",
    type=SecondsToSpend(0, 1e6, min_open=True),
    metavar="SECONDS",
    help="End so long after the start with what was found until then; it is reported that more may "
    "exist.",
)


def limit_command(seconds: float | None) -> contextlib.AbstractContextManager[None]:
    """Let the command end after ``seconds``, counted from the start of the process.

    The process leaves the moment in the context; without it, as in a test that calls a command, the
    seconds count from now. None sets no limit.
    """
    return limit_time(seconds, click.get_current_context().find_root().obj)


as_json = click.option("--json", "as_json", is_flag=True, help="Write one JSON document to stdout.")


def is_starter(path: DatabaseChoice) -> bool:
    """Is it the starter database alone that --db names, or leaves?"""
    return path is None or str(path) == STARTER_NAME


@overload
def open_database(path: Path | None, mode: Mode = "read") -> Database: ...
@overload
def open_database(path: DatabaseChoice, mode: Mode = "read") -> Database | DatabaseUnion: ...
def open_database(path: DatabaseChoice, mode: Mode = "read") -> Database | DatabaseUnion:
    """The database named by --db, or the starter, or all that are named."""
    # Imported here because --help and wrong usage need not wait for it.
    import patterndb

    if isinstance(path, tuple):
        shares = [(share.path, share.weight) for share in path]
        return patterndb.open(shares, mode, say=say, progress=UnpackingLine().update)
    if path is not None and not is_starter(path):
        return patterndb.open(path, mode)
    if path is not None and mode != "read":
        raise click.UsageError(
            "the starter database cannot be changed; 'patterndb merge --starter --db my.db' makes "
            "one of your own that holds all of it"
        )
    return patterndb.open(None, mode, say=say, progress=UnpackingLine().update)


@contextlib.contextmanager
def open_source(
    db: DatabaseChoice, server: str | None
) -> Generator[Database | DatabaseUnion | RemoteDatabase]:
    """The database named by --db, or the starter, or what the service of --server answers from."""
    if server is not None and db is not None:
        raise click.UsageError("give --db or --server, not both")
    if server is None:
        with open_database(db) as database:
            yield database
        return
    from patterndb_app.client.remote import connect

    with connect(server) as remote:
        yield remote


class UnpackingLine:
    """Tells how much of the starter database is unpacked, from the first that is until the last."""

    def __init__(self) -> None:
        self._line: ProgressLine | None = None
        self._share = 0.0

    def update(self, done: int, total: int) -> None:
        """Note how much is done, of how much."""
        self._share = done / max(total, 1)
        if self._line is None:
            self._line = ProgressLine(lambda: f"unpacking the starter database: {self._share:.0%}")
        if done >= total:
            self._line.close()


def boundary_of(
    sides: tuple[int, ...], closed: bool, corners: tuple[str, ...] | None = None
) -> Boundary:
    """The boundary that --sides, --closed and --corners ask for."""
    if closed and len(sides) > 1:
        raise click.UsageError("--closed goes with one length: --sides 12 --closed")
    if closed and corners:
        raise click.UsageError("--closed is a side without corners; leave --corners out")
    from query import Boundary

    return Boundary(sides, () if closed else corners)  # pyright: ignore[reportArgumentType]


def read_model(path: Path) -> Surface:
    """The model in a mesh file, its triangles as they stand."""
    from ingest.formats import read_mesh
    from patterndb.errors import InvalidMeshError
    from patterndb.geometry.surface import Surface

    mesh = read_mesh(path)
    try:
        return Surface.from_soup(mesh)
    except InvalidMeshError as error:
        raise InvalidMeshError(f"{path}: {error}") from None


class Parsed(ParamType):
    """A value that a function makes of its text; what is wrong with it, the function raises.

    name: the placeholder in the help. parse: raises ValueError with the message. has_commas: is it
    a list with commas, between which no blanks may be?
    """

    def __init__(
        self, name: str, parse: Callable[[str], object], *, has_commas: bool = False
    ) -> None:
        self.name = name
        self.has_commas = has_commas
        self._parse = parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return self._parse(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


def _parse_numbers(text: str) -> tuple[int, ...]:
    parts = [part.strip() for part in text.split(",")]
    if not all(re.fullmatch(r"[+-]?[0-9]{1,18}", part) for part in parts):
        raise ValueError(f"{text!r} is not a list of whole numbers like 3,5,4,6")
    return tuple(map(int, parts))


#: Whole numbers with commas between: 3,5,4,6.
NUMBERS = Parsed("n,n,...", _parse_numbers, has_commas=True)


def _parse_range(text: str, least: int) -> tuple[int, int]:
    """Parse two whole numbers, 3..5, from ``least`` on; one number means from it to itself."""
    match = re.fullmatch(r"([0-9]{1,9})(?:\.\.([0-9]{1,9}))?", text.strip())
    if not match:
        raise ValueError(f"{text!r} is not a range like 3..5")
    low, high = int(match[1]), int(match[2] or match[1])
    if low > high:
        raise ValueError(f"the range {text} runs backwards; write {high}..{low}")
    if low < least:
        raise ValueError(f"{low} is too few; the least is {least}")
    return low, high


def output_option(type: ParamType, help: str, *, required: bool = False) -> Callable[[F], F]:
    """Give a verb -o, the file that its answer is written into."""
    return click.option("-o", "--output", type=type, required=required, metavar="FILE", help=help)


def picture_option(help: str) -> Callable[[F], F]:
    """Give a verb --picture, a PNG to draw into."""
    return click.option(
        "--picture",
        type=picture_path(".png"),
        callback=_require_pictures,
        metavar="FILE",
        help=help,
    )


def _require_pictures(
    ctx: click.Context, param: click.Parameter, value: Path | None
) -> Path | None:
    """Refuse --picture, as its callback, where nothing in space can be drawn, before any work is
    done."""
    if value is not None:
        require_extra("viewer", param.opts[0], ("vtkmodules", "pyvista", "matplotlib"))
    return value


def view_option(help: str) -> Callable[[F], F]:
    """Give a verb --view, which opens a window."""
    return click.option("--view", is_flag=True, callback=_require_viewer, help=help)


def rank_option(help: str) -> Callable[[F], F]:
    """Give a verb --rank, the place of a fill in a list, from 1."""
    return click.option(
        "--rank", type=Count(1), default=1, show_default=True, metavar="K", help=help
    )


def keys_option(help: str) -> Callable[[F], F]:
    """Give a verb --keys, which are pressed in its window first."""
    return click.option("--keys", default="", help=help)


def parse_vector(text: str) -> tuple[float, float, float] | None:
    """Parse the numbers of 1,0,0.5; None if the text is not three finite ones."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        return None
    return (x, y, z) if all(map(math.isfinite, (x, y, z))) else None


def picture_path(*suffixes: str) -> ParamType:
    """A file to draw into, with one of the suffixes."""
    return FileToWrite(*suffixes, what="picture", doing="draw")


def _require_viewer(ctx: click.Context, param: click.Parameter, value: bool) -> bool:
    """Refuse --view, as its callback, where no window can be opened, before any work is done."""
    if value:
        require_extra("viewer", f"{param.opts[0]}, a window,")
        # Imported here because no verb without a window needs it.
        from viewer.shell.probe import check_display

        check_display()
    return value


def request_options(kind: type[Request], *names: str) -> Callable[[F], F]:
    """Give a verb the options of a request on the command line.

    names: the options; those that belong to a section of the help if none is given. Values come
    to the verb by the names of the fields; :func:`read_options` takes them.
    """
    every = list_options(kind)
    chosen = names or [name for name, one in every.items() if one.text.section]

    def add_options(verb: F) -> F:
        for name in reversed(chosen):
            verb = _make_option(every[name])(verb)
        return verb

    return add_options


def _make_option(one: Option) -> Callable[[F], F]:
    """Make the option of the command line that an option of a request is."""
    extra: dict[str, Any] = {}
    help = one.text.help
    if one.text.constant is not None:
        extra = {"is_flag": True, "flag_value": one.text.constant, "type": click.UNPROCESSED}
    elif isinstance(one.type, BoolType):
        extra = {"is_flag": True, "default": one.default}
    elif isinstance(one.type, VarTupleType):
        extra = {"multiple": True}
    else:
        extra = {"type": _find_type(one)}
        if one.text.default:
            help += f"  [default: {one.text.default}]"
        elif one.default is not None and not isinstance(one.default, tuple):
            extra |= {"default": one.default, "show_default": True}
    return click.option(one.flag, one.name, help=help, metavar=one.text.metavar or None, **extra)


def _find_type(one: Option) -> ParamType | None:
    """Find what reads the value of an option of a request."""
    kind = one.type
    if one.choices:
        if isinstance(kind, IntType | FloatType):
            return ChoiceOrNumber(one.choices, _find_range(kind), one.text.hint)
        return click.Choice(one.choices)
    if isinstance(kind, IntType | FloatType):
        return _find_range(kind)
    if isinstance(kind, TupleType):
        least = getattr(strip_type(kind.item_types[0]), "ge", 0)
        return Parsed("a..b", lambda text: _parse_range(text, least))
    return None


def _find_range(kind: IntType | FloatType) -> ParamType:
    if isinstance(kind, IntType):
        return Count(kind.ge or 0, MOST_COUNT if kind.le is None else kind.le)
    most = None if kind.le == sys.float_info.max else kind.le
    return click.FloatRange(kind.ge if kind.gt is None else kind.gt, most, kind.gt is not None)


class ChoiceOrNumber(ParamType):
    """One of some words, or a number in a range; hint: the end of the message about another."""

    name = "word|number"

    def __init__(self, words: tuple[str, ...], number: ParamType, hint: str) -> None:
        self._words, self._number, self._hint = words, number, hint

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value in self._words:
            return value
        try:
            return self._number.convert(value, param, ctx)
        except click.UsageError:
            self.fail(f"{value!r}: {self._hint}", param, ctx)


def is_given(*names: str) -> bool:
    """Are any of these options of the verb that runs given, be it with their defaults?"""
    context = click.get_current_context()
    return any(context.get_parameter_source(name) != ParameterSource.DEFAULT for name in names)


def read_options(kind: type[Request], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a request that were given on the command line.

    given: the values that the verb has, also those of other options.
    """
    return {
        name: given[name]
        for name in list_options(kind)
        if name in given and given[name] is not None and given[name] != ()
    }


def list_flags(kind: type[Request], section: str) -> tuple[str, ...]:
    """List the options of a request in a section of the help, as they are written there."""
    every = list_options(kind).values()
    return tuple(one.flag.split("/")[0] for one in every if one.text.section == section)
