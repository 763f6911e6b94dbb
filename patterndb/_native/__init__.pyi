#: Release of the package, that of rust/Cargo.toml.
__version__: str

from . import core as core
from . import features as features
from . import geometry as geometry
from . import ingest as ingest
from . import query as query
from . import retopo as retopo
from . import store as store
from . import surfacing as surfacing
