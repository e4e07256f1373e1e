"""Render: one picture of what an agent sees, by the names of scan and viewpoint.

    python render.py        in a folder with `homes` (SYNTHETIC), made by
    enfilade homes --preset small --homes 3 -o homes
"""

import math

import enfilade
import numpy as np

d = enfilade.Dataset("homes")
np.save("v.npy", d.render("home0001", "8d1bc14ed55e8309507ac48f26b0ed4e", heading=math.pi))
