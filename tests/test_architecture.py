"""The house plan, held by tests: who imports whom, and what the README promises."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "wzviewer"
HEAVY = {"torch", "moderngl", "glfw", "imgui_bundle", "cv2", "numba", "scipy", "rich", "safetensors"}


def modules(folder):
    return sorted((PACKAGE / folder).rglob("*.py"))


def imported(path, everywhere=True):
    """Names of modules that a file imports, at its top level or everywhere."""
    tree = ast.parse(path.read_text("utf-8"))
    nodes = ast.walk(tree) if everywhere else tree.body
    names = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
    return names


def outside(path, everywhere):
    names = imported(path, everywhere)
    return {n.split(".")[0] for n in names} & (HEAVY | {"imageio_ffmpeg", "platformdirs"})


def inside(path):
    """Modules of wzviewer that a file imports, as ``package.module``."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("wzviewer"):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {".".join(n.split(".")[1:3]) for n in names}
    return found


def test_core_imports_numpy_and_the_standard_library_only():
    for path in modules("core"):
        assert outside(path, everywhere=False) == set(), path
        # Codecs of files and photos are imported inside the functions that need them.
        assert outside(path, everywhere=True) <= {"cv2", "safetensors"}, path
        assert all(name.startswith(("core", "errors")) for name in inside(path)), path


def test_only_gl_calls_opengl():
    for path in modules("."):
        if "moderngl" in outside(path, everywhere=True):
            assert path.is_relative_to(PACKAGE / "gl") or path.is_relative_to(PACKAGE / "app"), path


def test_gl_knows_neither_worker_nor_app():
    for path in modules("gl"):
        assert not any(name.startswith(("worker", "app", "commands")) for name in inside(path)), path
        assert not outside(path, everywhere=True) & {"torch", "numba", "cv2"}, path


def test_kernels_know_core_only():
    for path in modules("kernels"):
        assert all(name.startswith(("core", "kernels")) for name in inside(path)), path
        assert outside(path, everywhere=True) <= {"numba", "numpy"} | set(sys.stdlib_module_names), path


def test_worker_never_imports_gl_nor_app():
    for path in modules("worker"):
        assert not any(name.startswith(("gl", "app", "commands")) for name in inside(path)), path
        assert not outside(path, everywhere=True) & {"moderngl", "glfw", "imgui_bundle"}, path


def test_the_app_never_imports_torch_nor_the_models():
    for path in modules("app"):
        assert not outside(path, everywhere=True) & {"torch", "numba"}, path
        allowed = ("core", "gl", "app", "errors", "config", "worker.client", "commands", "__version__")
        assert all(name.startswith(allowed) for name in inside(path)), path


def test_imgui_is_imported_before_glfw():
    for path in modules("."):
        text = path.read_text("utf-8")
        if re.search(r"^import glfw", text, re.M):
            assert text.index("imgui_bundle") < text.index("import glfw"), path


@pytest.mark.parametrize(
    ("module", "forbidden"),
    [
        ("wzviewer", HEAVY | {"numpy"}),
        ("wzviewer.cli", HEAVY | {"numpy"}),
        ("wzviewer.core.files", HEAVY),
        ("wzviewer.worker.client", {"torch", "moderngl", "numba"}),
        ("wzviewer.gl.renderer", {"torch", "numba", "cv2"}),
    ],
)
def test_imports_stay_light(module, forbidden):
    code = f"import sys, {module}; print(*{{m.split('.')[0] for m in sys.modules}})"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert not forbidden & set(loaded.stdout.split())


def test_files_stay_short_and_well_named():
    folders = ("assets", "benchmarks", "training")
    scripts = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    for path in [*modules("."), *scripts]:
        assert len(path.read_text("utf-8").splitlines()) <= 400, path
        assert path.stem not in {"utils", "helpers", "common", "misc", "manager"}, path


def test_no_global_no_bare_except_no_eval():
    for path in modules("."):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            assert not isinstance(node, ast.Global), path
            assert not (isinstance(node, ast.ExceptHandler) and node.type is None), path
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in {"eval", "exec"}, path
            if isinstance(node, ast.Import):
                assert not {"pickle", "marshal", "shelve"} & {a.name for a in node.names}, path


def readme_table():
    text = (ROOT / "README.md").read_text("utf-8")
    return re.findall(r"^\| ([\d, –-]+) \| .* \| `([\w/.]+)` \| `(\w+)` \|$", text, re.M)


def test_the_table_of_the_readme_names_files_and_functions_that_exist():
    rows = readme_table()
    assert len(rows) >= 10
    for _, path, symbol in rows:
        tree = ast.parse((ROOT / path).read_text("utf-8"))
        names = {n.name for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.ClassDef)}
        assert symbol in names, (path, symbol)


def test_the_readme_has_exactly_two_commands():
    text = (ROOT / "README.md").read_text("utf-8")
    assert len(re.findall(r"^```sh$", text, re.M)) == 2
