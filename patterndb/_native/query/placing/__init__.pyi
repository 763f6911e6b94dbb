from . import flow as flow
from . import laplace as laplace
from . import region as region
from . import strands as strands
from . import untangle as untangle
