"""Which level the view is in."""

from wzviewer.app.state import AppState


def level_here(state: AppState) -> int:
    """Returns the visible level whose scale is nearest to the view's, among those that hold its centre."""
    view = state.view
    best, best_gap = 0, float("inf")
    for index in state.scene.visible():
        camera = state.scene[index].camera
        x, y, z = camera.project(view.focus)
        if z > 0 and 0 <= x <= camera.width and 0 <= y <= camera.height:
            ratio = camera.focal_px / camera.width * view.camera.width / view.camera.focal_px
            gap = abs(ratio - 1.0 / ratio)
            if gap < best_gap:
                best, best_gap = index, gap
    return best
