from . import feasibility as feasibility
from . import systems as systems
from . import widths as widths
