"""The cache of compiled kernels: numba looks only at an entry kernel's own file."""

import hashlib
from pathlib import Path

import pytest

from wzviewer.worker.models.builtin.objects import march, patterns, strands

FOLDER = Path(march.__file__).parent


def digest(*names):
    text = "".join((FOLDER / f"{name}.py").read_text("utf-8") for name in names)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


@pytest.mark.parametrize(
    ("module", "compiled_in"),
    [
        (strands, ("noise",)),
        (march, ("noise", "shapes", "primitives")),
        (patterns, ("noise", "shapes", "primitives", "terms", "chitin", "skins", "botany", "minerals")),
    ],
)
def test_entry_files_carry_the_digest_of_what_they_compile(module, compiled_in):
    """After an edit of those files put the new value into KERNELS, else stale machine code is loaded."""
    assert digest(*compiled_in) == module.KERNELS
