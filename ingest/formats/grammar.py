"""What counts as a number, a blank and a token in a text format.

float() and int() accept more than any mesh format does ('1_000', 'nan', 'infinity',
digits of other scripts), and each library a different surplus. So text is matched
against these expressions first, and only then converted.

Quantifiers of single characters are possessive, and what a group may give back fails at
once: matching is linear in the text, whatever the text. Groups are not possessive: before
Python 3.11.5 such a group that fails half-way leaves what it has read behind as matched.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NoReturn, Protocol

import numpy as np
from numpy.typing import NDArray

from patterndb.errors import MeshFileError

BLANK = rb"[ \t\v\f]"
NUMBER = rb"[+-]?+(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][+-]?+[0-9]++)?"
# Nine digits always fit int32 arithmetic in 64 bits; longer ones are left to the line parsers.
SHORT_NATURAL = rb"[0-9]{1,9}+"

# More digits than this name no vertex, and int() itself refuses more than 4,300 of them.
MAX_DIGITS = 18

_number = re.compile(NUMBER)


def compile_lines(token: bytes) -> re.Pattern[bytes]:
    """Return the expression of lines that hold tokens of one kind and blanks, or nothing."""
    row = rb"(?:B*+(?:T(?:B++T)*)?B*+\n)*".replace(b"B", BLANK)
    return re.compile(row.replace(b"T", rb"(?:" + token + rb")"))


class Fail(Protocol):
    """Raises the MeshFileError for a place in the file being read."""

    def __call__(
        self, message: str, *, line: int | None = None, token: bytes | None = None
    ) -> NoReturn: ...


def make_fail(path: str | Path) -> Fail:
    """A :class:`Fail` for the file at ``path``."""

    def fail(message: str, *, line: int | None = None, token: bytes | None = None) -> NoReturn:
        text = None if token is None else quote_token(token)
        raise MeshFileError(message, path=path, line=line, token=text)

    return fail


def quote_token(token: bytes) -> str:
    """A token as text, bytes that are not UTF-8 escaped."""
    return token.decode("utf-8", "backslashreplace")


def to_number(token: bytes, fail: Fail, line: int) -> float:
    """A finite coordinate; anything else fails."""
    if _number.fullmatch(token) is None:
        if token.lower().lstrip(b"+-").startswith((b"nan", b"inf", b"1.#", b"-1.#")):
            fail("a coordinate must be finite; repair the vertex", line=line, token=token)
        if token.count(b",") == 1:
            fail("not a number: write the decimal sign as a point", line=line, token=token)
        fail("not a number", line=line, token=token)
    value = float(token)
    if not math.isfinite(value):
        fail("the number is too large for a coordinate", line=line, token=token)
    return value


def parse_numbers(text: bytes) -> NDArray[np.float64]:
    """All numbers of blank-separated text that is known to match :data:`NUMBER` throughout."""
    return _parse(text, np.dtype(np.float64))


def parse_integers(text: bytes) -> NDArray[np.int64]:
    """All integers of blank-separated text, each known to have at most 18 digits."""
    return _parse(text, np.dtype(np.int64))


def _parse(text: bytes, dtype: np.dtype) -> NDArray:
    if not text or text.isspace():  # of which numpy.fromstring makes up an element
        return np.empty(0, dtype)
    return np.fromstring(text, dtype=dtype, sep=" ")


def count_tokens(text: bytes) -> NDArray[np.int64]:
    """(n,) number of tokens on each line of text; every line ends in a newline."""
    codes = np.frombuffer(text, np.uint8)
    if not len(codes):
        return np.empty(0, np.int64)
    blank = codes <= ord(" ")
    starts = ~blank
    starts[1:] &= blank[:-1]
    return np.diff(np.cumsum(starts)[codes == ord("\n")], prepend=0)


def normalise_newlines(text: bytes) -> bytes:
    """Text with every line, also the last, ended by a newline; CR LF and CR count as one."""
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return text if text.endswith(b"\n") else text + b"\n"


def refuse_nul(text: bytes, fail: Fail, first_line: int = 1) -> None:
    """Fail on the first NUL byte: no text format has any use for one."""
    nul = text.find(b"\0")
    if nul >= 0:
        line = first_line + text.count(b"\n", 0, nul)
        fail("a NUL byte: the file is damaged, or not text", line=line)
