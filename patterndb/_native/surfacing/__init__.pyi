from . import chords as chords
from . import cycles as cycles
from . import joining as joining
from . import tessellation as tessellation
