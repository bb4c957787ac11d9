"""Remanence of sintered NdFeB by grade, as its makers guarantee it, and the moment that follows."""

import math

MU0 = 4e-7 * math.pi  # H/m, the value behind the 1e-7 of the field; today's differs by 5.5e-10 of it

# lowest and highest remanence (T) at 20 degrees C over the tables of three makers, which differ by up to 0.02 T:
# en.shanghaimagnet.com/about/Production-Process, jingxin-magnet.com/product-11882-16357-83819.html and
# it-magnet.com/index.php/neodymium-mangets/magnet-characteristics; IEC 60404-8-1 sets classes of this kind
REMANENCE = {
    "N35": (1.17, 1.24),
    "N38": (1.22, 1.26),
    "N40": (1.25, 1.30),
    "N42": (1.28, 1.32),
    "N45": (1.32, 1.38),
    "N48": (1.37, 1.42),
    "N50": (1.39, 1.44),
    "N52": (1.42, 1.46),
}


def cylinder_moment(remanence: float, radius: float, height: float) -> float:
    """Moment (A m^2) of a cylinder magnetised evenly along its axis: remanence (T) times volume over mu0."""
    return remanence * math.pi * radius**2 * height / MU0
