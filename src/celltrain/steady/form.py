"""The form of a cell in a train, in words.

What tells them apart are the hollows of the meridian about its poles, each as deep as the pole lies
behind the outermost point on its side, and whether the cell is longer than it is wide:

* no hollow: a bullet, or, wider than long, a lens;
* one at the rear: a parachute, if the hollow takes half of the length or more; less deep, a bullet
  with a dimple, or, wider than long, a cup;
* one at the front alone: the same pointing backwards;
* one on each side: a biconcave disc.
"""

from celltrain.harmonics import Profile
from celltrain.meridian.geometry import meridian_points

#: Depth from which a hollow counts, r0, and the part of the length that makes a parachute.
HOLLOW, HALF = 0.05, 0.5


def form_of(profile: Profile) -> str:
    """The form of a cell of this meridian, front pole to rear pole."""
    rho, z = meridian_points(profile)
    length, width = float(z.max() - z.min()), 2.0 * float(rho.max())
    front, rear = float(z.max() - z[0]), float(z[-1] - z.min())
    if min(front, rear) >= HOLLOW:
        return "biconcave disc"
    depth = max(front, rear)
    if depth < HOLLOW:
        return "bullet" if length >= width else "lens"
    if depth >= HALF * length:
        name = "parachute"
    else:
        name = "bullet with a dimple" if length >= width else "cup"
    return name if rear > front else f"{name}, pointing backwards"
