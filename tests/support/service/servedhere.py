"""A service that answers on a port of this machine, in a thread of the tests' process."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Iterator

import httpx

from patterndb_app.service.context import Service, ServiceSettings
from patterndb_app.service.serving import listen, make_server

#: Seconds that a test waits for what should come at once: no measure, but an end.
PATIENCE = 30.0

TOKEN = "a-token-of-the-tests-0123456789"


class ServedHere:
    """A running service: its address, a client, and its parts."""

    def __init__(self, settings: ServiceSettings) -> None:
        self.server = make_server(settings)
        self.listener = listen("127.0.0.1", 0)
        self.port: int = self.listener.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self.http = httpx.Client(base_url=self.url, timeout=PATIENCE, trust_env=False)
        self._thread = threading.Thread(target=self.server.run, args=([self.listener],))
        self._thread.start()
        wait_until(lambda: self.server.started)

    @property
    def service(self) -> Service:
        return self.server.config.app.state.service  # pyright: ignore

    def connect(self) -> socket.socket:
        """A connection of its own, to be misused."""
        return socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE)

    def stop(self) -> None:
        self.http.close()
        self.server.should_exit = True
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
        self.listener.close()


def wait_until(reached: object) -> None:
    """Wait for a condition that shall come true."""
    assert callable(reached)
    until = time.monotonic() + PATIENCE
    while not reached():
        assert time.monotonic() < until, "it did not come true"
        time.sleep(0.005)


@contextlib.contextmanager
def served(settings: ServiceSettings) -> Iterator[ServedHere]:
    """A service for the time of a block."""
    running = ServedHere(settings)
    try:
        yield running
    finally:
        running.stop()
