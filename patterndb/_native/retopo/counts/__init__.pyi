from . import cycles as cycles
from . import matching as matching
from . import parity as parity
from . import regularity as regularity
