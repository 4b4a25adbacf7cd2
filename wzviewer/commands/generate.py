"""``wzviewer generate``: photo -> scene, without a window."""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from wzviewer.commands.generation import Timings, generate_scene
from wzviewer.commands.info import describe
from wzviewer.commands.progress import Progress
from wzviewer.config import Generation, parse_size, read_script
from wzviewer.core.files import save_scene
from wzviewer.core.photos import check_writable
from wzviewer.core.scene import Scene
from wzviewer.errors import InputError


def run(options: argparse.Namespace) -> None:
    """Makes the scene and writes it whole."""
    plan = plan_of(options)
    check_writable(options.output)
    with Progress(silent=options.json) as progress:
        scene, timings = generate_scene(plan, progress)
        save_scene(scene, options.output)
        progress.line(f"wrote {options.output}: {len(scene)} levels, {scene.num_surfels:,} surfels")
    if options.json:
        sys.stdout.write(json.dumps(report(scene, timings, options.output)) + "\n")


def plan_of(options: argparse.Namespace) -> Generation:
    """Joins the command line and the script; the command line wins.

    Raises:
        InputError: when no image is given, or both name zooms.
    """
    found: dict[str, Any] = read_script(options.script) if options.script else {}
    if options.zoom and found.get("zooms"):
        raise InputError("--zoom", "the script has zooms as well", "Use one of them.")
    if options.image is not None:
        found["image"] = options.image
    if options.zoom:
        found["zooms"] = tuple(options.zoom)
    if options.seed is not None:
        found["seed"] = options.seed
    if "image" not in found:
        raise InputError("generate", "no image given", "wzviewer generate IMAGE -o SCENE.wz")
    if found.get("seed", 0) < 0:
        raise InputError(f"--seed {found['seed']}", "must not be negative")
    size = parse_size(options.size) if options.size else None
    return Generation(synthesizer=options.synthesizer, size=size, **found)


def report(scene: Scene, timings: Timings, path: Path) -> dict[str, Any]:
    """Returns the record that ``generate --json`` prints."""
    record = describe(scene)
    for level, seconds, preview in zip(
        record["levels"], timings.seconds, timings.first_preview_seconds, strict=True
    ):
        level["seconds"], level["first_preview_seconds"] = seconds, preview
    return {**record, "seconds": sum(timings.seconds), "bytes": path.stat().st_size}
