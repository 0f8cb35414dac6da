"""C that `cc` compiles once."""

import ctypes
import hashlib
import os
import pathlib
import subprocess
import tempfile


def compiled(source):
    """The functions of a file. Infinities and signed zeros count as other numbers do."""
    words = ["cc", "-std=gnu11", "-O3", "-march=native", "-ffinite-math-only", "-fno-signed-zeros"]
    words += ["-fno-math-errno", "-shared", "-fPIC", str(source), "-lm"]
    made_from = source.read_bytes() + " ".join(words).encode()
    name = f"lodc-{source.stem}-{hashlib.sha256(made_from).hexdigest()[:16]}.so"
    path = pathlib.Path(tempfile.gettempdir()) / name
    if not path.exists():
        # Several processes may do so at once: each renames a file of its own.
        made = path.with_suffix(f".{os.getpid()}")
        subprocess.run([*words, "-o", made], check=True)
        made.rename(path)
    return ctypes.CDLL(str(path))
