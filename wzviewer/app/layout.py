"""Where the panels stand, from the size of the window alone: so a test can hold that none overlap."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

MARGIN_PT = 14.0
BAR_PT = 46.0  # height of toolbar, prompt and status
SIDE_PT = 236.0  # width of the tree
CORNER_PT = 190.0  # width that the scale bar and the status need
TOOLBAR_PT = 450.0
PROMPT_PT = (300.0, 620.0)  # narrowest and widest
SETTINGS_PT = 320.0  # width of settings, Keep and history
LEAST_SIDE_PT = 260.0  # height of these; where there is less room they stand before the prompt
INSET_PT = 124.0  # height of the locator
STACK_PT = 320.0  # narrowest stack; where there is less room it stands before the tree
LOWEST_PT = 420.0  # window that has room for it
NARROW_PT = 2 * CORNER_PT + PROMPT_PT[0] + 4 * MARGIN_PT  # below it the prompt stands above the corners


@dataclass(frozen=True)
class Rect:
    """A rectangle in imgui units."""

    x: float
    y: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """X of the right edge."""
        return self.x + self.width

    @property
    def bottom(self) -> float:
        """Y of the lower edge."""
        return self.y + self.height

    def overlaps(self, other: "Rect") -> bool:
        """Whether two rectangles share more than an edge."""
        apart = self.right <= other.x or other.right <= self.x
        return not (apart or self.bottom <= other.y or other.bottom <= self.y)

    def above(self, others: "Sequence[Rect]", gap: float) -> "Rect":
        """Returns it cut off at its foot, so that it ends above all that it would overlap.

        Args:
            others: what stands there already; those without a size do not count.
            gap: left free between.
        """
        tops = [o.y for o in others if o.width > 0 and o.height > 0 and self.overlaps(o)]
        return replace(self, height=max(min(tops) - gap - self.y, 0.0)) if tops else self


@dataclass(frozen=True)
class Layout:
    """The places of all panels.

    Attributes:
        scale: imgui units per point.
        window: everything.
        toolbar: top left.
        breadcrumb: right of it, as wide as its contents, at most this.
        tree: below it, as high as its contents need, at most this.
        side: in its place: settings, history and the like; at most so high.
        statistics: top right.
        toasts: in its place.
        toasts_beside: left of it.
        prompt: bottom centre; progress and refusal grow upwards from it.
        scale_bar: bottom left.
        status: bottom right.
        stack: above the prompt and right of the tree, where progress and the like grow upwards from.
        locator: above it; without width where the window is too small.
    """

    scale: float
    window: Rect
    toolbar: Rect
    breadcrumb: Rect
    tree: Rect
    side: Rect
    statistics: Rect
    toasts: Rect
    toasts_beside: Rect
    prompt: Rect
    scale_bar: Rect
    status: Rect
    locator: Rect
    stack: Rect

    def clear_of(self, others: Sequence[Rect]) -> "Layout":
        """Returns it with all that hangs from the top cut off where it would overlap."""
        gap = 0.5 * MARGIN_PT * self.scale
        hanging = ["tree", "statistics", "toasts", "toasts_beside"]
        hanging += [] if self.side.overlaps(self.prompt) else ["side"]
        return replace(self, **{name: getattr(self, name).above(others, gap) for name in hanging})


def arrange(width: float, height: float, scale: float) -> Layout:
    """Places the panels.

    Args:
        width: of the window, imgui units.
        height: of the window, imgui units.
        scale: imgui units per point.
    """
    gap, bar, side, corner = (x * scale for x in (MARGIN_PT, BAR_PT, SIDE_PT, CORNER_PT))
    is_narrow = width < NARROW_PT * scale
    room = width - 2 * gap if is_narrow else width - 2 * corner - 4 * gap
    prompt_width = min(room, PROMPT_PT[1] * scale)
    bottom = height - gap - bar
    prompt_y = bottom - bar - gap if is_narrow else bottom
    prompt = Rect((width - prompt_width) / 2, prompt_y, prompt_width, bar)
    corner = min(corner, (width - 3 * gap) / 2)
    tree_y = gap + bar + gap
    right_width = min(310 * scale, width - side - 3 * gap)
    right_x = width - gap - right_width
    above_y = min(bottom, prompt_y) - gap / 2  # where all ends that does not stand at the foot
    right = Rect(right_x, tree_y, right_width, above_y - gap / 2 - tree_y)
    toolbar = Rect(gap, gap, min(TOOLBAR_PT * scale, width - 2 * gap), bar)
    stack_x = max(prompt.x, gap + side + gap / 2)
    stack = replace(prompt, x=stack_x, width=prompt.right - stack_x)
    inset = 0.0 if is_narrow or height < LOWEST_PT * scale else INSET_PT * scale
    locator = Rect(width - gap - corner, bottom - inset - gap / 2, corner if inset else 0.0, inset)
    crumbs_x = toolbar.right + gap / 2
    side_y = tree_y - gap / 2
    side_bottom = above_y if above_y - side_y >= LEAST_SIDE_PT * scale else height - gap / 2
    return Layout(
        scale,
        Rect(0.0, 0.0, width, height),
        toolbar,
        Rect(crumbs_x, gap, max(width - gap - crumbs_x, 0.0), bar),
        Rect(gap, tree_y, side, max(above_y - gap / 2 - tree_y, bar)),
        Rect(gap, side_y, min(SETTINGS_PT * scale, toolbar.width), max(side_bottom - side_y, bar)),
        right,
        right,
        replace(right, x=right_x - gap / 2 - right_width),
        prompt,
        Rect(gap, bottom, corner, bar),
        Rect(width - gap - corner, bottom, corner, bar),
        locator,
        stack if stack.width >= STACK_PT * scale else prompt,
    )
