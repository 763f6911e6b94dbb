"""The verb that answers over HTTP: serve."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import click

from patterndb.system.extras import require_extra
from patterndb_app.cli.options import Count, FileName
from patterndb_app.cli.text import say

#: Addresses that only this machine reaches.
LOOPBACK = ("127.0.0.1", "localhost", "::1")

#: Characters that a token has at least: shorter ones can be guessed.
SHORTEST_TOKEN = 16


@click.command()
@click.option(
    "--db",
    "dbs",
    type=FileName(),
    multiple=True,
    metavar="FILE",
    help="A database to ask, the first by default; may be given again. The starter database if not "
    "given.",
)
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    metavar="ADDRESS",
    help="The address to listen at; others than this machine's need --allow-host.",
)
@click.option("--port", type=Count(0, 65535), default=8017, show_default=True, help="0: any free.")
@click.option(
    "--allow-host",
    "hosts",
    multiple=True,
    metavar="NAME",
    help="A name by which clients reach the service; may be given again.",
)
@click.option(
    "--write-token-file",
    "token_file",
    type=FileName(),
    metavar="FILE",
    help="A file with the token that whoever changes a database must show; without it nothing can "
    "be changed.",
)
@click.option(
    "--workers",
    type=Count(1, 64),
    default=1,
    show_default=True,
    metavar="N",
    help="Processes that share the port.",
)
def serve(
    dbs: tuple[Path, ...],
    host: str,
    port: int,
    hosts: tuple[str, ...],
    token_file: Path | None,
    workers: int,
) -> int:
    """Answer questions over HTTP, and serve the page to draw on.

    Open the address that it prints. Programs ask by the interface that docs/service.md describes,
    Python by patterndb.connect, this program by query --server and fill --server. The databases
    are only read, unless there is a token. Stop it with Ctrl-C: what is being streamed ends with
    its last line.

    \b
    patterndb serve
    patterndb serve --db my.db --port 8020
    patterndb serve --db my.db --write-token-file token.txt
    patterndb serve --host 0.0.0.0 --allow-host patterns.example.org --workers 4
    """
    require_extra("service", "the service")
    if host not in LOOPBACK and not hosts:
        raise click.UsageError(
            f"--host {host} lets other machines ask, who see and take all that the databases hold; "
            "say by which names they reach it, --allow-host NAME, and put a server with TLS before "
            "it (docs/service.md)"
        )
    token = None if token_file is None else read_token(token_file)
    if token is not None and not dbs:
        raise click.UsageError(
            "--write-token-file needs --db: the starter database is never changed"
        )
    if token is not None and workers > 1:
        raise click.UsageError(
            "--write-token-file goes with one process: meshes are learned by one, one after another"
        )
    from patterndb_app.service.context import ServiceSettings
    from patterndb_app.service.serving import serve as run

    for db in dbs:
        if not db.exists():
            raise click.BadParameter(f"there is no database at {db}", param_hint="'--db'")
    settings = ServiceSettings(databases=dbs or (None,), hosts=hosts, token=token)
    with contextlib.suppress(KeyboardInterrupt):
        run(settings, host, port, workers)
    say("stopped")
    return 0


def read_token(path: Path) -> str:
    """Read the token in a file; click.BadParameter where it is none."""
    try:
        token = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise click.BadParameter(
            f"{path} cannot be read: {error}", param_hint="'--write-token-file'"
        ) from None
    if not re.fullmatch(rf"[!-~]{{{SHORTEST_TOKEN},}}", token):
        raise click.BadParameter(
            f"{path} holds no token: one line of {SHORTEST_TOKEN} or more letters and digits, such "
            "as 'openssl rand -hex 32' writes",
            param_hint="'--write-token-file'",
        )
    return token
