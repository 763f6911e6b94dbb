"""SurfaceRequest of the documentation site, which scripts/build_site.py builds (make site)."""

project = "patterndb"
author = "the patterndb contributors"
project_copyright = author

extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "index"

# Anchors of headings are those that GitHub gives, so that a link works in both places.
myst_heading_anchors = 6

# Else --db would become a dash and db.
smartquotes = False

html_theme = "furo"
html_title = "patterndb"
html_show_sphinx = False
html_use_index = False
pygments_style = "friendly"
pygments_dark_style = "monokai"
