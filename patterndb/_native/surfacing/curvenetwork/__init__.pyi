from . import meetings as meetings
from . import survey as survey
