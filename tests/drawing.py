"""How many examples random tests draw."""

from hypothesis import settings


def examples(count):
    """All of them where they are drawn anew; half, and always the same, in the run that everybody waits for."""
    return max(count // 2, 5) if settings().derandomize else count
