"""The page of ``patterndb serve``, in TypeScript; ``scripts/build_page.py`` builds it.

The sources are in ``source``. What is built lies in ``bundle`` and comes with every wheel;
``patterndb_app.service`` serves it. The page talks to the service through its HTTP interface
alone. Read ``source/main.ts`` first, then ``fillview.ts``, ``patternview.ts`` and
``holeview.ts``, a tab each.
"""
