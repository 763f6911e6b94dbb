from . import bounding as bounding
from . import closing as closing
from . import measures as measures
