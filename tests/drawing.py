"""How many examples random tests draw."""

from hypothesis import settings


def examples(count):
    """All of them where they are drawn anew; a third, and always the same, in the run that everybody waits for."""
    return max(count // 3, 5) if settings().derandomize else count
