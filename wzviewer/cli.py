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
SYNONYMS = {"view": "open"}  # what people type, too
INTERRUPTED = 130
EXAMPLES = """examples:
  wzviewer photo.jpg                     opens it in the window
  wzviewer generate photo.jpg -o scene.wz --zoom .5,.4 --prompt "a ladybug"
  wzviewer render scene.wz -o zoom.mp4 --path zoom

wzviewer VERB --help says more about each."""


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
    parser = Parser(
        prog="wzviewer",
        description="One photograph becomes a 3D world that you can zoom into without end.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"wzviewer {__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", parser_class=Parser)
    _add_open(verbs)
    _add_demo(verbs)
    _add_generate(verbs)
    _add_render(verbs)
    _add_others(verbs)
    return parser


def _add_open(verbs: Any) -> None:  # noqa: ANN401
    command = verbs.add_parser(
        "open",
        help="open the window (also: wzviewer FILE, or wzviewer alone)",
        description="Opens the window on a photo, on a saved scene, or on its start page.",
        epilog="In the window: scroll zooms, drag looks around, Enter makes new detail, F1 shows all keys.",
    )
    command.add_argument(
        "file", nargs="?", type=Path, help="a photo (jpg, png, webp) or a scene (.wz); none: the start page"
    )


def _add_demo(verbs: Any) -> None:  # noqa: ANN401
    about = "make a scene, a picture and a film of three zooms into a bundled picture"
    command = verbs.add_parser("demo", help=about, description=f"{_sentence(about)} Then opens the scene.")
    out = Path("wzviewer-demo")
    command.add_argument(
        "--out", type=Path, default=out, metavar="DIR", help=f"folder for the files; default: {out}"
    )
    _add_seed(command, 0)
    command.add_argument("--no-window", action="store_true", help="write the files only")
    _add_json(command)


def _add_generate(verbs: Any) -> None:  # noqa: ANN401
    about = "make a scene from a photo, without a window"
    command = verbs.add_parser("generate", help=about, description=_sentence(about))
    command.add_argument("image", nargs="?", type=Path, help="the photo; not needed with --script")
    command.add_argument(
        "-o", "--output", type=Path, required=True, metavar="SCENE.wz", help="the scene to write"
    )
    command.add_argument(
        "--zoom",
        action=AppendZoom,
        metavar="X,Y[,FACTOR]",
        help="a new level, centred at these fractions of the one before (0,0 is upper left, 1,1 lower "
        "right), FACTOR times closer; default: 8; 1 extends the picture instead; may be repeated",
    )
    command.add_argument(
        "--prompt", action=PromptOfZoom, metavar="TEXT", help="what the --zoom before it should show"
    )
    command.add_argument(
        "--script", type=Path, metavar="FILE.toml", help="photo, zooms and prompts in a file instead"
    )
    _add_seed(command, None)
    command.add_argument(
        "--synthesizer",
        default="builtin",
        metavar="NAME",
        help="what makes the detail; see wzviewer models",
    )
    command.add_argument("--size", metavar="WxH", help="working size, px; default: long side 1088")
    _add_json(command)


def _add_render(verbs: Any) -> None:  # noqa: ANN401
    about = "make a picture or a film from a scene"
    command = verbs.add_parser("render", help=about, description=_sentence(about))
    command.add_argument("scene", type=Path, help="a .wz scene")
    command.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT.{png,mp4,gif}",
        help="the file to write; its ending says what it is",
    )
    command.add_argument(
        "--level", type=int, metavar="K", help="as level K sees it, 0 is the photo; default: the last level"
    )
    command.add_argument(
        "--magnify", type=float, default=1.0, metavar="F", help="so much closer than that; default: 1"
    )
    command.add_argument(
        "--orbit",
        type=float,
        default=0.0,
        metavar="DEG",
        help="look from so far to the side, degrees; of --path orbit: to either side",
    )
    command.add_argument("--camera", metavar="JSON", help="an exact view, as Ctrl C copies it in the window")
    command.add_argument("--size", metavar="WxH", help="px; default: the scene's own, of a GIF 640 at most")
    command.add_argument("--transparent", action="store_true", help="PNG without a background")
    command.add_argument(
        "--path",
        metavar="zoom|orbit|FILE.json",
        help="how the camera of a film moves: down through all levels, from side to side, or as a file of "
        "the window's timeline or of nerfstudio says; default of a film: zoom",
    )
    command.add_argument("--path-out", type=Path, metavar="FILE.json", help="also write the film's path")
    command.add_argument("--fps", type=float, help="frames per second; default: 24, GIF 20, or the file's")
    command.add_argument("--seconds", type=float, help="length of the film; default: the path's own")
    command.add_argument(
        "--blend",
        choices=("transmittance", "linear"),
        default="transmittance",
        help="how levels fade into each other; linear: as the paper, lets the background through",
    )
    command.add_argument("--no-modulation", action="store_true", help="no fading at all, for comparison")
    command.add_argument("--no-antialias", action="store_true", help="as the paper: fine detail flickers")
    command.add_argument("--depth", type=Path, metavar="OUT.npy", help="also write the depth, world units")
    _add_drawing(command)


def _add_others(verbs: Any) -> None:  # noqa: ANN401
    about = "show what a scene holds: levels, prompts, sizes, times"
    info = verbs.add_parser("info", help=about, description=_sentence(about))
    info.add_argument("scene", type=Path, help="a .wz scene")
    _add_json(info)
    about = "measure how fast and how exact this machine is"
    bench = verbs.add_parser("bench", help=about, description=_sentence(about))
    bench.add_argument("what", choices=BENCHES, help="what to measure")
    _add_json(bench)
    _add_drawing(bench)
    bench.add_argument("--image", type=Path, help="photo for generate; default: the bundled picture")
    about = "list what can make detail, and all that a prompt may ask for"
    models = verbs.add_parser("models", help=about, description=_sentence(about))
    models.add_argument("action", choices=("list", "check"), help="check: whether each can run here")


def _add_seed(command: Any, default: int | None) -> None:  # noqa: ANN401
    told = "another number gives other detail; the same one gives the same again; default: 0"
    command.add_argument("--seed", type=int, default=default, metavar="N", help=told)


def _add_json(command: Any) -> None:  # noqa: ANN401
    command.add_argument("--json", action="store_true", help="one JSON object on stdout, for programs")


def _add_drawing(command: Any) -> None:  # noqa: ANN401
    command.add_argument(
        "--context",
        choices=("auto", "egl", "osmesa", "window"),
        default="auto",
        help="where OpenGL comes from; auto finds one",
    )
    command.add_argument(
        "--rasterizer",
        choices=("auto", "shaders", "kernels"),
        default="auto",
        help="shaders: OpenGL; kernels: the processor, much faster where OpenGL is software",
    )


def _sentence(about: str) -> str:
    """A few words of a list, as a description."""
    return f"{about[:1].upper()}{about[1:]}."


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line.

    Args:
        arguments: without the program name; ``sys.argv`` by default.

    Returns:
        0 done; 2 bad usage or input; 3 the worker failed; 130 interrupted.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    words[:1] = [SYNONYMS.get(word, word) for word in words[:1]]
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
