"""``wzviewer info``: what a scene holds."""

import argparse
import json
import sys
from typing import Any

from wzviewer import __version__
from wzviewer.core.files import load_scene
from wzviewer.core.scene import Level, Scene


def run(options: argparse.Namespace) -> None:
    """Prints a table, or one JSON object."""
    scene = load_scene(options.scene)
    record = describe(scene)
    if options.json:
        sys.stdout.write(json.dumps(record) + "\n")
        return
    _print_table(record)


def describe(scene: Scene) -> dict[str, Any]:
    """Returns the record that ``info --json`` prints."""
    levels = [_describe_level(scene, level) for level in scene]
    return {"version": __version__, "surfels": scene.num_surfels, "levels": levels}


def _describe_level(scene: Scene, level: Level) -> dict[str, Any]:
    return {
        "index": level.index,
        "parent": level.parent,
        "prompt": level.prompt,
        "surfels": len(level.surfels),
        "focal_px": level.camera.focal_px,
        "magnification": scene.magnification(level.index),
        "image": [level.camera.width, level.camera.height],
        "hidden": not scene.is_visible(level.index),
        "stages": {k: {"backend": s.backend, "seconds": s.seconds} for k, s in level.stages.items()},
    }


def _print_table(record: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{record['surfels']:,} surfels, {len(record['levels'])} levels")
    for name in ("level", "parent", "magnification", "image", "surfels", "seconds", "prompt"):
        table.add_column(name, justify="left" if name == "prompt" else "right")
    for level in record["levels"]:
        seconds = sum(s["seconds"] for s in level["stages"].values())
        size = "x".join(str(s) for s in level["image"])
        parent = "" if level["parent"] is None else str(level["parent"])
        cells = (str(level["index"]), parent, f"x{level['magnification']:g}", size)
        table.add_row(*cells, f"{level['surfels']:,}", f"{seconds:.1f}", level["prompt"])
    Console().print(table)
