from . import bestmarked as bestmarked
from . import corner_placement as corner_placement
from . import family as family
