from . import growing as growing
