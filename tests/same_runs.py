"""Simulations compared to the last bit."""

from dataclasses import is_dataclass

from numpy.testing import assert_array_equal

from celltrain import Run


def assert_same_place(one: Run, other: Run) -> None:
    """State and memory of the method are equal to the last bit."""
    for mine, theirs in ((one.state, other.state), (one.memory, other.memory)):
        assert_same_parts(mine, theirs)


def assert_same_parts(one: object, other: object) -> None:
    """All numbers of two records, and of the records in them, are equal to the last bit."""
    assert type(one) is type(other)
    for name, value in vars(one).items():
        if is_dataclass(value):
            assert_same_parts(value, getattr(other, name))
        else:
            assert_array_equal(value, getattr(other, name), err_msg=name)


def assert_same(one: Run, other: Run) -> None:
    """Equal to the last bit, but for the wall time."""
    assert_same_place(one, other)
    for name, column in one.history.items():
        if name != "wall_seconds":
            assert_array_equal(column, other.history[name], err_msg=name)
    assert_array_equal(one.times, other.times)
    assert_array_equal(one.shapes, other.shapes)
    assert one.frames.keys() == other.frames.keys()
    for name, column in one.frames.items():
        assert_array_equal(column, other.frames[name], err_msg=name)
