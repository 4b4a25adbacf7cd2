import pytest

from wzviewer.core import constants
from wzviewer.gl.shader import ShaderError, load_program, load_source


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "include").mkdir()
    (tmp_path / "include" / "half.glsl").write_text("float half_of(float x) {\n    return 0.5 * x;\n}\n")
    (tmp_path / "plain.vert").write_text("void main() {\n    gl_Position = vec4(0.0);\n}\n")
    return tmp_path


def fragment(folder, body):
    (folder / "test.frag").write_text(
        f'#include "half.glsl"\n#include "half.glsl"\nout vec4 out_color;\n{body}\n'
    )
    return "test.frag"


def test_constants_reach_the_shader():
    text = load_source("surfel.frag").text
    assert f"#define ALPHA_MAX {constants.ALPHA_MAX!r}" in text
    assert text.startswith("#version 330 core")


def test_an_include_comes_once_and_lines_are_kept(folder):
    source = load_source(fragment(folder, "void main() {}"), {"FLAG": True, "OFF": False, "N": 3}, folder)
    assert source.files == ["test.frag", "include/half.glsl"]
    assert source.text.count("half_of") == 1
    assert "#define FLAG\n" in source.text
    assert "#define N 3" in source.text
    assert "OFF" not in source.text
    assert "#line 3 0\nout vec4 out_color;" in source.text


def test_a_mistake_in_a_file_is_named_by_file_and_line(gl_context, folder):
    name = fragment(folder, "void main() {\n    out_color = vec4(half_of(1.0)) + nonsense;\n}")
    with pytest.raises(ShaderError) as caught:
        load_program(gl_context.ctx, "plain.vert", name, root=folder)
    assert "test.frag:5: error" in str(caught.value)
    assert "nonsense" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_mistake_in_an_include_is_named_by_its_own_line(gl_context, folder):
    (folder / "include" / "half.glsl").write_text("float half_of(float x) {\n    return wrong * x;\n}\n")
    name = fragment(folder, "void main() {\n    out_color = vec4(half_of(1.0));\n}")
    with pytest.raises(ShaderError, match=r"include/half\.glsl:2: error.*wrong"):
        load_program(gl_context.ctx, "plain.vert", name, root=folder)


def test_a_working_program_is_returned(gl_context, folder):
    name = fragment(folder, "void main() {\n    out_color = vec4(half_of(1.0));\n}")
    program = load_program(gl_context.ctx, "plain.vert", name, root=folder)
    program.release()
