"""How requests are refused: errors with a status, and the one shape in which they are told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypedDict

from patterndb.errors import (
    DatabaseError,
    InvalidBoundaryError,
    InvalidCodeError,
    InvalidMeshError,
    MissingExtraError,
    NotFoundError,
    PatternDBError,
)


class RefusalJson(TypedDict):
    """An error as JSON: ``error`` is the first of ``errors``."""

    ok: bool
    error: str
    errors: list[str]
    status: int


class RefusedRequestError(PatternDBError):
    """A request that is not answered; ``status`` is that of HTTP, ``headers`` go with it.

    message, more: what is wrong, each by itself.
    """

    status = 400

    def __init__(self, message: str, *more: str, headers: Mapping[str, str] | None = None) -> None:
        super().__init__(message)
        self.more = more
        self.headers = dict(headers or {})


class MalformedRequestError(RefusedRequestError, ValueError):
    """The body or a parameter is not what the documentation says."""


class TokenError(RefusedRequestError, PermissionError):
    """What changes a database needs the token."""

    status = 401


class ForeignOriginError(RefusedRequestError, PermissionError):
    """A page of another site asks."""

    status = 403


class ReadOnlyServiceError(RefusedRequestError, PermissionError):
    """The service was started without a token: nothing can be changed."""

    status = 403


class SlowClientError(RefusedRequestError, TimeoutError):
    """The body did not arrive in time."""

    status = 408


class ConflictError(RefusedRequestError):
    """What is asked for does not go with the state that something is in."""

    status = 409


class LargeRequestError(RefusedRequestError, ValueError):
    """More was sent, or asked for, than a limit allows."""

    status = 413


class MediaTypeError(RefusedRequestError, ValueError):
    """The body is of a type that is not read here."""

    status = 415


class UnknownHostError(RefusedRequestError, ValueError):
    """The request names a host that this service does not answer for."""

    status = 421


class BusyError(RefusedRequestError, RuntimeError):
    """As many requests as may be are at work and waiting."""

    status = 429


class ClientGoneError(RefusedRequestError, ConnectionError):
    """The client went away before its answer was there: the status is for the log alone."""

    status = 499


class LongHeadersError(RefusedRequestError, ValueError):
    """The headers have more bytes than any need."""

    status = 431


class StoppingError(RefusedRequestError, RuntimeError):
    """The service is being stopped."""

    status = 503


#: Statuses of the library's errors; the first that fits.
_STATUSES: tuple[tuple[type[Exception], int], ...] = (
    (NotFoundError, 404),
    (InvalidBoundaryError, 422),
    (InvalidMeshError, 422),
    (InvalidCodeError, 422),
    (MissingExtraError, 501),
    (DatabaseError, 503),
    (MemoryError, 503),
)


def find_status(error: BaseException) -> int:
    """The status of HTTP that an error has; 500 for one that no one foresaw."""
    if isinstance(error, RefusedRequestError):
        return error.status
    for kind, status in _STATUSES:
        if isinstance(error, kind):
            return status
    # InvalidQueryError and its like: options that ask for nothing.
    return 422 if isinstance(error, PatternDBError) else 500


def tell_error(error: BaseException, request_id: str) -> str:
    """What a client is told: names of this machine's files, and its code, stay in the log."""
    if isinstance(error, DatabaseError):
        return f"the database cannot be asked just now; the log says why, under {request_id}"
    if isinstance(error, MemoryError):
        return "this needs more memory than there is; ask for shorter sides or fewer fills"
    if isinstance(error, PatternDBError):
        return str(error)
    return f"unforeseen error; the log has it under {request_id}"


def format_refusal(messages: Sequence[str], status: int) -> RefusalJson:
    """The one shape of errors."""
    return {"ok": False, "error": messages[0], "errors": list(messages), "status": status}
