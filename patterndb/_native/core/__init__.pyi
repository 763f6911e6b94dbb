from . import code as code
from . import description as description
from . import halfedge as halfedge
from . import polychord as polychord
from . import quadmesh as quadmesh
from . import reduction as reduction
from . import shortcode as shortcode
