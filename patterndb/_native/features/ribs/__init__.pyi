from . import polygon as polygon
from . import raster as raster
from . import rib as rib
from . import slicing as slicing
