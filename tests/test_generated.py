import pytest
from generated import write_or_check

PAGE = "above\n<!-- sums -->\nold\n<!-- end of sums -->\nbelow\n"


@pytest.fixture
def page(tmp_path):
    path = tmp_path / "page.md"
    path.write_text(PAGE)
    return path


def test_the_part_between_the_marks_is_written_and_nothing_else(page):
    assert write_or_check(page, "sums", "new\n", []) == 0
    assert page.read_text() == PAGE.replace("old", "new")


def test_a_check_writes_nothing(page):
    assert write_or_check(page, "sums", "new\n", ["--check"]) == 1
    assert page.read_text() == PAGE
    assert write_or_check(page, "sums", "old\n", ["--check"]) == 0


def test_a_page_without_the_marks_is_refused(page):
    with pytest.raises(ValueError, match="marks `others`"):
        write_or_check(page, "others", "new\n", ["--check"])
