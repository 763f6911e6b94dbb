from . import candidates as candidates
from . import decompose as decompose
from . import flatness as flatness
from . import search as search
from . import subcycles as subcycles
