"""Errors of a file, with the place in it."""


class FormatError(Exception):
    """A file breaks the rules of its format. Its text is ``FILE: PLACE: WHAT``."""

    def __init__(self, place, what, file=""):
        super().__init__(place, what, file)
        self.place, self.what, self.file = place, what, file

    def __str__(self):
        return ": ".join(part for part in (self.file, self.place, self.what) if part)


def need(holds, place, what):
    """Raises a :class:`FormatError` unless ``holds``."""
    if not holds:
        raise FormatError(place, what)
