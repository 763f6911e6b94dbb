from . import attaching as attaching
from . import crossings as crossings
from . import flooding as flooding
from . import patches as patches
from . import samples as samples
