"""What this package says where it cannot do what it is asked."""


class DuctileError(Exception):
    """Results that are not there, that cannot be read, or from which what is asked does not follow.

    Its text is one line that says what is wrong with which file or series.
    """
