"""Makes sure that VTK can draw here before it is asked to.

VTK finds its OpenGL library when the first window is made, and where there is none it ends
the process with a segmentation fault. So a child process tries first: the worst it can do
is die, and the parent says what is missing.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys

from patterndb.errors import PatternDBError
from patterndb.system.extras import require_extra

#: The variable by which VTK (9.4 and later) is told which kind of window to make.
VARIABLE = "VTK_DEFAULT_OPENGL_WINDOW"

#: Kinds of window that need no display, best first.
HEADLESS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")

#: Seconds a trial may take; a software renderer on a loaded machine needs one or two.
PATIENCE = 60.0

TRIAL = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.AddRenderer(vtkRenderer())
window.Render()
print(window.GetClassName())
"""


class DisplayError(PatternDBError, RuntimeError):
    """There is no display to open a window on, or no OpenGL library to draw with."""


def prepare_opengl(*, off_screen: bool) -> None:
    """Choose a way for VTK to draw, and raise DisplayError if there is none.

    off_screen: into a file; otherwise into a window. Sets VARIABLE for this process to the
    kind of window that works, but tries no other than the user has set. Costs a child
    process of about half a second, once. Does nothing but on Linux: elsewhere OpenGL comes
    with the system. Raises MissingExtraError where VTK is not installed.
    """
    require_extra("viewer", "a window")
    if not sys.platform.startswith("linux"):
        return
    display = bool(os.environ.get("DISPLAY"))
    if not off_screen and not display:
        raise DisplayError(
            "there is no display to open a window on (DISPLAY is not set); "
            "draw into a file instead (-o FILE), or run under xvfb-run"
        )
    if not off_screen and os.environ.get(VARIABLE) in HEADLESS:
        # Left from drawing into a file; a window of that kind would never be seen.
        del os.environ[VARIABLE]
    chosen = _choose(off_screen, display, os.environ.get(VARIABLE, ""))
    if chosen is None:
        raise DisplayError(
            "no OpenGL library can be loaded, so that nothing can be drawn in 3D; install one "
            "(Debian and Ubuntu: apt-get install libegl1 libgl1-mesa-dri; "
            "Fedora: dnf install mesa-libEGL mesa-dri-drivers). "
            "Pictures and contact sheets in PNG and SVG need none"
        )
    os.environ[VARIABLE] = chosen


@functools.cache
def _choose(off_screen: bool, display: bool, wanted: str) -> str | None:
    """The first kind of window that works, None if none does."""
    if wanted:
        kinds: tuple[str, ...] = (wanted,)
    elif not off_screen:
        kinds = ("",)
    else:
        # Without a display VTK would still try X first: it warns, and where the X library
        # is missing too it crashes.
        kinds = ("", *HEADLESS) if display else HEADLESS
    return next((made for kind in kinds if (made := try_window(kind)) is not None), None)


def try_window(kind: str) -> str | None:
    """Draw in a window of this kind in a child process; "" leaves the choice to VTK.

    Returns the kind that VTK made, which may be another, or None if it could not draw.
    """
    environment = os.environ | {VARIABLE: kind}
    if not kind:
        del environment[VARIABLE]
    try:
        trial = subprocess.run(
            [sys.executable, "-c", TRIAL],
            env=environment,
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    made = trial.stdout.decode(errors="replace").strip()
    return made if trial.returncode == 0 and made not in ("", "vtkRenderWindow") else None
