"""OBJ in plain Python, one line and one character class at a time: slow, and easy to believe.

Written from the format's description and not from the reader, whose answers it is held against.
"""

from __future__ import annotations

import math

NUMERIC = """
    vt vn vp l p s mg lod bevel c_interp d_interp cstype deg bmat step curv curv2 surf parm trim
    hole scrv sp end con ctech stech res bsp bzp cdc cdp
"""
TEXT = "g o usemtl mtllib usemap maplib shadow_obj trace_obj t"
SKIPPED = set(NUMERIC.split())
NAMES = set(TEXT.split())


class RefusedError(Exception):
    """The text is not an OBJ file with faces."""


def read(data: bytes) -> tuple[list[list[float]], list[list[int]]]:
    """Points, and faces counted from 0."""
    if data[:3] == b"\xef\xbb\xbf":
        data = data[3:]
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise RefusedError("UTF-16")
    # latin-1: every byte a character, so that names may hold anything
    text = data.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")
    if "\0" in text:
        raise RefusedError("NUL")
    points: list[list[float]] = []
    faces: list[list[int]] = []
    lines = text.split("\n")
    if lines[-1] == "":
        lines.pop()
    lines.reverse()
    while lines:
        line = lines.pop()
        if len(line) > 2**22:
            raise RefusedError("long line")
        words = _words(line.split("#")[0])
        if "#" not in line and line.endswith("\\") and words[0] not in NAMES:
            while "#" not in line and line.endswith("\\"):
                if not lines:
                    raise RefusedError("continued beyond the end")
                line = line[:-1] + " " + lines.pop()
            words = _words(line.split("#")[0])
        if not words or words[0] in NAMES or words[0] in SKIPPED:
            continue
        if words[0] == "v":
            numbers = [_number(word) for word in words[1:]]
            if len(numbers) not in (3, 4, 6, 7):
                raise RefusedError("vertex")
            points.append(numbers[:3])
        elif words[0] in ("f", "fo"):
            face = [_corner(word, len(points)) for word in words[1:]]
            if not 3 <= len(face) <= 100_000:
                raise RefusedError("arity")
            faces.append(face)
        else:
            raise RefusedError(words[0])
    if not faces or any(not 0 <= i < len(points) for face in faces for i in face):
        raise RefusedError("faces")
    return points, faces


def _words(text: str) -> list[str]:
    for blank in "\t\v\f":
        text = text.replace(blank, " ")
    return [word for word in text.split(" ") if word]


def _digits(text: str) -> bool:
    return text != "" and all(character in "0123456789" for character in text)


def _number(word: str) -> float:
    mantissa, e, exponent = word.lower().partition("e")
    if e and not _digits(exponent[1:] if exponent[:1] in ("+", "-") else exponent):
        raise RefusedError(word)
    whole, _, fraction = (mantissa[1:] if mantissa[:1] in ("+", "-") else mantissa).partition(".")
    if not _digits(whole + fraction) or "." in fraction:
        raise RefusedError(word)
    value = float(word)
    if not math.isfinite(value):
        raise RefusedError(word)
    return value


def _integer(word: str) -> int:
    if not _digits(word.removeprefix("-")):
        raise RefusedError(word)
    digits = word.removeprefix("-").lstrip("0") or "0"
    return int(("-" if word.startswith("-") else "") + digits[:4000])


def _corner(word: str, seen: int) -> int:
    parts = word.split("/")
    if len(parts) > 3:
        raise RefusedError(word)
    for part in parts[1:]:
        if part:
            _integer(part)
    index = _integer(parts[0])
    if index == 0 or seen + index < 0 > index:
        raise RefusedError(word)
    return index - 1 if index > 0 else seen + index
