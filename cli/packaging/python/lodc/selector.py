"""What a level is asked for by: numbers, or text as on the command line."""

import math
from dataclasses import dataclass
from numbers import Integral, Real

TargetValue = int | float | str | None
"""A number, or text such as ``"10%"``, ``"10k"``."""

SCALES = {"k": 1_000, "m": 1_000_000}


@dataclass(frozen=True)
class Selector:
    """One of ``lod``, ``ratio``, ``triangles``, ``error``, ``rms``, and its number; ``percent`` of
    an error that is a share of the diagonal."""

    name: str
    value: float
    percent: bool = False

    def scaled(self, factor: float) -> "Selector":
        """With a distance in other units, of which one is ``factor`` of these."""
        if self.name not in ("error", "rms") or self.percent:
            return self
        return Selector(self.name, self.value / factor)

    def words(self) -> list[str]:
        """As options of the program."""
        share = self.value * 100 if self.percent else self.value
        number = int(share) if self.name in ("lod", "triangles") else share
        return [f"--{self.name}", f"{number!r}%" if self.percent else repr(number)]


def selector(**wishes: TargetValue) -> Selector:
    """The one that is given.

    Raises TypeError if none or several are, or if it is neither a number nor text, ValueError if it
    is no such number."""
    given = {name: wish for name, wish in wishes.items() if wish is not None}
    if len(given) != 1:
        names = ", ".join(wishes)
        said = " and ".join(given) or "none"
        raise TypeError(f"give exactly one of {names} (given: {said})")
    [(name, wish)] = given.items()
    if name in ("error", "rms"):
        value, percent = _number(name, wish)
        if value < 0 or math.isnan(value):
            raise ValueError(f"{name}={wish!r}: not a distance, such as 0.02 or '0.5%'")
        return Selector(name, value, percent)
    value, percent = _number(name, wish)
    if name == "ratio":
        if not 0 <= value <= 1:
            raise ValueError(f"ratio={wish!r}: not a share from 0 to 1, such as 0.25 or '25%'")
        return Selector(name, value)
    if percent or value < 0 or value != math.floor(value):
        example = "500 or '10k'" if name == "triangles" else "0"
        raise ValueError(f"{name}={wish!r}: not a whole number, such as {example}")
    return Selector(name, value)


def _number(name: str, wish: object) -> tuple[float, bool]:
    """A number, and whether it was given as a percentage."""
    if isinstance(wish, Integral) and not isinstance(wish, bool):
        return int(wish), False
    if isinstance(wish, Real) and not isinstance(wish, bool) and not math.isinf(wish):
        return float(wish), False
    if isinstance(wish, str):
        text = wish.strip().lower()
        scale = SCALES.get(text[-1:], 1) if name == "triangles" else 1
        percent = text.endswith("%")
        try:
            value = float(text[:-1] if percent or scale > 1 else text)
        except ValueError:
            pass
        else:
            if math.isfinite(value):
                return value / 100 if percent else value * scale, percent
    wrong = ValueError if isinstance(wish, (str, float)) else TypeError
    raise wrong(f"{name}={wish!r}: neither a number nor text that is one")
