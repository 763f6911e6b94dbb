from . import pentagon_cuts as pentagon_cuts
from . import plan as plan
from . import reflex_cuts as reflex_cuts
