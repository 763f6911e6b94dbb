from . import chords as chords
from . import cycles as cycles
from . import tessellation as tessellation
