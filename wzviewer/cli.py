"""The command line.  Parsing only: a verb's module is imported when the verb runs."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from wzviewer import __version__
from wzviewer.errors import InputError, WzError

VERBS = ("open", "demo", "generate", "render", "info", "bench", "models")
BENCHES = ("render", "generate", "optimize", "precision", "transition")
INTERRUPTED = 130


class Parser(argparse.ArgumentParser):
    """Reports bad usage as one line and exits with status 2."""

    def error(self, message: str) -> NoReturn:
        """Exits with status 2 and one line."""
        self.exit(2, f"error: {self.prog}: {message}. See {self.prog} --help\n")


class PromptOfZoom(argparse.Action):
    """Attaches ``--prompt`` to the ``--zoom`` before it."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: Any = None) -> None:  # noqa: ANN401
        """Replaces the last zoom by one with the prompt."""
        zooms = namespace.zoom or []
        if not zooms:
            raise InputError(
                f"--prompt {values!r}", "belongs to the --zoom before it", "Give --zoom X,Y first."
            )
        zooms[-1] = replace(zooms[-1], prompt=values)


class AppendZoom(argparse.Action):
    """Collects ``--zoom X,Y[,FACTOR]`` in order."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: Any = None) -> None:  # noqa: ANN401
        """Appends a parsed zoom."""
        from wzviewer.config import parse_zoom

        namespace.zoom = [*(namespace.zoom or []), parse_zoom(values)]


def build_parser() -> argparse.ArgumentParser:
    """Returns the parser of all verbs."""
    parser = Parser(prog="wzviewer", description="One photograph becomes a 3D world that you can zoom into.")
    parser.add_argument("--version", action="version", version=f"wzviewer {__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", parser_class=Parser)
    _add_open(verbs)
    _add_demo(verbs)
    _add_generate(verbs)
    _add_render(verbs)
    _add_others(verbs)
    return parser


def _add_open(verbs: Any) -> None:  # noqa: ANN401
    command = verbs.add_parser("open", help="the desktop app (also: wzviewer FILE)")
    command.add_argument("file", nargs="?", type=Path, help="a photo, or a .wz scene")


def _add_demo(verbs: Any) -> None:  # noqa: ANN401
    command = verbs.add_parser("demo", help="three zooms into the bundled picture")
    command.add_argument("--out", type=Path, default=Path("wzviewer-demo"), metavar="DIR")
    command.add_argument("--seed", type=int, default=0)
    command.add_argument("--no-window", action="store_true", help="write the files only")
    command.add_argument("--json", action="store_true")


def _add_generate(verbs: Any) -> None:  # noqa: ANN401
    command = verbs.add_parser("generate", help="photo -> scene, without a window")
    command.add_argument("image", nargs="?", type=Path)
    command.add_argument("-o", "--output", type=Path, required=True, metavar="SCENE.wz")
    command.add_argument(
        "--zoom",
        action=AppendZoom,
        metavar="X,Y[,FACTOR]",
        help="centre, as fractions of the image before; 8x closer, or 1 to extend it",
    )
    command.add_argument("--prompt", action=PromptOfZoom, metavar="TEXT", help="of the --zoom before it")
    command.add_argument("--script", type=Path, metavar="FILE.toml", help="the same as a file")
    command.add_argument("--seed", type=int)
    command.add_argument("--synthesizer", default="builtin", metavar="NAME")
    command.add_argument("--size", metavar="WxH", help="working size; default: long side 1088 px")
    command.add_argument("--json", action="store_true", help="one JSON object on stdout")


def _add_render(verbs: Any) -> None:  # noqa: ANN401
    command = verbs.add_parser("render", help="scene -> picture or film")
    command.add_argument("scene", type=Path)
    command.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.{png,mp4,gif}")
    command.add_argument("--level", type=int, metavar="K", help="seen by C_K; default: the last level")
    command.add_argument("--magnify", type=float, default=1.0, metavar="F")
    command.add_argument(
        "--orbit", type=float, default=0.0, metavar="DEG", help="turn; of --path orbit: to either side"
    )
    command.add_argument("--camera", metavar="JSON", help="an exact view of a picture, as the app copies it")
    command.add_argument("--size", metavar="WxH", help="default: the camera's; of a GIF 640 px at most")
    command.add_argument("--transparent", action="store_true", help="PNG without a background")
    command.add_argument(
        "--path",
        metavar="zoom|orbit|FILE.json",
        help="camera path of a film; a file as the app or nerfstudio writes it",
    )
    command.add_argument("--path-out", type=Path, metavar="FILE.json", help="also write the film's path")
    command.add_argument("--fps", type=float, help="frames per second; default: 24, GIF 20, or the file's")
    command.add_argument("--seconds", type=float, help="length of the film; default: the path's own")
    command.add_argument("--blend", choices=("transmittance", "linear"), default="transmittance")
    command.add_argument("--no-modulation", action="store_true", help="the paper's ablation")
    command.add_argument("--no-antialias", action="store_true", help="as the paper: minified surfels alias")
    command.add_argument("--depth", type=Path, metavar="OUT.npy", help="also the median depth, world units")
    command.add_argument("--context", choices=("auto", "egl", "osmesa", "window"), default="auto")
    command.add_argument(
        "--rasterizer",
        choices=("auto", "shaders", "kernels"),
        default="auto",
        help="shaders: OpenGL; kernels: the processor, much faster where OpenGL is software",
    )


def _add_others(verbs: Any) -> None:  # noqa: ANN401
    info = verbs.add_parser("info", help="what a scene holds")
    info.add_argument("scene", type=Path)
    info.add_argument("--json", action="store_true")
    bench = verbs.add_parser("bench", help="measure this machine")
    bench.add_argument("what", choices=BENCHES)
    bench.add_argument("--json", action="store_true")
    bench.add_argument("--context", choices=("auto", "egl", "osmesa", "window"), default="auto")
    bench.add_argument("--rasterizer", choices=("auto", "shaders", "kernels"), default="auto")
    bench.add_argument("--image", type=Path, help="photo for generate; default: the bundled picture")
    models = verbs.add_parser("models", help="backends and what they add")
    models.add_argument("action", choices=("list", "check"))


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: without the program name; ``sys.argv`` by default.

    Returns:
        0 done; 2 bad usage or input; 3 the worker failed; 130 interrupted.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or (words[0] not in VERBS and not words[0].startswith("-")):
        words.insert(0, "open")
    try:
        return run(build_parser().parse_args(words))
    except WzError as error:
        sys.stderr.write(f"error: {error.line()}\n")
        return error.exit_status
    except KeyboardInterrupt:
        sys.stderr.write("error: interrupted.\n")
        return INTERRUPTED
    except BrokenPipeError:
        return 0


def run(options: argparse.Namespace) -> int:
    """Dispatches to the verb's module, which is imported only now."""
    import importlib

    module = importlib.import_module(f"wzviewer.commands.{options.verb}")
    status = module.run(options)
    return 0 if status is None else int(status)
