"""The page of exercises holds every one of them, posed and with what solves it."""

import re

import pytest

from docs.exercises_page import FOLDER, count, exercises, exercises_page, sources


def test_every_file_of_exercises_is_a_chapter():
    assert set(FOLDER.glob("test_*.py")) == set(sources())


@pytest.mark.parametrize("path", sources(), ids=lambda path: path.stem)
def test_an_exercise_is_posed_in_one_line_and_solved_by_the_package(path):
    for exercise in exercises(path):
        assert re.fullmatch(r"[^\n]+[.?]", exercise.poses), exercise.name
        assert exercise.functions, exercise.name


def test_the_page_has_a_row_for_each():
    assert len(re.findall(r"^\| \d+\.\d+ \|", exercises_page(), re.M)) == count()
