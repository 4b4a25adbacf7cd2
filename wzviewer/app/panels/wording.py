"""Numbers and stages as people read them."""

import math

STAGES = {  # of the paper, as the worker calls them, and what they are to somebody who waits
    "initial scene": "making the photo 3D",
    "new scale image": "painting finer detail",
    "depth registration": "giving it depth",
    "surfels": "building it in 3D",
    "auxiliary views": "filling in what is behind",
    "optimisation": "finishing touches",
}
SURE_S, SURE_SHARE = 4.0, 0.05  # of something, after which the rest of it can be told
UNIT = "u"  # the world unit: the median distance in the photo


def magnification_text(value: float, is_short: bool = False) -> str:
    """Returns a magnification, such as ×1.4, ×64 or ×2.1 million; where there is little room ×262 k."""
    if value < 9.95:
        return f"×{value:.1f}"
    if is_short and value >= 1e5:
        return (
            f"×{count_text(round(value))}"
            if value < 1e9
            else f"×{value:.0e}".replace("e+0", "e").replace("e+", "e")
        )
    for limit, name, size in ((1e6, "", 1.0), (1e9, " million", 1e6), (1e12, " billion", 1e9)):
        if value < limit:
            scaled = value / size
            digits = f"{scaled:.1f}" if name and scaled < 100 else f"{scaled:,.0f}"
            return f"×{digits}{name}"
    return f"×{value / 1e12:.1f} trillion"


def share_text(share: float) -> str:
    """Returns a length as a share of the photo's width, such as 1/2 of the photo or 1/5,000 of the photo."""
    if share >= 0.95:
        return "as wide as the photo" if share < 1.05 else f"{share:g} × the photo"
    parts = 1.0 / share
    for limit, name, size in ((1e6, "", 1.0), (1e9, " million", 1e6), (1e12, " billion", 1e9)):
        if parts < 0.999 * limit:
            return f"1/{round(parts / size):,}{name} of the photo"
    return f"1/{round(parts / 1e12):,} trillion of the photo"


def stage_text(name: str) -> str:
    """Returns a stage in plain words, beginning small."""
    return STAGES.get(name, name)


def count_text(count: int) -> str:
    """Returns a count, such as 512, 83 k or 1.2 M."""
    if count < 1000:
        return str(count)
    return f"{count / 1e3:.0f} k" if count < 999_500 else f"{count / 1e6:.1f} M"


def left_text(elapsed_s: float, fraction: float) -> str:
    """Returns how long something still takes, such as 40 s left or 3 min left; empty while nobody can say.

    Args:
        elapsed_s: since it began, s.
        fraction: of it that is done.
    """
    if elapsed_s < SURE_S or fraction < SURE_SHARE:
        return ""
    left_s = elapsed_s * (1.0 - min(fraction, 1.0)) / fraction
    if left_s >= 90.0:
        return f"{left_s / 60.0:.0f} min left"
    return f"{max(math.ceil(left_s / 5.0), 1) * 5} s left"  # in fives: it is no clock
