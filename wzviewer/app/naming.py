"""What levels are called: the user's name, else the prompt, else what they are."""

from wzviewer.core.scene import Level, Scene

DETAIL = "Detail"  # what a level without a prompt is


def title_of(level: Level) -> str:
    """Returns what a level is called as long as nobody names it: its prompt, or what it is."""
    if level.parent is None:
        return "Photo"
    return level.prompt or DETAIL


def name_in(scene: Scene, index: int) -> str:
    """Returns what a level of a scene is called."""
    return scene.mark(index).name or title_of(scene[index])
