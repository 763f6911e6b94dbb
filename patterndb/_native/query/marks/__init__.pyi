from . import bestmarked as bestmarked
from . import markplaces as markplaces
from . import patterntable as patterntable
