from . import fit as fit
from . import knots as knots
