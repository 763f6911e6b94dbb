from . import counts as counts
from . import draft as draft
from . import filling as filling
from . import network as network
from . import quadgrids as quadgrids
from . import tools as tools
from . import tracing as tracing
