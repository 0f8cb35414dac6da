"""Errors of files and of the program."""


class FormatError(ValueError):
    """A file breaks the rules of its format. Its text is ``FILE: PLACE: WHAT``."""

    def __init__(self, place: str, what: str, file: str = "") -> None:
        super().__init__(place, what, file)
        self.place, self.what, self.file = place, what, file

    def __str__(self) -> str:
        return ": ".join(part for part in (self.file, self.place, self.what) if part)


class LodcWarning(UserWarning):
    """Something was repaired, dropped or left out."""


class ProgramError(RuntimeError):
    """The program ``lodc`` came to nothing: what it said, and its exit ``status``."""

    def __init__(self, what: str, status: int) -> None:
        super().__init__(what)
        self.status = status


def need(holds: object, place: str, what: str) -> None:
    """Raises a :class:`FormatError` unless ``holds``."""
    if not holds:
        raise FormatError(place, what)
