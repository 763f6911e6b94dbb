"""The verbs that draw: show, gallery, browse."""

from __future__ import annotations

import contextlib
import glob
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from patterndb.errors import NotFoundError, TimeLimitError
from patterndb.system.deadline import run_until_late
from patterndb_app.cli.failure import EXIT_NOTHING
from patterndb_app.cli.options import (
    NUMBERS,
    Count,
    boundary_of,
    closed_option,
    db_to_read,
    keys_option,
    limit_command,
    list_flags,
    may_overwrite,
    open_database,
    output_option,
    picture_path,
    rank_option,
    read_options,
    request_options,
    time_limit_option,
)
from patterndb_app.cli.program import SectionedCommand
from patterndb_app.cli.progressline import hushed
from patterndb_app.cli.search import (
    AskedFills,
    FillListing,
    ListedFill,
    find_ranked,
    format_variants,
)
from patterndb_app.cli.text import plural, say, tell_left_over
from query.request import FillRequest, PatternRequest, choose_patterns

if TYPE_CHECKING:
    from patterndb.core.disk import Disk
    from patterndb.core.pattern import Pattern
    from patterndb.store import Database
    from query import Boundary, Stroke
    from viewer.card import Card
    from viewer.gallery import GallerySheet

PICTURE = picture_path(".png", ".svg")

flat_option = click.option(
    "--flat",
    is_flag=True,
    help="With --sides: every fill in its place, not one of each pattern.",
)


@click.command()
@click.argument("pattern", required=False)
@click.option("--sides", type=NUMBERS, help="Draw a fill of this boundary instead.")
@closed_option
@rank_option("With --sides: the K-th fill, each of another pattern unless --flat is given.")
@flat_option
@click.option("--widths", type=NUMBERS, help="Widths of the pattern's polychords.")
@db_to_read
@output_option(PICTURE, "The picture, PNG or SVG.", required=True)
@click.option("--plain", is_flag=True, help="Do not tint the polychords.")
@time_limit_option
@may_overwrite
def show(
    pattern: str | None,
    sides: tuple[int, ...] | None,
    closed: bool,
    rank: int,
    flat: bool,
    widths: tuple[int, ...] | None,
    db: Path | None,
    output: Path,
    plain: bool,
    time_limit: float | None,
) -> int:
    """Draw one pattern, by the first digits of its name, or one fill of a boundary.

    \b
    patterndb show 05c1f0 -o pattern.png
    patterndb show --sides 3,5,4,6 --rank 2 -o fill.svg
    """
    if (pattern is None) == (sides is None):
        raise click.UsageError("give either a pattern's name or --sides")
    if widths is not None and pattern is None:
        raise click.UsageError("--widths goes with a pattern's name; a fill has its own")
    # Imported here because drawing libraries take a moment that --help need not wait for.
    from viewer import save_picture
    from viewer.card import Card
    from viewer.fillcard import make_fill_card

    with limit_command(time_limit), open_database(db) as database:
        if pattern is not None:
            found = database.pattern(pattern)
            card = Card.of_pattern(found)
            if widths is not None:
                title = f"{found.name} widened"
                card = Card.of_disk(_widen(found, widths), title)
        else:
            assert sides is not None
            boundary = boundary_of(sides, closed)
            found = AskedFills(FillRequest(limit=rank), not flat).find(database, boundary)
            one = find_ranked(FillListing(database, found), rank, "fill" if flat else "pattern")
            card = make_fill_card(one.fill, boundary, rank=rank)
        save_picture(output, card, tinted=not plain)
    say(f"drawn: {output}")
    return 0


def _name_meshes(database: Database, pattern: Pattern) -> list[str]:
    return [occurrence.mesh for occurrence in database.occurrences(pattern)]


def _widen(pattern: Pattern, widths: Sequence[int]) -> Disk:
    from query.expand import expand_pattern

    return expand_pattern(pattern, widths).disk()


@click.command(
    cls=SectionedCommand,
    sections={
        "What is drawn": (
            "--sides",
            "--closed",
            "--flat",
            *list_flags(PatternRequest, "filter"),
            "--db",
        ),
        "Sheet": ("-o", "--overwrite", "--limit", "--per-page", "--plain", "--time-limit"),
    },
)
@click.option("--sides", type=NUMBERS, help="The fills of this boundary instead.")
@closed_option
@db_to_read
@output_option(PICTURE, "The sheet, PNG or SVG; several pages are numbered.", required=True)
@click.option(
    "--limit",
    type=Count(1),
    default=60,
    show_default=True,
    metavar="N",
    help="Draw at most N.",
)
@flat_option
@request_options(PatternRequest)
@click.option(
    "--per-page",
    type=Count(1, 200),
    default=60,
    show_default=True,
    metavar="N",
    help="Draw at most N on a page.",
)
@click.option("--plain", is_flag=True, help="Do not tint the polychords.")
@time_limit_option
@may_overwrite
def gallery(
    sides: tuple[int, ...] | None,
    closed: bool,
    db: Path | None,
    output: Path,
    limit: int,
    flat: bool,
    per_page: int,
    plain: bool,
    time_limit: float | None,
    **given: Any,
) -> int:
    """Draw a contact sheet: the patterns of a class, or the fills of a boundary.

    \b
    patterndb gallery --class 5 --limit 40 -o five.png
    patterndb gallery --sides 3,5,4,6 --max-irregular 4 -o fills.svg
    """
    request = PatternRequest(**read_options(PatternRequest, given))
    if (request.n_sides is None) == (sides is None):
        raise click.UsageError("give either --class or --sides")
    if request.convex and sides is not None:
        raise click.UsageError("--convex goes with --class; fills of --sides are convex")
    # Imported here because drawing libraries take a moment that --help need not wait for.
    from viewer.card import Card
    from viewer.gallery import GallerySheet

    with limit_command(time_limit), open_database(db) as database:
        if sides is not None:
            boundary = boundary_of(sides, closed)
            options = read_options(FillRequest, {**given, "limit": limit})
            found = AskedFills(FillRequest(**options), not flat).find(database, boundary)
            listing = FillListing(database, found, counts_variants=not flat)
            return _draw_fills(
                listing, FillSheet(output, boundary, per_page=per_page, tinted=not plain)
            )
        ((chosen, passing),) = choose_patterns(database, request)
        rows, n_sides = passing.tolist(), chosen.n_sides
        if not rows:
            raise NotFoundError(f"the database has no such pattern of {plural(n_sides, 'side')}")
        shown = rows[:limit]
        title = f"{plural(len(rows), 'pattern')} of {plural(n_sides, 'side')}"
        if len(shown) < len(rows):
            title = f"the first {len(shown):,} of {title}"
        cards = (Card.of_pattern(chosen.pattern(row), k) for k, row in enumerate(shown, 1))
        of_patterns = GallerySheet(
            output, title=title, per_page=per_page, tinted=not plain, n_cards=len(shown)
        )
        try:
            for card in cards:
                of_patterns.add(card)
        except TimeLimitError:
            pass
        return _end_sheet(of_patterns, output, len(shown))


def _draw_fills(listing: FillListing, sheet: FillSheet) -> int:
    """Draw the fills of a list; return the exit code."""
    late = False
    try:
        for one in listing:
            sheet.add(one)
    except TimeLimitError:
        late = True
    try:
        sheet.close()
    except TimeLimitError:
        late = True
    found = listing.found
    if not listing.count:
        raise NotFoundError(f"no fill: {found.reason}")
    if late or not found.complete:
        say(
            f"{plural(sheet.count, 'fill')} drawn: the time limit was over, so that there may be "
            "more; allow more seconds, or ask for fewer fills (--limit)"
        )
    return 0 if sheet.count else EXIT_NOTHING


def _end_sheet(sheet: GallerySheet, output: Path, wanted: int) -> int:
    """Write the last page of a sheet of patterns and report it; return the exit code."""
    with contextlib.suppress(TimeLimitError):
        sheet.close()
    tell_drawn(output, sheet.paths)
    if sheet.written < wanted:
        say(
            f"{sheet.written:,} of {plural(wanted, 'pattern')} drawn: the time limit was over; "
            "allow more seconds, or ask for fewer (--limit)"
        )
    return 0 if sheet.written else EXIT_NOTHING


def tell_drawn(output: Path, pages: Sequence[Path]) -> None:
    """Name the pages of a sheet, and those that an earlier and longer one left."""
    for path in pages:
        say(f"drawn: {path}")
    tell_left_over(output.parent, f"{glob.escape(output.stem)}-[0-9]*{output.suffix}", pages)


class FillSheet:
    """A contact sheet of a boundary's fills, the strokes that were asked for marked on them.

    count: how many were drawn.
    """

    def __init__(
        self,
        path: Path,
        boundary: Boundary,
        strokes: Sequence[Stroke] = (),
        tolerance: int = 0,
        per_page: int = 60,
        *,
        tinted: bool = True,
    ) -> None:
        # Imported here because drawing libraries take a moment that --help need not wait for.
        from viewer.gallery import GallerySheet

        lengths = ", ".join(str(n) for n in boundary.lengths)
        self.count = 0
        self._path = path
        self._boundary, self._strokes, self._tolerance = boundary, strokes, tolerance
        self._sheet = GallerySheet(
            path, title=f"fills of sides {lengths}", per_page=per_page, tinted=tinted
        )

    def add(self, one: ListedFill) -> None:
        """Draw a fill. Raises TimeLimitError where the time limit passes before."""
        make = partial(
            make_listed_card, one, self._boundary, self._strokes, tolerance=self._tolerance
        )
        self._sheet.add(run_until_late(make, "the picture was drawn"))

    def close(self) -> None:
        """Write the last page, and name all. Raises TimeLimitError where that takes too long."""
        try:
            self._sheet.close()
        finally:
            # A page that was not painted in time shows nothing.
            self.count = self._sheet.written
            tell_drawn(self._path, self._sheet.paths)


def make_listed_card(
    one: ListedFill, boundary: Boundary, strokes: Sequence[Stroke] = (), *, tolerance: int = 0
) -> Card:
    """The card of a fill of a list, the strokes that were asked for marked."""
    from viewer.card import format_valences
    from viewer.fillcard import make_fill_card

    fill = one.fill
    facts = [
        format_valences(fill.pattern.valences),
        plural(len(fill.quads), "quad"),
        f"{fill.pattern.frequency:,}×",
    ]
    if one.variants:
        facts.append(f"{format_variants(one.variants)} variant{'' if one.variants == 1 else 's'}")
    return make_fill_card(
        fill, boundary, strokes, tolerance, rank=one.rank, facts="   ".join(facts)
    )


@click.command()
@click.option(
    "--class",
    "n_sides",
    type=Count(),
    metavar="N",
    help="Begin with the patterns of N sides.",
)
@db_to_read
@output_option(picture_path(".png"), "Write one PNG instead of opening a window.")
@keys_option('Keys pressed first, with spaces: "n n ] Up".')
@may_overwrite
def browse(n_sides: int | None, db: Path | None, output: Path | None, keys: str) -> int:
    """Page through a database's patterns in a window; F1 lists commands and keys.

    \b
    patterndb browse --class 5
    patterndb browse --class 6 --keys "n Right ] Up" -o page.png
    """
    if output is None:
        # Imported here because no verb without a window needs it.
        from viewer.shell.probe import check_display

        check_display()
    # Imported here because drawing libraries take a moment that --help need not wait for.
    from viewer import browse as open_browser
    from viewer.browser_commands import KEYS

    with contextlib.ExitStack() as stack:
        database = stack.enter_context(open_database(db))
        try:
            KEYS.check(keys)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--keys") from error
        if output is None:
            stack.enter_context(hushed())

        def open_another(path: Path) -> tuple[Database, Callable[[Pattern], list[str]]]:
            other = stack.enter_context(open_database(path))
            return other, partial(_name_meshes, other)

        open_browser(
            database,
            n_sides=n_sides,
            expand=_widen,
            meshes=partial(_name_meshes, database),
            open_file=open_another,
            off_screen=output,
            keys=keys,
        )
    if output is not None:
        say(f"drawn: {output}")
    return 0
