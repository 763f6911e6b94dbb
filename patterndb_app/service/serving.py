"""Running the service: sockets, processes, logs, and its end."""

from __future__ import annotations

import asyncio
import logging
import multiprocessing
import signal
import socket
import sys
import time
from multiprocessing.connection import wait
from multiprocessing.context import SpawnProcess
from typing import Any, cast

import uvicorn
from fastapi import FastAPI
from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle

from patterndb_app.service.application import make_application
from patterndb_app.service.context import ServiceSettings
from patterndb_app.service.guard import HEADER_BYTES
from patterndb_app.service.metrics import LOG

#: Connections that wait to be taken.
BACKLOG = 2_048

#: Seconds that an idle connection is kept.
IDLE_SECONDS = 15

#: Seconds after which a stop waits for nobody any more: streams end at once with their last line,
#: which a client must still take.
STOP_SECONDS = 10

#: Seconds for which Python runs one thread while others wait, of its own 0.005: as long would the
#: event loop, or a question without its first line yet, wait for each thread that searches.
SWITCH_SECONDS = 0.0005

#: A process that ends so soon after the start will not do better the next time.
QUICK_END_SECONDS = 5.0


def serve(settings: ServiceSettings, host: str, port: int, workers: int = 1) -> None:
    """Serve until the process is told to stop (SIGINT, SIGTERM).

    workers: processes that share the port; each opens the databases for itself, and where one dies
    another is started. Raises OSError where the port cannot be had, DatabaseError where a database
    cannot be opened.
    """
    with listen(host, port) as listener:
        shown = f"[{host}]" if ":" in host else host
        say = f"patterndb serves at http://{shown}:{listener.getsockname()[1]}/ (Ctrl-C stops it)"
        print(say, file=sys.stderr, flush=True)
        if workers == 1:
            answer(settings, listener)
        else:
            supervise(settings, listener, workers)


def listen(host: str, port: int) -> socket.socket:
    """Make the socket that the service's connections come to.

    Raises OSError where the port cannot be had.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.create_server((host, port), family=family, backlog=BACKLOG)
    # asyncio would do so for a socket that names its protocol, which this one does not: a line of
    # an answer then waits for the client's word that the last one came, 40 ms.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener


def answer(settings: ServiceSettings, listener: socket.socket) -> None:
    """Answer what comes to a socket, in this process."""
    set_up_log()
    sys.setswitchinterval(SWITCH_SECONDS)
    make_server(settings).run([listener])


def make_server(settings: ServiceSettings) -> ServiceServer:
    """Make the server of a service, with its limits; ``run([socket])`` answers what comes there."""
    limits = settings.limits
    config = uvicorn.Config(
        make_application(settings),
        http=make_protocol(limits.header_seconds),
        ws="none",
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,
        limit_concurrency=limits.connections,
        timeout_keep_alive=IDLE_SECONDS,
        timeout_graceful_shutdown=STOP_SECONDS,
        h11_max_incomplete_event_size=HEADER_BYTES,
    )
    return ServiceServer(config)


def supervise(settings: ServiceSettings, listener: socket.socket, workers: int) -> None:
    """Have processes answer what comes to a socket, until this one is told to stop."""
    context = multiprocessing.get_context("spawn")

    def start() -> SpawnProcess:
        process = context.Process(target=answer, args=(settings, listener))
        process.start()
        return process

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, stop)
    processes = [start() for _ in range(workers)]
    began = time.monotonic()
    try:
        while True:
            wait([process.sentinel for process in processes])
            if time.monotonic() - began < QUICK_END_SECONDS:
                raise RuntimeError("a process ended as soon as it was started; the log says why")
            processes = [one if one.is_alive() else start() for one in processes]
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.join(STOP_SECONDS)
            if process.is_alive():
                process.kill()


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
        application = cast("FastAPI", self.config.app)
        application.state.service.workers.stop()
        await super().shutdown(sockets)


def make_protocol(header_seconds: float) -> type[H11Protocol]:
    """Make uvicorn's protocol with a limit that it lacks: on the seconds until a request's headers
    are whole, from the connection's first moment on."""

    class TimedProtocol(H11Protocol):
        """uvicorn's protocol that closes a connection whose headers do not come."""

        _late: asyncio.TimerHandle | None = None
        _begun: RequestResponseCycle | None = None

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            self._wait_for_headers()

        def data_received(self, data: bytes) -> None:
            if self._late is None and self._is_idle():
                self._wait_for_headers()
            super().data_received(data)
            self._begun = self.cycle
            if not self._is_idle():
                self._stop_waiting()

        def connection_lost(self, exc: Exception | None) -> None:
            self._stop_waiting()
            super().connection_lost(exc)

        def _is_idle(self) -> bool:
            return self._begun is None or self._begun.response_complete

        def _wait_for_headers(self) -> None:
            self._late = self.loop.call_later(header_seconds, self._close_late)

        def _stop_waiting(self) -> None:
            if self._late is not None:
                self._late.cancel()
                self._late = None

        def _close_late(self) -> None:
            self._late = None
            if self._is_idle() and not self.transport.is_closing():
                self.transport.close()

    return TimedProtocol
