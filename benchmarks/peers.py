"""Times wzviewer and other surfel viewers on the same scenes, camera and software OpenGL.

    python benchmarks/peers.py --json > peers.json

One program after another, never two at once.  What is not installed is named and left out;
`benchmarks/README.md` says how to install it and what differs between the programs.
"""

import argparse
import contextlib
import datetime
import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scenes import SCENES, SceneSpec, write_scene

HERE = Path(__file__).resolve().parent
TIMEOUT_S = 320.0  # of one program on one scene
GRACE_S = 15.0  # after SIGTERM, so that a driver takes its browser down
BLOCK_PX = 16  # pictures are compared by the means of such blocks: splats are smaller
# Grey levels.  Measured: 0.2 to 2.1 between the programs, 3.5 for GaussianSplats3D, whose order may be
# 8 degrees old; 6.8 and more for a picture that is shifted by a block, 20 for a mirrored one.
DIFFERENCE_MAX = 6.0
CHROMIUM_NAMES = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome")

Record = dict[str, Any]


@dataclass(frozen=True)
class Plan:
    """What to run.

    Attributes:
        work: folder of the installed peers, the scenes and the pictures.
        runs: per program and scene.
        frames: per run.
        warm: frames before the first run that are not counted.
        chromium: its path, or None where there is none.
    """

    work: Path
    runs: int
    frames: int
    warm: int
    chromium: str | None

    @property
    def lengths(self) -> list[str]:
        """As arguments."""
        return ["--runs", str(self.runs), "--frames", str(self.frames), "--warm", str(self.warm)]

    @property
    def f3d_python(self) -> Path:
        """The interpreter that has f3d."""
        return self.work / "venv" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


@dataclass(frozen=True)
class Program:
    """A renderer that can be timed.

    Attributes:
        name: on the command line and in the JSON.
        label: in the table.
        missing: says what is not installed, or returns None.
        command: argument list without scene, lengths and picture.
        needs_display: whether it needs an X server.
    """

    name: str
    label: str
    missing: Callable[[Plan], str | None]
    command: Callable[[Plan], list[str]]
    needs_display: bool = False


# ------------------------------------------------------------------ programs


def _ours() -> Program:
    def command(plan: Plan) -> list[str]:
        return [sys.executable, str(HERE / "ours.py")]

    return Program("ours", "wzviewer", lambda plan: None, command)


def _browser_peer(name: str, label: str, package: str) -> Program:
    def missing(plan: Plan) -> str | None:
        for tool, what in (("node", "Node.js 20"), ("Xvfb", "the package xvfb")):
            if shutil.which(tool) is None:
                return f"{tool} is not installed ({what})"
        if plan.chromium is None:
            return "Chromium is not installed (the package chromium)"
        web = plan.work / "web"
        for needed in (package, "puppeteer-core", "esbuild"):
            if not (web / "node_modules" / needed / "package.json").is_file():
                return f"npm package {needed} is not in {web / 'node_modules'}"
        return None

    def command(plan: Plan) -> list[str]:
        assert plan.chromium is not None  # missing() says so
        return ["node", str(plan.work / "web" / "driver.mjs"), name, "--chromium", plan.chromium]

    return Program(name, label, missing, command, needs_display=True)


def _f3d() -> Program:
    def missing(plan: Plan) -> str | None:
        if not plan.f3d_python.is_file():
            return f"f3d is not installed: no {plan.f3d_python}"
        probe = subprocess.run([plan.f3d_python, "-c", "import f3d"], capture_output=True, check=False)
        return "f3d does not import in its environment" if probe.returncode else None

    def command(plan: Plan) -> list[str]:
        return [str(plan.f3d_python), str(HERE / "f3d_peer.py")]

    return Program("f3d", "f3d", missing, command)


PROGRAMS = (
    _ours(),
    _browser_peer("playcanvas", "PlayCanvas", "playcanvas"),
    _browser_peer("gaussiansplats3d", "GaussianSplats3D", "@mkkellogg/gaussian-splats-3d"),
    _browser_peer("spark", "Spark", "@sparkjsdev/spark"),
    _f3d(),
)


# ------------------------------------------------------------------ running


@contextlib.contextmanager
def display() -> Iterator[str]:
    """Runs a virtual X server; yields its name."""
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, pass_fds=[write], stderr=subprocess.DEVNULL) as server:
        os.close(write)
        try:
            with os.fdopen(read) as pipe:
                yield f":{pipe.readline().strip()}"
        finally:
            server.terminate()


def run_program(program: Program, spec: SceneSpec, plan: Plan) -> Record:
    """Runs one program on one scene.

    Returns:
        What it printed, or ``{"error": ...}``.
    """
    picture = picture_path(plan, program, spec)
    picture.unlink(missing_ok=True)
    files = ["--scene", spec.name, "--scenes", str(plan.work / "scenes"), "--picture", str(picture)]
    command = [*program.command(plan), *files, *plan.lengths]
    environment = os.environ | {"LIBGL_ALWAYS_SOFTWARE": "1", "PYTHONPATH": str(HERE.parent)}
    with contextlib.ExitStack() as stack:
        if program.needs_display:
            environment["DISPLAY"] = stack.enter_context(display())
        code, out, errors = _communicate(command, environment)
    lines = out.strip().splitlines()
    if code != 0 or not lines:
        reason = (errors.strip() or "no output").splitlines()[-1][:300]
        return {"error": f"exit status {code}: {reason}"}
    try:
        return dict(json.loads(lines[-1]))
    except ValueError:
        return {"error": f"printed no JSON: {lines[-1][:300]}"}


def _communicate(command: list[str], environment: dict[str, str]) -> tuple[int, str, str]:
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=environment) as process:
        try:
            out, errors = process.communicate(timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGTERM)
            try:
                process.communicate(timeout=GRACE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
            return -1, "", f"stopped after {TIMEOUT_S:.0f} s"
        return process.returncode, out, errors


def prepare(plan: Plan, specs: list[SceneSpec]) -> None:
    """Writes the scenes, and puts the pages beside the installed npm packages."""
    for spec in specs:
        write_scene(plan.work / "scenes", spec)
    (plan.work / "pictures").mkdir(parents=True, exist_ok=True)
    web = plan.work / "web"
    shutil.copytree(
        HERE / "web", web, dirs_exist_ok=True, ignore=shutil.ignore_patterns("node_modules", "package*.json")
    )


def picture_path(plan: Plan, program: Program, spec: SceneSpec) -> Path:
    """Where a program's frame is saved."""
    return plan.work / "pictures" / f"{program.name}-{spec.name}.png"


# ------------------------------------------------------------------ results


def summary(record: Record) -> Record:
    """Median and 95th percentile over the frames of all runs."""
    if "error" in record:
        return record
    runs = [np.asarray(run, np.float64) for run in record["runs_ms"]]
    frames = np.concatenate(runs)
    result: Record = {
        "median_ms": round(float(np.median(frames)), 1),
        "p95_ms": round(float(np.percentile(frames, 95)), 1),
        "run_medians_ms": [round(float(np.median(run)), 1) for run in runs],
        "num_frames": len(frames),
    }
    if "intervals_ms" in record:
        intervals = np.concatenate([np.asarray(run, np.float64) for run in record["intervals_ms"]])
        result["interval_median_ms"] = round(float(np.median(intervals)), 1)
    kept = ("load_ms", "renderer", "size_px", "num_visible", "gpu_bytes")
    return result | {key: record[key] for key in kept if key in record}


def block_means(path: Path) -> NDArray[np.float64]:
    """Means of the blocks of a picture, (h, w, 3) grey levels."""
    import cv2

    image = cv2.imread(str(path), cv2.IMREAD_COLOR) if path.is_file() else None
    if image is None:
        raise ValueError(f"no picture at {path}")
    height, width = (side - side % BLOCK_PX for side in image.shape[:2])
    blocks = image[:height, :width].reshape(height // BLOCK_PX, BLOCK_PX, width // BLOCK_PX, BLOCK_PX, 3)
    return np.asarray(blocks.mean(axis=(1, 3), dtype=np.float64))


def picture_difference(path: Path, reference: Path) -> float | None:
    """Mean difference of two pictures by blocks, grey levels; None where one of them is missing."""
    try:
        first, second = block_means(path), block_means(reference)
    except ValueError:
        return None
    return float(np.abs(first - second).mean()) if first.shape == second.shape else float("inf")


def check_picture(result: Record, program: Program, spec: SceneSpec, plan: Plan) -> None:
    """Adds whether the program drew the scene: a time without the picture is void."""
    if "error" in result:
        return
    picture = picture_path(plan, program, spec)
    difference = picture_difference(picture, picture_path(plan, PROGRAMS[0], spec))
    result["picture"] = str(picture)
    result["picture_difference"] = None if difference is None else round(difference, 2)
    result["void"] = void_reason(result, program, picture.is_file())


def void_reason(result: Record, program: Program, has_picture: bool) -> str | None:
    """Why a time does not count, or None."""
    if not has_picture:
        return "no picture"
    if "llvmpipe" not in result["renderer"] and program.name != "f3d":  # f3d cannot say
        return f"drawn by {result['renderer']}"
    difference = result["picture_difference"]
    if difference is None:
        return "its picture was not compared: there is none of wzviewer"
    return None if difference < DIFFERENCE_MAX else "another picture"


def measure(programs: list[Program], specs: list[SceneSpec], plan: Plan) -> Record:
    """Runs everything, one after another."""
    results: Record = {}
    for program in programs:
        entry: Record = {"label": program.label}
        results[program.name] = entry
        absent = program.missing(plan)
        if absent is not None:
            entry["absent"] = absent
            _say(f"{program.name}: skipped, {absent}")
            continue
        entry["scenes"] = {}
        for spec in specs:
            record = run_program(program, spec, plan)
            entry |= {key: record[key] for key in ("version", "browser") if key in record}
            result = entry["scenes"][spec.name] = summary(record)
            check_picture(result, program, spec, plan)
            _say(f"{program.name} {spec.name}: {_cell(result)}")
    return results


def machine() -> Record:
    """Processor, cores, system, date and how busy the machine is."""
    name = platform.processor() or platform.machine()
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next((ln.split(":", 1)[1].strip() for ln in lines if ln.startswith("model name")), name)
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    system = f"{platform.system()} {platform.release()}"
    return {"processor": name, "cores": os.cpu_count(), "system": system, "date": now, "load_average": load}


# ------------------------------------------------------------------ output


def _say(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()


def _cell(result: Record) -> str:
    if "error" in result:
        return f"failed, {result['error']}"
    void = f" (void: {result['void']})" if result["void"] else ""
    return f"{result['median_ms']:.0f} / {result['p95_ms']:.0f}{void}"


def table(report: Record) -> str:
    """A Markdown table: median / 95th percentile of the frame time, ms."""
    names = list(report["scenes"])
    lines = [
        "| program | " + " | ".join(f"{name}, ms" for name in names) + " |",
        "|---" * (len(names) + 1) + "|",
    ]
    for entry in report["programs"].values():
        title = f"{entry['label']} {entry.get('version', '')}".strip()
        cells = [_cell(entry["scenes"][n]) for n in names] if "scenes" in entry else ["absent"] * len(names)
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def read_options(arguments: list[str] | None = None) -> argparse.Namespace:
    """Reads the command line."""
    names = [program.name for program in PROGRAMS]
    parser = argparse.ArgumentParser(
        description="Times wzviewer beside other viewers; see benchmarks/README.md."
    )
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument(
        "--only", nargs="+", choices=names, default=names, metavar="NAME", help=", ".join(names)
    )
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES), metavar="SCENE")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--frames", type=int, default=8, help="per run")
    parser.add_argument(
        "--warm", type=int, default=3, help="frames before the first run that are not counted"
    )
    default = Path(tempfile.gettempdir()) / "peers"
    parser.add_argument(
        "--work", type=Path, default=default, help="folder of the installed peers (%(default)s)"
    )
    parser.add_argument("--chromium", default=None, help="path of the browser")
    return parser.parse_args(arguments)


def main() -> None:
    """Runs the comparison."""
    options = read_options()
    chromium = options.chromium or next(filter(None, map(shutil.which, CHROMIUM_NAMES)), None)
    plan = Plan(options.work.resolve(), options.runs, options.frames, options.warm, chromium)
    specs = [SCENES[name] for name in options.scenes]
    programs = [program for program in PROGRAMS if program.name in options.only]
    started = machine()
    prepare(plan, specs)
    report: Record = {
        "machine": started,
        "plan": {"runs": plan.runs, "frames": plan.frames, "warm": plan.warm},
        "scenes": {s.name: {"num_surfels": s.num_surfels, "diameter_px": s.diameter_px} for s in specs},
        "programs": measure(programs, specs, plan),
    }
    sys.stdout.write((json.dumps(report, indent=1) if options.json else table(report)) + "\n")


if __name__ == "__main__":
    main()
