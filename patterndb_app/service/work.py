"""Work for requests: a place among those at work, a thread, and a way to end it early.

What a request asks for runs in a thread and hands over chunks of its answer; the event loop sends
them. There are as many threads as places. Who finds none free waits a moment, and is refused where
too many wait already: nothing is ever queued without end.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from patterndb_app.service.limits import Limits
from patterndb_app.service.refusals import BusyError, StoppingError
from patterndb_app.service.turns import Turns

#: Bytes of an answer that wait to be sent before the thread that makes them waits, too.
AHEAD = 4 * 2**20

#: Seconds for which lines after the first gather, to be sent together.
TOGETHER_SECONDS = 0.005

#: Requests that go on at a time once they have their first line. A second one would only hold up
#: the first lines of others and the event loop: of what they do, Python runs one at a time.
GOING_ON = 1

#: Why work is ended early.
GONE = "cancelled"
LATE = "time limit"
STOPPING = "stopping"


class WorkEndedError(Exception):
    """Raised in the thread: nobody wants what it makes any more."""


class RequestWork:
    """What one request makes in a thread, and the chunks of it that wait to be sent.

    stopped: why it was ended early, if it was.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, turns: Turns) -> None:
        self.stopped: str | None = None
        self._loop = loop
        self._turns = turns
        self._room = threading.Condition()
        self._chunks: deque[bytes] = deque()
        self._bytes = 0
        self._done = False
        self._failure: BaseException | None = None
        self._news = asyncio.Event()
        self._told = False
        self._handed = False
        self._to_end: list[Callable[[], None]] = []

    # In the thread.

    def put(self, chunk: bytes) -> None:
        """Hand a chunk over; waits where the client is slow. WorkEndedError where it has gone."""
        with self._room:
            self._room.wait_for(lambda: self._bytes < AHEAD or self.stopped is not None)
            if self.stopped == GONE:
                raise WorkEndedError
            self._chunks.append(chunk)
            self._bytes += len(chunk)
        self._tell()
        self._turns.pause()

    def on_end(self, end: Callable[[], None]) -> None:
        """Have a function called when the work is ended early, at once if it was already."""
        with self._room:
            self._to_end.append(end)
            ended = self.stopped is not None
        if ended:
            end()

    def run(self, make: Callable[[RequestWork], None]) -> None:
        """Do the work."""
        failure: BaseException | None = None
        self._turns.begin()
        try:
            if self.stopped is None:
                make(self)
        except WorkEndedError:
            pass
        except BaseException as error:
            failure = error
        finally:
            self._turns.end()
        with self._room:
            self._failure = failure
            self._done = True
        self._tell()

    def _tell(self) -> None:
        with self._room:
            if self._told:
                return
            self._told = True
        # The loop is closed where the process ends in the middle of it.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._news.set)

    # In the event loop.

    def end(self, why: str) -> None:
        """End it as soon as may be; the first reason counts, but for a client that has gone."""
        with self._room:
            if self._done:
                return
            if self.stopped is None or why == GONE:
                self.stopped = why
            ends = list(self._to_end)
            self._room.notify_all()
        for end in ends:
            end()
        self._news.set()

    async def next_chunk(self) -> bytes | None:
        """Wait for what is to be sent next, all that is there; None at the end.

        Raises what the work failed by, after what was made before.
        """
        if self._handed and not self._done:
            # A line now and twenty a little later are sent in a fraction of the time that each by
            # itself takes.
            await asyncio.sleep(TOGETHER_SECONDS)
        while True:
            with self._room:
                chunk = b"".join(self._chunks)
                self._chunks.clear()
                self._bytes = 0
                self._room.notify_all()
                done, failure = self._done, self._failure
                self._news.clear()
                self._told = False
            if chunk:
                self._handed = True
                return chunk
            if self.stopped == GONE:
                return None
            if done:
                if failure is not None:
                    raise failure
                return None
            await self._news.wait()


class Workers:
    """The places for requests at work, with a thread each."""

    def __init__(self, limits: Limits, ended: Callable[[str], None]) -> None:
        """ended: is told why work was ended early, of all that was."""
        self._limits = limits
        self._ended = ended
        self._threads = ThreadPoolExecutor(limits.at_work, thread_name_prefix="work")
        self._places = asyncio.Semaphore(limits.at_work)
        self._turns = Turns(GOING_ON)
        self._of_client: Counter[str] = Counter()
        self._works: set[RequestWork] = set()
        self.waiting = 0
        self.stopping = False

    @property
    def at_work(self) -> int:
        """How many requests are at work."""
        return len(self._works)

    async def begin(self, client: str, make: Callable[[RequestWork], None]) -> RequestWork:
        """Wait for a place, and start work there; the place is free again when its thread ends.

        client: its address. Raises BusyError where too many wait, or one address has its share,
        StoppingError where the service ends.
        """
        limits = self._limits
        if self.stopping:
            raise StoppingError("the service is being stopped", headers=RETRY_LATER)
        if self._of_client[client] >= limits.per_client:
            raise BusyError(
                f"{limits.per_client} requests of this address are at work or waiting; "
                "wait for one of them to end",
                headers=RETRY_SOON,
            )
        if self._places.locked() and self.waiting >= limits.waiting:
            raise BusyError(
                f"{limits.at_work} requests are at work and {limits.waiting} waiting; "
                "try again in a moment",
                headers=RETRY_SOON,
            )
        self._of_client[client] += 1
        self.waiting += 1
        try:
            async with asyncio.timeout(limits.waiting_seconds):
                await self._places.acquire()
        except BaseException as error:
            self._forget(client)
            if not isinstance(error, TimeoutError):
                raise
            raise BusyError(
                f"{limits.at_work} requests are at work, and none ended within "
                f"{limits.waiting_seconds:g} s; try again in a moment",
                headers=RETRY_SOON,
            ) from None
        finally:
            self.waiting -= 1
        loop = asyncio.get_running_loop()
        work = RequestWork(loop, self._turns)
        if self.stopping:
            work.end(STOPPING)
        self._works.add(work)
        late = loop.call_later(limits.seconds + GRACE, work.end, LATE)

        def free(_: object) -> None:
            late.cancel()
            self._works.discard(work)
            if work.stopped is not None:
                self._ended(work.stopped)
            self._places.release()
            self._forget(client)

        loop.run_in_executor(self._threads, work.run, make).add_done_callback(free)
        return work

    def _forget(self, client: str) -> None:
        self._of_client[client] -= 1
        if not self._of_client[client]:
            del self._of_client[client]

    def stop(self) -> None:
        """Take no more requests, and end those at work: each ends with its last line."""
        self.stopping = True
        for work in list(self._works):
            work.end(STOPPING)

    def close(self) -> None:
        """Wait for the threads to end."""
        self._threads.shutdown(cancel_futures=True)


#: Seconds after the limit of a search, which it keeps itself, when it is ended from outside.
GRACE = 1.0

RETRY_SOON = {"Retry-After": "1"}
RETRY_LATER = {"Retry-After": "10"}
