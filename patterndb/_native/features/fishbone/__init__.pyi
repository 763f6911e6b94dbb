from . import cut as cut
from . import fishbone as fishbone
from . import terms as terms
from . import tracking as tracking
