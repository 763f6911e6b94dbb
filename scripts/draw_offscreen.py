"""Has VTK draw off screen where there is no display, for scripts that draw with pyvista.

VTK finds its OpenGL library when the first window is made, and where there is none it ends the
process. So a child process tries first.
"""

from __future__ import annotations

import os
import subprocess
import sys

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
"""


def prepare_offscreen() -> None:
    """Choose a way for VTK to draw without a display; SystemExit if there is none."""
    if os.environ.get(VARIABLE) or not sys.platform.startswith("linux"):
        return
    for kind in HEADLESS:
        trial = subprocess.run(
            [sys.executable, "-c", TRIAL],
            env=os.environ | {VARIABLE: kind},
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
        if trial.returncode == 0:
            os.environ[VARIABLE] = kind
            return
    sys.exit("nothing can be drawn: apt-get install libegl1 libgl1-mesa-dri")
