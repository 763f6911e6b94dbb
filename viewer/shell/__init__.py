"""The windows' shell, on Qt: one main window for all viewers, and the scene that they draw in.

Read :mod:`~viewer.shell.probe` (can a window be opened here?), :mod:`~viewer.shell.application`,
:mod:`~viewer.shell.settings`, :mod:`~viewer.shell.actions` (menus, shortcuts and palette of one
table), :mod:`~viewer.shell.scene`, :mod:`~viewer.shell.docks`, :mod:`~viewer.shell.window`.
Nothing in here is imported by what draws pictures without a window.
"""
