from . import evening as evening
from . import rules as rules
from . import tjoin as tjoin
from . import walks as walks
