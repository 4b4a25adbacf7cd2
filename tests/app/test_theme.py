"""Whatever the picture behind a panel, its words can be read."""

from itertools import product

import pytest

from wzviewer.app.theme import PALETTES, Rgba

LEAST = 4.5  # contrast of text: WCAG 2.2, 1.4.3
PHOTOS = {"black": (0.0, 0.0, 0.0), "white": (1.0, 1.0, 1.0)}
INKS = ("text", "muted", "accent", "error")
GROUNDS = ("panel", "field", "hover")


def over(color: Rgba, below: tuple[float, ...]) -> tuple[float, ...]:
    """A colour laid on an opaque one."""
    return tuple(color[3] * c + (1.0 - color[3]) * b for c, b in zip(color, below, strict=False))


def luminance(color: tuple[float, ...]) -> float:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in color]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(ink: Rgba, ground: tuple[float, ...]) -> float:
    low, high = sorted((luminance(over(ink, ground)), luminance(ground)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", PALETTES)
@pytest.mark.parametrize("photo", PHOTOS)
def test_words_on_panels_can_be_read(name, photo):
    palette = PALETTES[name]
    panel = over(palette.panel, PHOTOS[photo])
    for ink, ground in product(INKS, GROUNDS):
        below = panel if ground == "panel" else over(getattr(palette, ground), panel)
        found = contrast(getattr(palette, ink), below)
        assert found >= LEAST, (ink, ground, found)  # least: 4.68, muted on hover in the dark over white


@pytest.mark.parametrize("name", PALETTES)
@pytest.mark.parametrize("photo", PHOTOS)
def test_words_on_buttons_that_are_on_can_be_read(name, photo):
    palette = PALETTES[name]
    lit = over(palette.pressed, over(palette.panel, PHOTOS[photo]))
    assert contrast(palette.accent, lit) >= LEAST  # least: 4.59, dark over white
    assert contrast(palette.on_accent, palette.accent[:3]) >= LEAST
