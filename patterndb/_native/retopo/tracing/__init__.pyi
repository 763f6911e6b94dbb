from . import geodesic as geodesic
from . import localmap as localmap
from . import planarcut as planarcut
from . import shortening as shortening
