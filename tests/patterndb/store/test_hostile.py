"""A small run of benchmarks/hostile_database.py, which spoils files in every way."""

from __future__ import annotations

import importlib.util
import random
import shutil
import sqlite3
import sys
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARK = Path(__file__).parents[3] / "benchmarks" / "hostile_database.py"
FILES = 5


@pytest.fixture(scope="module")
def hostile() -> ModuleType:
    spec = importlib.util.spec_from_file_location("hostile_database", BENCHMARK)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("way", ["bits", "pages", "sector", "cut", "value", "schema"])
def test_spoiled_files_are_answered_or_refused(
    way: str, hostile: ModuleType, learned_once: Path, tmp_path: Path
) -> None:
    assert way in hostile.WAYS
    sound = hostile.ask_everything(Path(shutil.copy(learned_once, tmp_path / "asked.db")))
    assert not any(": error" in answer for answer in sound)
    content = hostile.read_content(learned_once)
    for number in range(FILES):
        path = Path(shutil.copy(learned_once, tmp_path / f"{number}.db"))
        try:
            hostile.WAYS[way](path, random.Random(f"{way} {number}"))
        except sqlite3.Error:
            continue
        word, text = hostile.judge(path, sound, content)
        assert word != "unforeseen", f"{way} {number}: {text}"
        # What a value may lawfully be, no check can tell from what it was.
        assert word != "unseen" or way == "value", f"{way} {number}: {text}"
