from . import parts as parts
from . import plan as plan
from . import prolong as prolong
