"""The bundled picture and its depth: what they promise, and that the script still makes them.

The script makes equal bytes in equal runs; a second run to show it costs 20 s and is left out.
"""

import importlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest

ASSETS = Path(__file__).parents[1] / "assets"


README = ASSETS.parent / "README.md"


@pytest.fixture(scope="module")
def picture() -> np.ndarray:
    stored = cv2.imread(str(ASSETS / "meadow.png"), cv2.IMREAD_UNCHANGED)
    assert stored is not None
    return stored[..., ::-1]


@pytest.fixture(scope="module")
def truth() -> dict[str, np.ndarray]:
    with np.load(ASSETS / "meadow_depth.npz", allow_pickle=False) as stored:
        return {name: stored[name] for name in ("depth", "sky")}


@pytest.fixture(scope="module")
def script() -> Iterator[ModuleType]:
    sys.path.insert(0, str(ASSETS))  # as when it runs as a script
    yield importlib.import_module("make_meadow")
    sys.path.remove(str(ASSETS))


def test_sizes_types_and_weight(picture, truth):
    assert picture.shape == (720, 1088, 3)
    assert picture.dtype == np.uint8
    assert truth["depth"].shape == truth["sky"].shape == (720, 1088)
    assert truth["depth"].dtype in (np.float16, np.float32)
    assert truth["sky"].dtype == np.bool_
    assert (ASSETS / "meadow.png").stat().st_size <= 1.8e6  # 1.35e6
    assert (ASSETS / "meadow_depth.npz").stat().st_size <= 1.5e6  # 1.26e6


def test_picture_uses_its_range_and_does_not_burn_out(picture):
    luma = picture.mean(-1)
    assert np.percentile(luma, 0.5) < 45  # 18.7
    assert np.percentile(luma, 99) > 210  # 230
    assert np.mean(picture.min(-1) >= 254) < 0.002  # 0


def test_median_depth_is_one_and_sky_stands_behind_everything(truth):
    depth, sky = truth["depth"], truth["sky"]
    assert np.isfinite(depth).all()
    assert np.median(depth[~sky]) == pytest.approx(1.0, abs=1e-4)  # 0; rounding to 14 bits may cost 3e-5
    assert np.all(np.abs(depth[sky] - 36.7) < 2e-3)  # the same rounding: 7.8e-4
    assert 20 < depth[~sky].max() < 30  # 27.3
    assert 0.35 < depth[~sky].min() < 0.5  # the near flower: 0.449


def test_sky_is_above_and_near_things_are_below(truth):
    depth, sky = truth["depth"], truth["sky"]
    assert sky[:90].all()  # the highest tree begins at row 118
    assert not sky[330:].any()
    assert 0.15 < sky.mean() < 0.35  # 0.225
    assert np.median(depth[640:]) < 0.5 * np.median(depth[280:330])  # 0.75, 4.84


def test_near_flower_stands_clear_of_its_background(truth):
    depth = truth["depth"]
    head = depth[262:322, 292:352]
    assert head.max() < 0.52  # 0.490
    assert np.median(depth[200:420, 500:600]) > 3 * head.max()  # 6.06


def test_depth_never_blends_two_surfaces(truth):
    # Along the rim of the flower a mean of petal and sky would lie between 0.55 and the nearest hill or tree.
    above = truth["depth"][130:200, 150:450]
    between = (above > 0.6) & (above < 4.0)
    assert between.mean() == 0.0


def test_script_reproduces_the_picture(script, picture, truth):
    first, depth, sky = script.render_meadow(136, 90, 1, 7)
    assert depth.shape == sky.shape == (90, 136)
    small = cv2.resize(picture, (136, 90), interpolation=cv2.INTER_AREA).astype(np.float32)
    apart = np.abs(first.astype(np.float32) - small).mean()
    assert apart < 22.0  # 17.5, the noise of one sample; its mirror image gives 47.0
    nearest = truth["sky"][4::8, 4::8]
    assert np.mean(sky != nearest) < 0.02  # 0.0011


def test_the_readmes_pictures_are_there_and_light():
    pictures = sorted((ASSETS / "readme").iterdir())
    shown = re.findall(r"\(assets/readme/([^)]+)\)", README.read_text("utf-8"))
    assert sorted(shown) == [path.name for path in pictures]
    assert sum(path.stat().st_size for path in pictures) <= 1.5e6  # 0.31e6
    for path in pictures:
        assert cv2.imread(str(path)).shape == (800, 1280, 3)
