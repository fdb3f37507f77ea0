"""What a solution shows of itself: report, picture and animation, as the terminal makes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import Proven
from helpers.page_checks import faults
from msgspec.structs import replace

from cramlite import Solution, UserError


@pytest.fixture(scope="module")
def solution(proven: Proven) -> Solution:
    return proven("grasp_one_thing")


@pytest.mark.heavy
def test_its_report_is_a_page_that_needs_no_other_file(solution: Solution, tmp_path: Path) -> None:
    page = solution.report(tmp_path / "deep" / "page.html").read_text("utf-8")
    assert faults(page) == [] and "The run" in page and "data:image/webp" in page
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["page.html"]


def test_its_pictures_are_of_the_moment_that_is_asked_for(solution: Solution) -> None:
    start, end = (solution.picture(at, (160, 120)) for at in (0.0, 1.0))
    assert start.shape == (120, 160, 3) and start.dtype == np.uint8
    assert np.abs(start.astype(float) - end).max() > 20, "nothing moved between start and end"
    with pytest.raises(UserError, match="from 0 to 1"):
        solution.picture(1.5)


@pytest.mark.heavy
def test_its_animation_is_written_in_the_format_of_the_suffix(solution: Solution, tmp_path: Path) -> None:
    from PIL import Image

    with Image.open(solution.animation(tmp_path / "run.gif")) as file:
        assert file.format == "GIF" and file.n_frames > 3  # type: ignore[attr-defined]
    with pytest.raises(UserError, match="exists already"):
        solution.animation(tmp_path / "run.gif")
    with pytest.raises(UserError, match=r"'\.gif'"):
        solution.animation(tmp_path / "run.giff")


def test_what_nobody_ran_cannot_be_drawn(solution: Solution, tmp_path: Path) -> None:
    bare = replace(solution, candidate=replace(solution.candidate, rollout=None))
    with pytest.raises(UserError, match="did not run here"):
        bare.animation(tmp_path / "run.gif")
    page = bare.report(tmp_path / "page.html").read_text("utf-8")
    assert "cannot be run here, so there is nothing to show" in page
