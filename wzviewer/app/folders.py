"""Where file dialogs begin."""

from pathlib import Path

from wzviewer.app.state import AppState

PICTURES = "Pictures"  # under this name on every system, as far as it has not been translated


def beginning(state: AppState) -> Path:
    """Returns the folder that a dialog shows first.

    That of the document; else the one that wzviewer was started in, which says nothing when a desktop
    started it: then that of the newest of the recent files, or the usual one of photos.
    """
    document = state.path if state.path is not None else state.source
    if document is not None:
        return document.absolute().parent
    here, home = Path.cwd(), Path.home()
    if here not in (home, Path(here.anchor)):
        return here
    recent = next((file.path.parent for file in state.recents.files if not file.is_missing), None)
    if recent is not None:
        return recent
    pictures = home / PICTURES
    return pictures if pictures.is_dir() else home


def suggested(state: AppState, default: str, suffix: str) -> str:
    """Returns the path that a save dialog begins with: named like the document.

    Args:
        state: of the app.
        default: name without a suffix, where the document has none.
        suffix: of the file, with its dot.
    """
    return str(beginning(state) / Path(state.name or default).with_suffix(suffix).name)
