from . import basic as basic
from . import census as census
from . import growth as growth
from . import hashing as hashing
from . import learning as learning
from . import prepare as prepare
from . import shards as shards
