"""Compiled kernels that no longer fit their source are dropped.

numba keys what it keeps of a function by the file that the function is in.  A kernel that calls a
function of another file stays as it was when only that file changes: after an update of the working
copy the old code would run on, and nobody would know why.
"""

import contextlib
from pathlib import Path

CACHE_SUFFIXES = (".nbi", ".nbc")


def drop_stale(package: Path) -> int:
    """Deletes what numba has kept beside a package since before its newest source file.

    Args:
        package: folder of the sources, with numba's files in its ``__pycache__``.

    Returns:
        How many files were deleted; those that cannot be are left.
    """
    changed_s = max((source.stat().st_mtime for source in package.glob("*.py")), default=0.0)
    dropped = 0
    for kept in (package / "__pycache__").glob("*.nb?"):
        with contextlib.suppress(OSError):  # another process may be at it, or the folder is read-only
            if kept.suffix in CACHE_SUFFIXES and kept.stat().st_mtime < changed_s:
                kept.unlink()
                dropped += 1
    return dropped
