import pytest

from plantigrade.models.mjcf import read_mjcf


def test_text_is_read_again_after_an_error_of_the_allocator():
    said = []

    def read(xml):
        said.append(xml)
        if len(said) == 1:
            raise ValueError("XML Error: unknown error in attribute 'elevation'")
        return "model"

    assert read_mjcf(read, "<mujoco/>") == "model"
    assert said == ["<mujoco/>"] * 2


@pytest.mark.parametrize(
    ("problem", "times"),
    [("XML Error: unknown error in attribute 'elevation'", 2), ("XML Error: no such thing", 1)],
)
def test_an_error_that_stays_is_raised(problem, times):
    said = []

    def read(xml):
        said.append(xml)
        raise ValueError(problem)

    with pytest.raises(ValueError, match=problem):
        read_mjcf(read, "<mujoco/>")
    assert len(said) == times
