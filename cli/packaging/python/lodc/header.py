"""The header that files and streams begin with."""

from .errors import FormatError, need

VERSION = 1
REQUIRED = 0x00FF


def check_header(data, magic, name, checksum, size):
    """Checks a whole header, the last ``size`` bytes of which are its checksum."""
    fields, check = bytes(data[8:-size]), int.from_bytes(data[-size:], "little")
    is_named, is_sound = data[:8] == magic, checksum(magic + fields) == check
    need(is_named or is_sound, "header", f"not a {name}")
    need(is_named and is_sound, "header", "the header is damaged (checksum)")
    version, features = (int.from_bytes(fields[i : i + 2], "little") for i in (0, 2))
    if version != VERSION:
        raise FormatError("header", f"version {version}: this reader reads version {VERSION}")
    features &= REQUIRED
    need(not features, "header", f"features {features:#x}: this reader knows none")
