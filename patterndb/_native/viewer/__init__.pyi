from . import raster as raster
from . import skin as skin
from . import solid as solid
