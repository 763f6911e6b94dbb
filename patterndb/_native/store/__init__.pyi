from . import ddqkey as ddqkey
