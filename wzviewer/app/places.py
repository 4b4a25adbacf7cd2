"""Which level the view is in."""

from wzviewer.app.state import AppState


def level_here(state: AppState) -> int:
    """Returns the visible level whose scale is nearest to the view's, among those that hold its centre."""
    view, scene = state.view, state.scene

    def gap(index: int) -> float:
        camera = scene[index].camera
        ratio = camera.focal_px / camera.width * view.camera.width / view.camera.focal_px
        return abs(ratio - 1.0 / ratio)

    for index in sorted(scene.visible(), key=gap):  # the first that holds the centre: panels ask every frame
        camera = scene[index].camera
        x, y, z = camera.project(view.focus)
        if z > 0 and 0 <= x <= camera.width and 0 <= y <= camera.height:
            return index
    return 0


def shows_photo(state: AppState) -> bool:
    """Whether the flat photo is shown: previews of E_0 are half as sharp, and no use until one turns."""
    if state.photo is None or not len(state.scene):
        return state.photo is not None
    poses = (state.view.camera.camera_from_world, state.view.home.camera_from_world)
    return not state.scene.is_committed(0) and bool((poses[0] == poses[1]).all())
