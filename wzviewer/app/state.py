"""The whole state of the app, frozen.  Only `app.apply` makes a new one.

The scene is the exception: an append-only log that is shared with the renderer and the worker's
client, and that `apply` extends in place.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from wzviewer.app.changes import History
from wzviewer.app.commands.base import Command
from wzviewer.app.errands import Errand
from wzviewer.app.journal import Leftover
from wzviewer.app.listing import Listing
from wzviewer.app.look import Look
from wzviewer.app.overlays import LogView, PaletteView
from wzviewer.app.plan import Film as Film
from wzviewer.app.plan import KeepPlan
from wzviewer.app.recents import Recents
from wzviewer.app.region import Region
from wzviewer.app.settings import Settings
from wzviewer.app.timeline import Timeline
from wzviewer.app.wishes import Goal as Goal
from wzviewer.app.wishes import Queue
from wzviewer.core.camera import Camera
from wzviewer.core.marks import UNMARKED, Mark
from wzviewer.core.navigation import Flight, ZoomSpring, total_magnification
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray, DoubleArray
from wzviewer.core.vocabulary import Offer, Reading, Vocabulary, starters

ToastKind = Literal["info", "done", "error"]
DragKind = Literal["orbit", "pan"]
DialogKind = Literal[
    "open", "save", "picture", "film", "open path", "save path", "unsaved", "recover", "drop", "making", ""
]
COVER_LIMIT = 1.2  # how much larger than "all of it fits" a photo may be, to fill the window
TOAST_S = {"info": 5.0, "done": 4.0, "error": 12.0}
OFFER_S = 9.0  # of a notice with a button: time to read it and to go there
REST_S = 0.2  # without motion, before the picture is refined


@dataclass(frozen=True)
class Toast:
    """A short notice that goes by itself, unless its details are shown.

    Attributes:
        text: one or two sentences.
        kind: what it is about.
        born_s: when it appeared, s.
        details: more, such as a traceback; empty when there is no more.
        retry: what can be asked for again: a prompt, or None.
        is_expanded: whether the details are shown.
        button: label of what it offers; empty when it offers nothing.
        command: what the button asks for.
    """

    text: str
    kind: ToastKind
    born_s: float
    details: str = ""
    retry: str | None = None
    is_expanded: bool = False
    button: str = ""
    command: Command | None = None

    @property
    def life_s(self) -> float:
        """How long it is shown."""
        return max(TOAST_S[self.kind], OFFER_S if self.button else 0.0)

    def is_alive(self, now_s: float) -> bool:
        """Whether it is still shown."""
        return self.is_expanded or now_s - self.born_s < self.life_s


@dataclass(frozen=True)
class StageNote:
    """A stage that has begun.

    Attributes:
        number: the paper's, 0 to 5.
        name: as the worker calls it.
        start_s: when it began, s.
    """

    number: int
    name: str
    start_s: float


@dataclass(frozen=True)
class Job:
    """A request to the worker that is running.

    Attributes:
        request_id: the client's number of it.
        kind: E_0 from a photo, or a further level.
        prompt: U of the level.
        started_s: when it was asked for, s.
        stages: every stage begun, the running one last.
        fraction: of the whole, [0, 1].
        level: index of the level in the making, once a preview is there.
        is_cancelling: whether the user asked to stop.
        is_auto: whether nobody asked for it: the view rested where detail was missing.
        parent: index of the level that is refined.
        goal: what it was asked for.
        instead_of: index of the variant that stands back for the preview of this one.
    """

    request_id: int
    kind: Literal["photo", "level"]
    prompt: str
    started_s: float
    stages: tuple[StageNote, ...] = ()
    fraction: float = 0.0
    level: int | None = None
    is_cancelling: bool = False
    is_auto: bool = False
    parent: int = 0
    goal: Goal | None = None
    instead_of: int | None = None


@dataclass(frozen=True, eq=False)
class Drag:
    """A drag of the mouse; angles and shifts count from its start, so nothing accumulates."""

    kind: DragKind
    camera: Camera
    pivot: DoubleArray
    x_px: float
    y_px: float


@dataclass(frozen=True, eq=False)
class View:
    """Where the user is.

    Attributes:
        camera: C_render.
        home: the whole picture, in the window's size.
        focus: (3,) world point that speed and magnification refer to: what one looks at.
        focused: camera that the focus was found for; None when it is out of date.
        spring: the zoom that still runs after the wheel.
        flight: a flight to another camera, or None.
        drag: a drag of the mouse, or None.
        moved_s: when the camera last moved, s.
    """

    camera: Camera
    home: Camera
    focus: DoubleArray
    focused: Camera | None = None
    spring: ZoomSpring = field(default_factory=ZoomSpring)
    flight: Flight | None = None
    drag: Drag | None = None
    moved_s: float = -1e9

    @classmethod
    def at_home(cls, camera: Camera, width: int, height: int) -> "View":
        """Returns the view of a whole picture in a window."""
        home = fitted(camera, width, height)
        return cls(home, home, home.unproject(width / 2, height / 2, 1.0))

    @property
    def focus_depth(self) -> float:
        """Depth of the focus, world units."""
        return float(self.camera.to_camera(self.focus)[2])

    @property
    def magnification(self) -> float:
        """How much larger the focus appears than from home."""
        return total_magnification(self.camera, self.home, self.focus)

    @property
    def is_moving(self) -> bool:
        """Whether the camera moves by itself or by a drag."""
        return self.flight is not None or self.drag is not None or not self.spring.is_resting


@dataclass(frozen=True, eq=False)
class Place:
    """A view that one can come back to.

    Attributes:
        camera: C_render there.
        focus: (3,) world point that was looked at.
    """

    camera: Camera
    focus: DoubleArray


@dataclass(frozen=True, eq=False)
class Trail:
    """Places where the view came to rest, oldest first, and which of them is the present one."""

    places: tuple[Place, ...] = ()
    at: int = 0


@dataclass(frozen=True)
class Panels:
    """What is shown beside the picture."""

    tree: bool = True
    statistics: bool = False
    help: bool = False
    keep: bool = False
    settings: bool = False
    start: bool = False
    history: bool = False
    materials: bool = False
    locator: bool = True
    timeline: bool = False
    dialog: DialogKind = ""
    dialog_path: str = ""
    dialog_list: Listing | None = None
    dialog_note: str = ""  # why the path was not taken, or what happens if it is given once more
    prompt_focus: int = 0  # frames until the prompt line, which was asked for, has the cursor


@dataclass(frozen=True, eq=False)
class AppState:
    """Everything that the panels show and the commands change.

    Attributes:
        view: camera and its motions.
        scene: the log of levels.
        photo: (h, w, 3) uint8, the picture before E_0 exists; None on the start page.
        finer_photo: the same with more pixels, if it has them.
        path: the scene's file, if it has one.
        source: the file that the document was opened from; None for the demo's and what was recovered.
        name: of the document, for the title.
        saved: (levels, their marks) when last saved.
        prompt: U_{i+1} as typed.
        refusal: why the last prompt was refused; goes when the prompt changes.
        vocabulary: words that the worker understands; of an earlier run, or none, until it says so.
        reading: how the prompt is understood so far.
        offer: which of the offers is marked.
        job: the running request.
        goal: what the running chain of levels is for.
        is_goal_waiting: whether a flight has to end before the goal is asked for.
        settings: what the user prefers.
        asked_for: camera that auto detail has dealt with.
        look: how the scene is drawn.
        trail: places that back and forward go through.
        history: of the scene, for undo and redo.
        queue: what is asked for once the running request has ended.
        region: frame of the next level, where that is not simply the view.
        variants: index of a level whose variants are shown side by side; None for none.
        renaming: index of the level whose name is edited in place; None for none.
        after: what to do once unsaved changes are settled.
        picture_size: of pictures and films, px; None is the window's.
        plan: what the next picture and the next film will be.
        film: the film in the making.
        timeline: keyframes of a film.
        leftover: what a crash left behind, until the user has said what to do with it.
        palette: of all commands.
        log: its window.
        recents: files that were open lately.
        errand: what is being done to a file, or None.
        next_path: to be opened once the running request has stopped.
        is_closing: whether the loop ends.
    """

    view: View
    scene: Scene = field(default_factory=Scene)
    photo: ByteArray | None = None
    finer_photo: ByteArray | None = None
    path: Path | None = None
    source: Path | None = None
    name: str = ""
    saved: tuple[int, dict[int, Mark]] = (0, {})
    prompt: str = ""
    refusal: str = ""
    vocabulary: Vocabulary = field(default_factory=Vocabulary)
    reading: Reading = field(default_factory=Reading)
    offer: int = 0
    job: Job | None = None
    goal: Goal | None = None
    is_goal_waiting: bool = False
    settings: Settings = field(default_factory=Settings)
    asked_for: Camera | None = None
    look: Look = field(default_factory=Look)
    trail: Trail = field(default_factory=Trail)
    history: History = field(default_factory=History)
    queue: Queue = field(default_factory=Queue)
    region: Region = field(default_factory=Region)
    variants: int | None = None
    renaming: int | None = None
    toasts: tuple[Toast, ...] = ()
    panels: Panels = field(default_factory=Panels)
    after: Callable[["AppState"], "AppState"] | None = None
    picture_size: tuple[int, int] | None = None
    plan: KeepPlan = field(default_factory=KeepPlan)
    film: Film | None = None
    timeline: Timeline = field(default_factory=Timeline)
    leftover: Leftover | None = None
    palette: PaletteView = field(default_factory=PaletteView)
    log: LogView = field(default_factory=LogView)
    recents: Recents = field(default_factory=Recents)
    errand: Errand | None = None
    next_path: Path | None = None
    now_s: float = 0.0
    stalled_s: float = 0.0
    is_worker_ready: bool = False
    is_closing: bool = False

    @property
    def has_document(self) -> bool:
        """Whether there is a photo or a scene; otherwise the start page is shown."""
        return self.photo is not None or len(self.scene) > 0

    @property
    def offers(self) -> tuple[Offer, ...]:
        """Prompts that are one key away."""
        return self.reading.offers if self.prompt.strip() else starters(self.vocabulary)

    @property
    def num_finished(self) -> int:
        """Levels that are committed."""
        return sum(self.scene.is_committed(level.index) for level in self.scene)

    @property
    def is_dirty(self) -> bool:
        """Whether closing would lose a finished level, a name, or a key of the timeline."""
        is_other = self.saved != (self.num_finished, self.lasting_marks) or self.timeline.is_changed
        return self.num_finished > 0 and is_other

    @property
    def lasting_marks(self) -> dict[int, Mark]:
        """The marks of the scene; what stands back for a variant in the making counts as shown."""
        index, marks = self.job.instead_of if self.job is not None else None, self.scene.marks
        mark = replace(marks.pop(index), sight="shown") if index in marks else UNMARKED
        return marks if index is None or mark == UNMARKED else {**marks, index: mark}

    @property
    def clock_s(self) -> float:
        """What a clock on the wall says, s: people are told how long things took by it."""
        return self.now_s + self.stalled_s

    @property
    def is_moving(self) -> bool:
        """Whether the picture moves, or did a moment ago."""
        return self.view.is_moving or self.now_s - self.view.moved_s < REST_S

    def with_toast(
        self,
        text: str,
        kind: ToastKind = "info",
        details: str = "",
        retry: str | None = None,
        button: str = "",
        command: Command | None = None,
    ) -> "AppState":
        """Returns the state with one more notice; an equal one is renewed."""
        others = tuple(t for t in self.toasts if t.text != text)
        toast = Toast(text, kind, self.now_s, details, retry, button=button, command=command)
        return replace(self, toasts=(*others, toast)[-4:])

    def with_view(self, view: View) -> "AppState":
        """Returns the state with another view; notes when the camera moved."""
        if view.camera is not self.view.camera:
            view = replace(view, moved_s=self.now_s)
        return replace(self, view=view)


def fitted(camera: Camera, width: int, height: int) -> Camera:
    """Returns home: the whole picture in a window, or a little less when that fills the window."""
    whole = camera.resized(width, height)
    ratios = (width / camera.width, height / camera.height)
    cover = max(ratios) / min(ratios)
    return whole.zoomed(width / 2, height / 2, cover) if cover <= COVER_LIMIT else whole


def empty_state(width: int, height: int) -> AppState:
    """Returns the start page in a window."""
    view = View.at_home(Camera.initial(width, height), width, height)
    return AppState(view)
