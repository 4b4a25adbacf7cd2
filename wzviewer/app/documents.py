"""Opening, saving and closing.  Unsaved levels are never dropped without asking."""

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

from wzviewer.app import commands as cmd
from wzviewer.app.errands import Errand
from wzviewer.app.folders import beginning, suggested
from wzviewer.app.generation import cancel, reconstruct
from wzviewer.app.history import restored
from wzviewer.app.listing import Listing, listed, to_read
from wzviewer.app.region import Region
from wzviewer.app.reopening import note_document
from wzviewer.app.services import Services
from wzviewer.app.state import AppState, DialogKind, Panels, View
from wzviewer.app.timeline import FIELD, keep, timeline_of
from wzviewer.core.camera import Camera
from wzviewer.core.files import is_scene_file, load_scene, save_scene
from wzviewer.core.photos import finer_photo, fit_photo, load_photo
from wzviewer.core.scene import Scene
from wzviewer.core.types import ByteArray

SCENE_SUFFIX = ".wz"


def open_path(services: Services, state: AppState, command: cmd.Open) -> AppState:
    """Opens a photo or a scene, after settling unsaved changes."""

    def then(settled: AppState) -> AppState:
        return _open(services, settled, command.path)

    return settle(state, then)


def open_demo(services: Services, state: AppState, command: cmd.OpenDemo) -> AppState:
    """Opens the bundled picture."""
    path = demo_photo()
    if path is None:
        return state.with_toast("The bundled picture is missing. Open a photo of your own.", "error")
    return open_path(services, state, cmd.Open(path))


def demo_photo() -> Path | None:
    """Returns the bundled picture: inside the installed package, or in the source tree."""
    package = Path(str(files("wzviewer")))
    candidates = (package / "assets" / "meadow.png", package.parent / "assets" / "meadow.png")
    return next((p for p in candidates if p.is_file()), None)


def settle(state: AppState, then: Callable[[AppState], AppState]) -> AppState:
    """Does something that drops the document, or asks first when levels are unsaved."""
    if not state.is_dirty:
        return then(state)
    return replace(state, after=then, panels=replace(state.panels, dialog="unsaved"))


def settle_unsaved(services: Services, state: AppState, command: cmd.SettleUnsaved) -> AppState:
    """Carries out the answer to the question about unsaved changes."""
    then = state.after
    state = without_dialog(state)
    if command.answer == "stay" or then is None:
        return replace(state, after=None)
    if command.answer == "discard":
        return then(replace(state, after=None))
    state = save(services, state, cmd.Save())
    if not state.is_dirty:
        return then(replace(state, after=None))
    return state  # a dialog asks where; `after` is done once the file is written


def open_next(services: Services, state: AppState, command: None = None) -> AppState:
    """Opens what was waiting for the running request to stop; called every frame."""
    if state.next_path is None or state.job is not None:
        return state
    return _open(services, replace(state, next_path=None), state.next_path)


@dataclass(frozen=True, eq=False)
class _Content:
    """What a file holds: a scene, or a photo in its working size and perhaps finer."""

    scene: Scene | None = None
    photo: ByteArray | None = None
    finer: ByteArray | None = None


def _open(services: Services, state: AppState, path: Path) -> AppState:
    if state.job is not None:  # its level must not fall into the new document
        return replace(cancel(services, state, cmd.CancelJob()), next_path=path)
    errand = Errand(
        f"Opening {path.name}",
        lambda services, state, content: _opened(services, state, path, content),
        lambda services, state, line: state.with_toast(line, "error"),
    )
    return run_errand(services, state, errand, lambda: _content_of(path))


def _content_of(path: Path) -> _Content:
    if is_scene_file(path):
        return _Content(load_scene(path))
    original = load_photo(path)
    photo = fit_photo(original)
    return _Content(None, photo, finer_photo(original, photo))


def _opened(services: Services, state: AppState, path: Path, content: _Content) -> AppState:
    """The document is another one from now on."""
    if state.job is not None:  # asked for while the file was read
        return replace(cancel(services, state, cmd.CancelJob()), next_path=path)
    fresh = _fresh(state, path)
    if content.scene is not None:
        fresh = with_scene(services, fresh, content.scene, path)
        note_document(services, fresh, path)
        return fresh
    photo = content.photo
    assert photo is not None  # either, by construction
    width, height = state.view.camera.width, state.view.camera.height
    view = View.at_home(Camera.initial(photo.shape[1], photo.shape[0]), width, height)
    fresh = replace(fresh, view=view, photo=photo, finer_photo=content.finer)
    if path != demo_photo():
        fresh = replace(fresh, source=path)
        note_document(services, fresh, path)
    return reconstruct(services, fresh)


def _fresh(state: AppState, path: Path) -> AppState:
    """What does not belong to the document is kept."""
    width, height = state.view.camera.width, state.view.camera.height
    panels = state.panels
    return AppState(
        View.at_home(Camera.initial(width, height), width, height),
        name=path.name,
        toasts=state.toasts,
        panels=Panels(tree=panels.tree, statistics=panels.statistics, locator=panels.locator),
        now_s=state.now_s,
        is_worker_ready=state.is_worker_ready,
        vocabulary=state.vocabulary,
        settings=state.settings,
        picture_size=state.picture_size,
        film=state.film,
        recents=state.recents,
        log=state.log,
        plan=replace(state.plan, source="way", seconds=None) if state.plan.source == "keys" else state.plan,
    )


def with_scene(services: Services, state: AppState, scene: Scene, path: Path | None) -> AppState:
    """Returns the state with a finished scene as its document."""
    services.client.load(scene)
    view = View.at_home(scene[0].camera, state.view.camera.width, state.view.camera.height)
    centre = view.camera.unproject(view.camera.width / 2, view.camera.height / 2, scene[0].anchor_depth)
    state = replace(state, view=replace(view, focus=centre), scene=scene, path=path)
    state = with_timeline(state)
    return replace(state, history=restored(scene), saved=(state.num_finished, scene.marks))


def with_timeline(state: AppState) -> AppState:
    """Returns the state with the keyframes that the scene was saved with."""
    camera = state.view.camera
    found = timeline_of(state.scene.unknown_fields.get(FIELD), (camera.width, camera.height))
    if found is None:
        return state.with_toast("The keyframes in this file are damaged: the timeline is empty.", "error")
    return replace(state, timeline=found)


# ------------------------------------------------------------------ saving


def save(services: Services, state: AppState, command: cmd.Save) -> AppState:
    """Saves to the scene's file, or asks where."""
    if state.num_finished == 0:
        return state.with_toast("Nothing to save yet: the scene is still being made.")
    if state.path is not None and not command.asks:
        return save_to(services, state, cmd.SaveTo(state.path))
    suggestion = suggested(state, "scene", SCENE_SUFFIX)
    return ask(state, services.dialogs.ask_save(suggestion), "save", suggestion)


def save_to(services: Services, state: AppState, command: cmd.SaveTo) -> AppState:
    """Saves to a file, and goes on with what was waiting for it."""
    path = command.path if command.path.suffix else command.path.with_suffix(SCENE_SUFFIX)
    scene = state.scene.copy()  # as it is now: levels may come while it is written
    if state.job is not None and state.job.instead_of is not None:
        scene.show(state.job.instead_of)  # it stands back for one that is not finished
    timeline = keep(state.timeline, scene.unknown_fields)
    state.scene.unknown_fields = dict(scene.unknown_fields)
    saved = replace(state, saved=(state.num_finished, scene.marks), timeline=timeline)
    errand = Errand(
        f"Saving {path.name}",
        lambda services, state, _: _saved(services, state, path, saved),
        lambda services, state, line: replace(state.with_toast(line, "error"), after=None),
    )
    return run_errand(services, state, errand, lambda: save_scene(scene, path))


def _saved(services: Services, state: AppState, path: Path, then: AppState) -> AppState:
    """Notes what was saved; what changed since is unsaved still."""
    if state.scene is not then.scene:
        return state  # another document is open by now
    is_same = state.timeline.path == then.timeline.path
    timeline = then.timeline if is_same else replace(state.timeline, saved=then.timeline.path)
    state = replace(state, path=path, name=path.name, saved=then.saved, timeline=timeline)
    note_document(services, state, path)
    state = state.with_toast(f"Saved {path.name}.", "done")
    after = state.after
    return after(replace(state, after=None)) if after is not None else state


# ------------------------------------------------------------------ errands


def run_errand(services: Services, state: AppState, errand: Errand, work: Callable[[], object]) -> AppState:
    """Begins work on a file; whoever does it at once has done it when this returns."""
    if state.errand is not None:
        return state.with_toast(f"One moment: {state.errand.line[:1].lower()}{state.errand.line[1:]} …")
    services.errands.start(errand, work)
    return follow_errand(services, replace(state, errand=errand))


def follow_errand(services: Services, state: AppState) -> AppState:
    """Takes over what became of a file; called every frame."""
    ended = services.errands.poll()
    if ended is None:
        return state
    errand, result, fault = ended
    state = replace(state, errand=None)
    done: AppState = errand.failed(services, state, fault) if fault else errand.done(services, state, result)
    return done


# ------------------------------------------------------------------ dialogs


def ask_open(services: Services, state: AppState, command: cmd.AskOpen) -> AppState:
    """Shows the open dialog."""
    folder = str(beginning(state))
    return ask(state, services.dialogs.ask_open(folder), "open", folder)


def ask(state: AppState, has_dialog: bool, kind: DialogKind, suggestion: str) -> AppState:
    """Falls back to a line of text where the system has no dialogs."""
    if has_dialog:
        return state
    found = to_read(kind, suggestion)
    panels = replace(state.panels, dialog=kind, dialog_path=suggestion, dialog_note="", dialog_list=found)
    return replace(state, panels=panels)


def edit_path(services: Services, state: AppState, command: cmd.EditPath) -> AppState:
    """The path line holds another text."""
    panels = state.panels
    found = to_read(panels.dialog, command.text, panels.dialog_list)
    panels = replace(panels, dialog_path=command.text, dialog_note="", dialog_list=found)
    return replace(state, panels=panels)


def follow_listing(services: Services, state: AppState) -> AppState:
    """Begins to read the folder that the open dialog is in: a network's may take seconds."""
    kind, wanted = state.panels.dialog, state.panels.dialog_list
    if wanted is None or wanted.is_read or state.errand is not None:
        return state
    folder = wanted.folder
    errand = Errand(
        f"Reading {folder.name}",
        lambda services, state, found: _with_listing(state, found),
        lambda services, state, line: _with_listing(state, Listing(folder)),
    )
    return run_errand(services, state, errand, lambda: listed(kind, str(folder) + os.sep))


def _with_listing(state: AppState, found: Listing) -> AppState:
    wanted = state.panels.dialog_list
    if wanted is None or wanted.folder != found.folder:  # the user has gone on
        return state
    return replace(state, panels=replace(state.panels, dialog_list=found))


def close(services: Services, state: AppState, command: cmd.Close) -> AppState:
    """Ends the loop, after settling unsaved changes; a film in the making is given up when asked twice."""
    is_warned = any(t.command == cmd.Close() and t.is_alive(state.now_s) for t in state.toasts)
    if state.film is not None and not (is_warned or state.film.is_cancelling):
        text = f"The {state.film.kind} is not ready yet. Close once more to give it up."
        return state.with_toast(text, button="Close", command=cmd.Close())
    if is_missed(state) and not command.gives_up and state.panels.dialog != "making":
        return replace(state, after=None, panels=replace(state.panels, dialog="making"))
    state = without_dialog(state) if state.panels.dialog == "making" else state
    return settle(state, lambda settled: replace(settled, is_closing=True))


def is_missed(state: AppState) -> bool:
    """Whether a level that somebody asked for is still to come."""
    job = state.job
    is_asked_for = job is not None and job.kind == "level" and not (job.is_auto or job.is_cancelling)
    return is_asked_for or state.goal is not None or bool(state.queue.goals)


def follow_making(state: AppState) -> AppState:
    """Takes the question about what is being made away once it is there; called every frame."""
    return without_dialog(state) if state.panels.dialog == "making" and not is_missed(state) else state


def without_dialog(state: AppState) -> AppState:
    """Returns the state with the dialog closed."""
    panels = replace(state.panels, dialog="", dialog_path="", dialog_note="", dialog_list=None)
    region = Region() if state.region.is_of_drop else state.region
    return replace(state, panels=panels, region=region)
