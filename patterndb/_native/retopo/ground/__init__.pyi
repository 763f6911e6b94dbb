from . import geodesic as geodesic
from . import localmap as localmap
from . import orientation as orientation
from . import planarcut as planarcut
from . import shortening as shortening
from . import topology as topology
