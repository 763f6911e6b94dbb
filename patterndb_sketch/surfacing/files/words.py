"""Text files of numbers, word by word, with the line for messages."""

from __future__ import annotations

import math
from typing import NoReturn

from patterndb_sketch.surfacing.errors import InvalidNetworkError


class Words:
    """The words of a text in order; lines matter for messages only.

    data: the bytes of the text. Raises InvalidNetworkError if they are no UTF-8.
    """

    __slots__ = ("_lines", "_next", "_numbers", "_words")

    def __init__(self, data: bytes) -> None:
        try:
            text = data.decode()
        except UnicodeDecodeError as error:
            raise InvalidNetworkError(
                f"byte {error.start}: this is no list of numbers: the text is not UTF-8"
            ) from None
        lines = enumerate(text.splitlines(), 1)
        self._lines = [(number, line.split()) for number, line in lines if line.strip()]
        self._words = [word for _, words in self._lines for word in words]
        self._numbers = [number for number, words in self._lines for _ in words]
        self._next = 0

    @property
    def left(self) -> int:
        """How many words are left."""
        return len(self._words) - self._next

    def peek(self) -> str:
        """The next word, empty after the last."""
        return self._words[self._next] if self.left else ""

    def line(self, index: int) -> list[str]:
        """The words of one line, blank ones not counted; none after the last."""
        return self._lines[index][1] if index < len(self._lines) else []

    def word(self, what: str) -> str:
        """The next word; ``what`` should be there."""
        if not self.left:
            raise InvalidNetworkError(
                f"the text ends where {what} should follow; is the file complete?"
            )
        self._next += 1
        return self._words[self._next - 1]

    def count(self, what: str, least: int, words_each: int = 1) -> int:
        """The next word, the number of things to follow of so many words each."""
        word = self.word(what)
        # Longer than any number of things, and than Python reads.
        if len(word) > 18 or not (word.isascii() and word.isdigit()):
            self.fail(f"{_shown(word)} is not {what}")
        number = int(word)
        if number < least:
            self.fail(f"{what} is {number}; there must be {least} at least")
        if number * words_each > self.left:
            self.fail(
                f"{what} is {number:,}, but only {self.left:,} words follow; is the file complete?"
            )
        return number

    def number(self, what: str) -> float:
        """The next word, a finite number."""
        word = self.word(what)
        try:
            number = float(word)
        except ValueError:
            self.fail(f"{_shown(word)} is not {what}")
        if not math.isfinite(number):
            self.fail(f"{_shown(word)} is not a finite number")
        return number

    def points(self, count: int, what: str) -> list[list[float]]:
        """The next points [x, y, z]."""
        return [[self.number(f"a coordinate of {what}") for _ in range(3)] for _ in range(count)]

    def end(self) -> None:
        """Raise InvalidNetworkError if words are left."""
        if self.left:
            self.fail(
                f"the text goes on with {_shown(self.word(''))} where it should end; are the "
                "counts before it right?"
            )

    def fail(self, message: str) -> NoReturn:
        """Raise InvalidNetworkError with the line of the word read last."""
        number = self._numbers[max(self._next - 1, 0)] if self._numbers else 1
        raise InvalidNetworkError(f"line {number}: {message}")


def _shown(word: str) -> str:
    return repr(word if len(word) <= 40 else word[:39] + "…")
