"""Which models a synthesizer's name stands for."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from wzviewer.worker.models.base import Synthesizer

if TYPE_CHECKING:
    from wzviewer.worker.models.builtin.detail.synthesizer import DetailSynthesizer
    from wzviewer.worker.models.builtin.objects.editor import ObjectEditor


def load_synthesizer(name: str) -> Synthesizer:
    """Returns the models of a backend of `catalogue.BACKENDS`."""
    return {"builtin": _builtin}[name]()


def _builtin() -> Synthesizer:
    from wzviewer.worker.models.builtin.depth.estimator import DepthEstimator
    from wzviewer.worker.models.builtin.detail.synthesizer import DetailSynthesizer
    from wzviewer.worker.models.builtin.objects.editor import ObjectEditor
    from wzviewer.worker.models.builtin.views.synthesizer import ViewSynthesizer

    detail, editor = DetailSynthesizer(), ObjectEditor()
    models = (DepthEstimator(), detail, editor, ViewSynthesizer())
    return Synthesizer("builtin", *models, warm_up=lambda idle: _warm_up(detail, editor, idle))


def _warm_up(detail: "DetailSynthesizer", editor: "ObjectEditor", idle: Callable[[], bool]) -> None:
    """Compiles the kernels in the order a session needs them, while nobody waits for an answer."""
    from wzviewer.worker import in_view, rasterize
    from wzviewer.worker.models.builtin.views import synthesizer

    for step in (rasterize.warm_up, in_view.warm_up, synthesizer.warm_up, detail.warm_up, editor.warm_up):
        if not idle():
            return
        step()
