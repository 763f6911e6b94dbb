"""A program with a small window from which a file can be dragged: ``dragging.py FILE``."""

from __future__ import annotations

import sys

from PySide6.QtCore import QMimeData, Qt, QUrl
from PySide6.QtGui import QDrag, QMouseEvent
from PySide6.QtWidgets import QApplication, QLabel


class Source(QLabel):
    """Where the drag begins."""

    def mousePressEvent(self, ev: QMouseEvent) -> None:  # noqa: N802, Qt's
        """Drag the file until the button comes up."""
        drag, data = QDrag(self), QMimeData()
        data.setUrls([QUrl.fromLocalFile(sys.argv[1])])
        drag.setMimeData(data)
        drag.exec(Qt.DropAction.CopyAction)


if __name__ == "__main__":
    app = QApplication([])
    source = Source("file")
    # No frame, and where it is told: the window manager has no say.
    flags = Qt.WindowType
    source.setWindowFlags(flags.X11BypassWindowManagerHint | flags.WindowStaysOnTopHint)
    source.setGeometry(0, 0, 60, 30)
    source.show()
    print("shown", flush=True)
    app.exec()
