from . import crossfield as crossfield
from . import remesh as remesh
from . import tracing as tracing
