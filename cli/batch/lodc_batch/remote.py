"""Files at URLs, by `fsspec`: `s3://`, `gs://`, `az://`, `https://` and what else is installed."""

import json
import os
import re
from pathlib import Path
from urllib.parse import unquote


def is_url(name):
    """Returns whether a name is a URL, not a path."""
    return re.match(r"[a-z][a-z0-9+.-]+://", name) is not None


def system(url):
    """Returns the file system of a URL, and the path there."""
    try:
        import fsspec
    except ImportError:
        raise ImportError("URLs need fsspec: pip install 'lodc-batch[urls]'")
    return fsspec.core.url_to_fs(url)


def name(url):
    """Returns the last part of a URL or path, without what asks a server."""
    return unquote(re.split(r"[?#]", url)[0].rstrip("/").rsplit("/", 1)[-1])


def size(url):
    """Returns the bytes of a file; 0 if its place does not say."""
    try:
        files, path = system(url)
        return files.info(path).get("size") or 0
    except Exception:
        # The build will fail and say why.
        return 0


def tag(url):
    """Returns what a place says of a file, for telling that it has changed."""
    try:
        files, path = system(url)
        return str(files.ukey(path))
    except Exception:
        return ""


def fetch(url, folder):
    """Copies an asset and the files that it refers to into a folder.

    Returns their paths, the asset first. A file that is not there is left out: `lodc` says so.
    """
    folder.mkdir(parents=True)
    if not is_url(url):
        url = Path(url).resolve().as_uri()
    files, path = system(url)
    base = path.rsplit("/", 1)[0]
    fetched, queue = [], [name(url)]
    for relative in queue:
        to = folder / relative
        if to.resolve() != to or to in fetched:
            continue
        to.parent.mkdir(parents=True, exist_ok=True)
        place = path if not fetched else f"{base}/{relative}"
        try:
            files.get_file(place, str(to))
        except FileNotFoundError:
            if not fetched:
                raise
            continue
        fetched.append(to)
        queue += references(to)
    return fetched


def references(path):
    """Returns the relative paths that a glTF, OBJ or MTL file names, below its own folder."""
    kind = path.suffix.lower()
    if kind == ".gltf":
        try:
            document = json.loads(path.read_bytes())
            entries = [*document.get("buffers", []), *document.get("images", [])]
            names = [unquote(entry["uri"]) for entry in entries if "uri" in entry]
        except (ValueError, TypeError, AttributeError):
            return []
    elif kind in (".obj", ".mtl"):
        words = [line.split() for line in path.read_text(errors="replace").splitlines()]
        named = [w for w in words if len(w) > 1]
        wanted = r"mtllib" if kind == ".obj" else r"(?i)map_\w+|bump|disp|decal|refl|norm"
        names = [w[-1].replace("\\", "/") for w in named if re.fullmatch(wanted, w[0])]
    else:
        return []
    outside = lambda n: is_url(n) or n.startswith(("/", "data:")) or ".." in n.split("/")
    return [os.path.normpath(n) for n in names if not outside(n)]


def read(url):
    """Returns the bytes of a small file; none if it is not there."""
    try:
        files, path = system(url)
        return files.cat_file(path)
    except FileNotFoundError:
        return None


def put(path, url):
    """Copies a file to a URL or path; there it appears whole or not at all."""
    if not is_url(url):
        Path(url).parent.mkdir(parents=True, exist_ok=True)
        beside = Path(f"{url}.part")
        beside.write_bytes(Path(path).read_bytes())
        os.replace(beside, url)
        return
    files, to = system(url)
    files.makedirs(to.rsplit("/", 1)[0], exist_ok=True)
    # An object store shows an object once its upload is complete.
    files.put_file(str(path), to)


def write(url, data):
    """Writes a small file to a URL or path."""
    if not is_url(url):
        Path(url).write_bytes(data)
        return
    files, to = system(url)
    files.pipe_file(to, data)
