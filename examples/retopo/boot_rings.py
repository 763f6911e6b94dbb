"""Two rings around the boot that part it: below the third row of its laces, and above it.

Between "m" and "h" the third row lies; below "m" are the toe, the sole and two rows, above "h" the
collar and two rows. The rings run between the laces, over the flaps' edges and through the folds
under them, and cut no lace that bridges anything.
"""

from __future__ import annotations

import numpy as np
from sketching import Sketch

#: What the loops pass through, and which way they look.
BELOW = (-0.1275, 0.0615, -0.0040), (-0.38, 1.0, 0.15)
ABOVE = (-0.1259, 0.0706, -0.0020), (-0.42, 1.0, 0.15)

#: Places on them, from the heel along the left side (+z) over the throat and back: heel, side,
#: front of the side, outer part of a flap, its edge, the foot of that, the tongue.
PLACES = {
    "m_back": (-0.1275, 0.0615, -0.0040),
    "m_hl": (-0.1149, 0.0615, 0.0278),
    "m_bl": (-0.0792, 0.0732, 0.0404),
    "m_l": (-0.0382, 0.0882, 0.0439),
    "m_fl": (-0.0079, 0.0999, 0.0429),
    "m_flap_l": (0.0164, 0.1114, 0.0279),
    "m_edge_l": (0.0238, 0.1159, 0.0164),
    "m_foot_l": (0.0157, 0.1129, 0.0163),
    "m_tongue": (0.0199, 0.1170, -0.0009),
    "m_foot_r": (0.0157, 0.1168, -0.0098),
    "m_edge_r": (0.0228, 0.1195, -0.0102),
    "m_flap_r": (0.0106, 0.1167, -0.0222),
    "m_fr": (-0.0069, 0.1118, -0.0343),
    "m_r": (-0.0336, 0.1032, -0.0444),
    "m_br": (-0.0623, 0.0921, -0.0431),
    "m_hr": (-0.1012, 0.0761, -0.0349),
    "h_back": (-0.1259, 0.0706, -0.0020),
    "h_hl": (-0.1099, 0.0729, 0.0276),
    "h_bl": (-0.0788, 0.0843, 0.0385),
    "h_l": (-0.0424, 0.0986, 0.0449),
    "h_fl": (-0.0152, 0.1104, 0.0427),
    "h_flap_l": (0.0032, 0.1201, 0.0296),
    "h_edge_l": (0.0136, 0.1265, 0.0163),
    "h_foot_l": (0.0048, 0.1227, 0.0165),
    "h_tongue": (0.0064, 0.1247, 0.0081),
    "h_lace": (0.0139, 0.1295, -0.0035),
    "h_under": (0.0071, 0.1263, -0.0012),
    "h_foot_r": (0.0061, 0.1271, -0.0090),
    "h_edge_r": (0.0110, 0.1292, -0.0095),
    "h_flap_r": (-0.0008, 0.1267, -0.0258),
    "h_fr": (-0.0168, 0.1214, -0.0352),
    "h_r": (-0.0408, 0.1126, -0.0436),
    "h_br": (-0.0677, 0.1011, -0.0422),
    "h_hr": (-0.1024, 0.0851, -0.0331),
}


def rings(s: Sketch) -> None:
    """Both rings, and the names of places on them."""
    for at, across in (BELOW, ABOVE):
        s.once("loop", at=s.surface.nearest(np.array([at])).points[0], normal=np.array(across))
    s.near(**PLACES)
