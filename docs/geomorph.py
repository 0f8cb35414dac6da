"""Draws levels of a chain on their way to the next one as an animated PNG.

python3 geomorph.py LODC MESH OUT.png
The pictures are those of `lodc render`, one for each weight of the morph target `lodc:next`.
"""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

LEVELS = ["3000", "800", "200"]
STEPS = 6
EYE = "--eye 1.8,1.6,5 --target 0.25,0.75,0 --fovy 28".split()
VIEW = ["--size", "240x220", "--shading", "flat", "--wireframe", *EYE]


def chunks(png):
    """The chunks of a PNG: kind and content."""
    at = 8
    while at < len(png):
        (length,) = struct.unpack(">I", png[at : at + 4])
        yield png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        at += 12 + length


def chunk(kind, content):
    checked = kind + content
    return struct.pack(">I", len(content)) + checked + struct.pack(">I", zlib.crc32(checked))


def animated(pictures, milliseconds):
    """PNGs of one size as one that moves."""
    out, sequence = [b"\x89PNG\r\n\x1a\n"], 0
    for number, (picture, time) in enumerate(zip(pictures, milliseconds)):
        parts = list(chunks(picture))
        head = dict(parts)[b"IHDR"]
        if number == 0:
            out += [chunk(b"IHDR", head), chunk(b"acTL", struct.pack(">II", len(pictures), 0))]
        frame = struct.pack(">I", sequence) + head[:8]
        frame += struct.pack(">IIHHBB", 0, 0, time, 1000, 0, 0)
        out.append(chunk(b"fcTL", frame))
        sequence += 1
        for content in (content for kind, content in parts if kind == b"IDAT"):
            if number == 0:
                out.append(chunk(b"IDAT", content))
            else:
                out.append(chunk(b"fdAT", struct.pack(">I", sequence) + content))
                sequence += 1
    return b"".join(out + [chunk(b"IEND", b"")])


def main(lodc, mesh, target):
    pictures, times = [], []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        chain = folder / "chain.gltf"
        wanted = ["--separate", "--geomorph", "--levels", ",".join(LEVELS), "-q"]
        subprocess.run([lodc, "chain", mesh, "-o", chain, *wanted], check=True)
        for level in range(len(LEVELS)):
            path = folder / f"chain_LOD{level}.gltf"
            document = json.loads(path.read_text())
            steps = STEPS if level + 1 < len(LEVELS) else 1
            for step in range(steps):
                for entry in document["meshes"] if steps > 1 else []:
                    entry["weights"] = [step / steps]
                path.write_text(json.dumps(document))
                drawn = folder / "drawn.png"
                subprocess.run([lodc, "render", path, *VIEW, "-o", drawn, "-q"], check=True)
                pictures.append(drawn.read_bytes())
                times.append(700 if step == 0 else 120)
    pathlib.Path(target).write_bytes(animated(pictures, times))


main(*sys.argv[1:])
