"""What stands in a folder, for machines whose desktop has no file dialogs."""

import os
from dataclasses import dataclass
from pathlib import Path

PHOTOS = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff", ".wz")
SUFFIXES = {"open": PHOTOS, "open path": (".json",)}  # by dialog
MOST = 2000  # files of a folder that are looked at


@dataclass(frozen=True)
class Listing:
    """A folder.

    Attributes:
        folder: its path.
        folders: names of the folders in it, by name.
        files: names of the files that can be opened, by name.
        is_read: whether it is known yet what stands in it.
    """

    folder: Path
    folders: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    is_read: bool = True


def folder_of(text: str) -> Path:
    """Returns the folder that a typed path is in, or is."""
    path = Path(text.strip() or ".").expanduser().absolute()
    is_inside = text.rstrip().endswith(("/", os.sep)) or path.is_dir()
    return path if is_inside else path.parent


def to_read(kind: str, text: str, before: Listing | None = None) -> Listing | None:
    """Returns the listing of a typed path's folder, still to be read unless it is the one before."""
    if kind not in SUFFIXES:
        return None
    folder = folder_of(text)
    return before if before is not None and before.folder == folder else Listing(folder, is_read=False)


def listed(kind: str, text: str, before: Listing | None = None) -> Listing | None:
    """Returns what can be opened in the folder of a typed path; None where the dialog opens nothing.

    Args:
        kind: of the dialog.
        text: as typed.
        before: the listing so far: the same folder is not read again.
    """
    if kind not in SUFFIXES:
        return None
    folder = folder_of(text)
    if before is not None and before.folder == folder:
        return before
    folders, files = [], []
    try:
        with os.scandir(folder) as entries:
            for entry, _ in zip(entries, range(MOST), strict=False):
                if entry.name.startswith("."):
                    continue
                if entry.is_dir():
                    folders.append(entry.name)
                elif entry.name.lower().endswith(SUFFIXES[kind]):
                    files.append(entry.name)
    except OSError:  # not there, or not for this user: an empty list says so
        return Listing(folder)
    return Listing(folder, tuple(sorted(folders, key=str.lower)), tuple(sorted(files, key=str.lower)))


def matching(listing: Listing, text: str) -> Listing:
    """Returns what goes on as the typed name begins; all of it while that is a name in full."""
    name = "" if text.rstrip().endswith(("/", os.sep)) else Path(text).name.lower()
    whole = {listing.folder.name.lower(), *(file.lower() for file in listing.files), ""}
    if name in whole:
        return listing
    folders = tuple(f for f in listing.folders if f.lower().startswith(name))
    files = tuple(f for f in listing.files if name in f.lower())
    return Listing(listing.folder, folders, files)
