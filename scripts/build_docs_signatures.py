"""Signatures as they are written, the same under every version of Python."""

from __future__ import annotations

import inspect
import re
from typing import Any


def signature(name: str, function: Any, *, drop_first: bool = False) -> str:
    """``name(parameters) -> result``, on one line or with a line for each parameter."""
    described = inspect.signature(function)
    parameters = list(described.parameters.values())[drop_first:]
    words: list[str] = []
    star = False
    for p in parameters:
        if p.kind is p.VAR_POSITIONAL:
            star = True
        if p.kind is p.KEYWORD_ONLY and not star:
            words.append("*")
            star = True
        mark = {p.VAR_POSITIONAL: "*", p.VAR_KEYWORD: "**"}.get(p.kind, "")
        word = mark + p.name
        if p.annotation is not p.empty:
            word += f": {spelled(p.annotation)}"
        if p.default is not p.empty:
            word += f" = {default(p.default)}" if ":" in word else f"={default(p.default)}"
        words.append(word)
    result = returned(function)
    tail = f" -> {result}" if result and result != "None" else ""
    line = f"{name}({', '.join(words)}){tail}"
    if len(line) <= 88:
        return line
    return f"{name}(\n" + "".join(f"    {word},\n" for word in words) + f"){tail}"


def one_line(text: str) -> str:
    return re.sub(r",\)", ")", re.sub(r"\s+", " ", text).replace("( ", "(")).replace(", )", ")")


def returned(function: Any) -> str:
    annotation = getattr(function, "__annotations__", {}).get("return", "")
    return spelled(annotation) if annotation else ""


def spelled(annotation: Any) -> str:
    return annotation if isinstance(annotation, str) else getattr(annotation, "__name__", "Any")


def default(value: Any) -> str:
    # A default_factory has an object of dataclasses' own, whose text holds an address.
    text = repr(value)
    return "..." if text.startswith("<") else text
