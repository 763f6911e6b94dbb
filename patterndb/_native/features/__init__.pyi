from . import fishbone as fishbone
from . import ribs as ribs
from . import splines as splines
