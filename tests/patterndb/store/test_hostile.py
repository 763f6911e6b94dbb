"""Spoiled files are answered or refused; benchmarks/hostile_database.py spoils more of them."""

from __future__ import annotations

import random
import shutil
import sqlite3
from pathlib import Path

import pytest

from tests.support.store.hostile import WAYS, ask_everything, judge, read_content

FILES = 5


@pytest.mark.parametrize("way", WAYS)
def test_spoiled_files_are_answered_or_refused(
    way: str, learned_once: Path, tmp_path: Path
) -> None:
    sound = ask_everything(Path(shutil.copy(learned_once, tmp_path / "asked.db")))
    assert not any(": error" in answer for answer in sound)
    content = read_content(learned_once)
    for number in range(FILES):
        path = Path(shutil.copy(learned_once, tmp_path / f"{number}.db"))
        try:
            WAYS[way](path, random.Random(f"{way} {number}"))
        except sqlite3.Error:
            continue
        word, text = judge(path, sound, content)
        assert word != "unforeseen", f"{way} {number}: {text}"
        # What a value may lawfully be, no check can tell from what it was.
        assert word != "unseen" or way == "value", f"{way} {number}: {text}"
