"""The notebooks of the site: run while it is built, each a page with what its cells write."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = ROOT / "examples" / "notebooks"


def write_notebooks(pages: Path) -> None:
    """Run every notebook in a folder with the examples, and write a page of each."""
    folder = pages / "notebooks"
    folder.mkdir()
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        (folder / f"{path.stem}.md").write_text(format_notebook(path, folder), encoding="utf-8")


def run_notebook(path: Path) -> Any:
    """Run a notebook from its first cell to its last; the notebook with what they wrote."""
    import nbclient
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as name:
        shutil.copytree(
            ROOT / "examples",
            Path(name) / "examples",
            ignore=shutil.ignore_patterns("__pycache__"),
        )
        client = nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3")
        client.execute(cwd=name)
    return notebook


def format_notebook(path: Path, folder: Path) -> str:
    """Return a notebook that has run as Markdown, and write its pictures into the folder.

    Raises an error of nbclient where a cell does, ValueError where nothing is drawn or printed.
    """
    lines: list[str] = []
    pictures = texts = 0
    for cell in run_notebook(path).cells:
        if cell.cell_type == "markdown":
            lines += [cell.source, ""]
            continue
        lines += ["```python", cell.source, "```", ""]
        for output in cell.outputs:
            data = output.get("data", {})
            if "image/svg+xml" in data:
                pictures += 1
                name = f"{path.stem}-{pictures}.svg"
                (folder / name).write_text(data["image/svg+xml"], encoding="utf-8")
                lines += [f"![What the cell draws]({name})", ""]
            else:
                texts += 1
                text = output.get("text") or data.get("text/plain", "")
                lines += ["```text", text.rstrip(), "```", ""]
    if not pictures or not texts:
        raise ValueError(f"{path}: its cells draw {pictures} pictures and print {texts} texts")
    said = f"This is `examples/notebooks/{path.name}`, run when the site was built."
    return "\n".join((lines[0], "", said, "", *lines[1:]))
