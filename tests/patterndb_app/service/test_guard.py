"""What the service refuses before it looks at it, and that it stays as it was."""

from __future__ import annotations

import json
import socket
import threading
from pathlib import Path

import httpx
import pytest

from patterndb_app.service.answers import takes_gzip
from patterndb_app.service.context import ServiceSettings
from patterndb_app.service.questions import refuse_depth
from patterndb_app.service.refusals import LargeRequestError
from patterndb_app.service.serving import listen
from tests.support.service.servedhere import PATIENCE, ServedHere, served, wait_until

QUESTION = json.dumps({"sides": [3, 5, 4, 6], "limit": 1}).encode()
LONG = {"sides": [40, 40, 40, 40, 40, 40], "limit": 1000}


def talk(running: ServedHere, *parts: bytes) -> bytes:
    """Send parts over a connection of its own, and read until the service closes it."""
    with running.connect() as connection:
        for part in parts:
            connection.sendall(part)
        return read_all(connection)


def read_all(connection: socket.socket) -> bytes:
    data = b""
    while True:
        try:
            part = connection.recv(65536)
        except ConnectionResetError:
            return data
        if not part:
            return data
        data += part


def test_other_hosts_are_refused(starter: ServedHere) -> None:
    for host in ("evil.example", "127.0.0.1.evil.example", "", "[::2]", "localhost.evil:8017"):
        refused = starter.http.get("/v1/health", headers={"Host": host})
        assert refused.status_code == 421 and refused.json()["ok"] is False
    for host in ("localhost", "LOCALHOST:8017", "[::1]:8017", "127.0.0.1"):
        assert starter.http.get("/v1/health", headers={"Host": host}).status_code == 200


def test_pages_of_other_sites_may_not_ask(starter: ServedHere) -> None:
    for origin in ("http://evil.example", "null", "http://127.0.0.1:1", "http://[x"):
        refused = starter.http.post("/v1/fills", content=QUESTION, headers={"Origin": origin})
        assert refused.status_code == 403
    own = starter.http.post("/v1/fills", content=QUESTION, headers={"Origin": starter.url})
    assert own.status_code == 200


def test_every_answer_has_an_id_and_a_policy(starter: ServedHere) -> None:
    answer = starter.http.get("/v1/nothing", headers={"X-Request-ID": "mine-1"})
    assert answer.headers["x-request-id"] == "mine-1" and answer.status_code == 404
    assert "default-src 'none'" in answer.headers["content-security-policy"]
    wrong = starter.http.get("/v1/health", headers={"X-Request-ID": "a\tb"})
    assert wrong.headers["x-request-id"] != "a\tb"
    assert starter.http.put("/v1/health").json()["status"] == 405
    parameters = starter.http.get("/v1/patterns?sides=-1&limit=x")
    assert parameters.status_code == 400 and len(parameters.json()["errors"]) == 2


def test_answers_are_compressed_for_who_takes_it(starter: ServedHere) -> None:
    plain = starter.http.get("/v1/limits", headers={"Accept-Encoding": "identity"})
    assert "content-encoding" not in plain.headers
    packed = starter.http.get("/v1/limits", headers={"Accept-Encoding": "gzip"})
    assert packed.headers["content-encoding"] == "gzip" and packed.json() == plain.json()
    assert takes_gzip("br, gzip;q=0.5") and not takes_gzip("gzip;q=0.0") and not takes_gzip("br")


def test_lines_do_not_wait_for_the_last_to_be_acknowledged() -> None:
    with listen("127.0.0.1", 0) as listener, socket.create_connection(listener.getsockname()):
        taken, _ = listener.accept()
        with taken:
            assert taken.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_body_that_is_too_long_is_not_read(strict: ServedHere) -> None:
    said = strict.http.post("/v1/fills", content=b" " * 30_000)
    assert said.status_code == 413 and said.headers["connection"] == "close"
    head = b"POST /v1/fills HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
    chunk = b"2710\r\n" + b" " * 10_000 + b"\r\n"
    answer = talk(strict, head, chunk, chunk, chunk)
    assert answer.startswith(b"HTTP/1.1 413")
    told = b"POST /v1/fills HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000000\r\n\r\n"
    assert talk(strict, told).startswith(b"HTTP/1.1 413")


def test_slow_clients_are_refused(strict: ServedHere) -> None:
    begun = b"POST /v1/fills HTTP/1.1\r\nHost: localhost\r\nContent-Length: 50\r\n\r\n{"
    assert talk(strict, begun).startswith(b"HTTP/1.1 408")
    # Headers that never end: the connection is closed.
    assert talk(strict, b"POST /v1/fills HTTP/1.1\r\nHost: loc") == b""
    assert talk(strict) == b""
    assert strict.http.get("/v1/health").status_code == 200


def test_headers_that_are_too_long_are_refused(strict: ServedHere) -> None:
    head = b"GET /v1/health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nX: "
    assert talk(strict, head + b"x" * 100_000 + b"\r\n\r\n").startswith(b"HTTP/1.1 431")


def test_more_at_work_than_may_be_is_refused_and_told_when(occupied: ServedHere) -> None:
    with occupied.http.stream(
        "POST", "/v1/fills", json=LONG, headers={"Accept": "application/x-ndjson"}
    ) as stream:
        lines = stream.iter_lines()  # Held, for an iterator that is dropped closes the stream.
        next(lines)
        answers: list[httpx.Response] = []

        def ask() -> None:
            url = f"{occupied.url}/v1/fills"
            answers.append(httpx.post(url, content=QUESTION, trust_env=False, timeout=PATIENCE))

        threads = [threading.Thread(target=ask) for _ in range(6)]
        for thread in threads:
            thread.start()
        assert occupied.http.get("/v1/health").json()["ok"]
        for thread in threads:
            thread.join()
    assert [answer.status_code for answer in answers] == [429] * 6
    assert all(int(answer.headers["retry-after"]) >= 1 for answer in answers)
    workers = occupied.service.workers
    wait_until(lambda: workers.at_work == 0 and not workers.waiting)
    assert occupied.http.post("/v1/fills", content=QUESTION).status_code == 200


def test_an_answer_that_grows_too_large_is_cut_and_says_so(strict: ServedHere) -> None:
    answer = strict.http.post("/v1/fills", json={**LONG, "limit": 500}).json()
    assert answer["stopped"] == "answer size" and answer["truncated"] and answer["fills"]


@pytest.mark.parametrize("close", ["reset", "half"])
def test_clients_that_vanish_leave_nothing_at_work(strict: ServedHere, close: str) -> None:
    body = json.dumps(LONG).encode()
    head = b"POST /v1/fills HTTP/1.1\r\nHost: localhost\r\nAccept: application/x-ndjson\r\n"
    connection = strict.connect()
    connection.sendall(head + b"Content-Length: %d\r\n\r\n" % len(body) + body)
    connection.recv(1000)
    if close == "half":
        connection.shutdown(socket.SHUT_WR)
        read_all(connection)
    connection.close()
    wait_until(lambda: strict.service.workers.at_work == 0)


def test_a_stop_ends_streams_with_their_last_line(learned: Path) -> None:
    with served(ServiceSettings(databases=(learned,), warm=False)) as running:
        with running.http.stream(
            "POST", "/v1/fills", json=LONG, headers={"Accept": "application/x-ndjson"}
        ) as stream:
            lines = stream.iter_lines()
            next(lines)
            running.server.should_exit = True
            last = json.loads(list(lines)[-1])
        assert last["done"] and last["stopped"] == "stopping" and last["truncated"]


def test_depth_is_counted_without_what_stands_in_texts() -> None:
    refuse_depth(b'{"a": "[[[[[[[[", "b": ["\\"[[[["]}', 2)
    with pytest.raises(LargeRequestError, match="3 levels"):
        refuse_depth(b'{"a": [[1]]}', 2)


def test_the_page_says_how_to_build_it_and_gives_nothing_else(
    learned: Path, tmp_path: Path
) -> None:
    page = tmp_path / "bundle"
    (page / "examples").mkdir(parents=True)
    (tmp_path / "secret.txt").write_text("secret")
    (page / "page.js").write_text("let a;")
    (page / "link.txt").symlink_to(tmp_path / "secret.txt")
    with served(ServiceSettings(databases=(learned,), page=page, warm=False)) as running:
        front = running.http.get("/")
        assert (
            "make page" in front.text
            and "script-src 'self'" in (front.headers["content-security-policy"])
        )
        script = running.http.get("/page/page.js")
        assert script.headers["content-type"].startswith("text/javascript")
        for name in ("../secret.txt", "%2e%2e/secret.txt", "link.txt", "examples", "x.js", "%00"):
            assert running.http.get(f"/page/{name}").status_code == 404, name
        (page / "index.html").write_text("<!doctype html>drawn")
        assert running.http.get("/").text.endswith("drawn")
