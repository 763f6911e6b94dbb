from . import construct as construct
from . import expand as expand
from . import holes as holes
from . import placing as placing
from . import recognition as recognition
from . import relaxed as relaxed
from . import solving as solving
