"""Every deliberate error of wzviewer, as one tree.

::

    WzError                  one line for the user; the command line exits with `exit_status`
    ├── InputError       2   a file, a number or a word that cannot be used
    │   └── PromptError  2   a prompt outside the grammar; carries the words that are known
    ├── OutputError      2   the result cannot be written there
    ├── ContextError     2   no OpenGL context; says which system package is missing
    └── WorkerError      3   the worker failed, hung or was killed
        └── Cancelled  130   the user asked for it
"""


class WzError(Exception):
    """An error that is reported as one line: ``error: WHAT: WHY. HINT``.

    Args:
        what: the thing concerned, such as a path or an option.
        why: what is wrong with it.
        hint: what to do about it; may be empty.
    """

    exit_status = 2

    def __init__(self, what: str, why: str, hint: str = "") -> None:
        self.what, self.why, self.hint = what, why, hint
        super().__init__(self.line())

    def line(self) -> str:
        """Returns ``WHAT: WHY. HINT`` without line breaks."""
        text = f"{self.what}: {self.why.rstrip('.')}."
        return " ".join(f"{text} {self.hint}".split())


class InputError(WzError):
    """A file, a number or a word that cannot be used."""


class PromptError(InputError):
    """A prompt that the synthesizer does not understand."""


class OutputError(WzError):
    """A result that cannot be written."""


class ContextError(WzError):
    """No OpenGL context can be made."""


class WorkerError(WzError):
    """The worker process failed, hung or was killed."""

    exit_status = 3


class Cancelled(WorkerError):  # noqa: N818 - an outcome the user asked for, not a fault
    """The user cancelled the work."""

    exit_status = 130

    def __init__(self, what: str = "generation", why: str = "cancelled", hint: str = "") -> None:
        super().__init__(what, why, hint)
