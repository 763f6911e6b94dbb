"""Running the service: sockets, processes, logs, and its end."""

from __future__ import annotations

import asyncio
import logging
import sys
from functools import partial
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.supervisors import Multiprocess

from patterndb_app.service.application import make_application
from patterndb_app.service.context import ServiceSettings
from patterndb_app.service.metrics import LOG

#: Bytes of a request's headers.
HEADER_BYTES = 16_384

#: Connections that wait to be taken.
BACKLOG = 2_048

#: Seconds that an idle connection is kept.
IDLE_SECONDS = 15

#: Seconds after which a stop waits for nobody any more: streams end at once with their last line,
#: which a client must still take.
STOP_SECONDS = 10


def serve(settings: ServiceSettings, host: str, port: int, workers: int = 1) -> None:
    """Serve until the process is told to stop (SIGINT, SIGTERM).

    workers: processes that share the port; each opens the databases for itself. Raises OSError
    where the port cannot be had, DatabaseError where a database cannot be opened.
    """
    config = uvicorn.Config(
        partial(make_logged_application, settings),
        factory=True,
        host=host,
        port=port,
        workers=workers,
        http=make_protocol(settings.limits.header_seconds),
        ws="none",
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,
        backlog=BACKLOG,
        limit_concurrency=settings.limits.connections,
        timeout_keep_alive=IDLE_SECONDS,
        timeout_graceful_shutdown=STOP_SECONDS,
        h11_max_incomplete_event_size=HEADER_BYTES,
    )
    server = ServiceServer(config)
    if workers > 1:
        Multiprocess(config, target=server.run, sockets=[config.bind_socket()]).run()
    else:
        server.run()


def make_logged_application(settings: ServiceSettings) -> Any:
    """Make the application in the process that answers, whose log goes to stderr."""
    set_up_log()
    return make_application(settings)


def set_up_log() -> None:
    """Have the lines of log go to stderr as they are, and uvicorn's own where they are troubles."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("%(message)s"))
    LOG.setLevel(logging.INFO)
    LOG.handlers[:] = [handler]
    LOG.propagate = False
    # What it tells of requests stands in our own line of log.
    logging.getLogger("uvicorn").setLevel(logging.CRITICAL)


class ServiceServer(uvicorn.Server):
    """The server; told to stop, it ends what is at work before it waits for it."""

    async def shutdown(self, sockets: Any = None) -> None:
        """As uvicorn's."""
        application: Any = self.config.loaded_app
        while not hasattr(application, "state") and hasattr(application, "app"):
            application = application.app
        application.state.service.workers.stop()
        await super().shutdown(sockets)


def make_protocol(header_seconds: float) -> type[H11Protocol]:
    """Make uvicorn's protocol with a limit that it lacks: on the seconds until a request's headers
    are whole, from the connection's first moment on."""

    class TimedProtocol(H11Protocol):
        """uvicorn's protocol that closes a connection whose headers do not come."""

        _late: asyncio.TimerHandle | None = None

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            self._begin()

        def data_received(self, data: bytes) -> None:
            idle = self.cycle is None or self.cycle.response_complete
            if idle and self._late is None:
                self._begin()
            super().data_received(data)
            if self.cycle is not None and not self.cycle.response_complete:
                self._end()

        def connection_lost(self, exc: Exception | None) -> None:
            self._end()
            super().connection_lost(exc)

        def _begin(self) -> None:
            self._late = self.loop.call_later(header_seconds, self._close_late)

        def _end(self) -> None:
            if self._late is not None:
                self._late.cancel()
                self._late = None

        def _close_late(self) -> None:
            self._late = None
            if (
                self.cycle is None or self.cycle.response_complete
            ) and not self.transport.is_closing():
                self.transport.close()

    return TimedProtocol
