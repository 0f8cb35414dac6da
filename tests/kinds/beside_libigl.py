"""distance.c beside libigl, on levels of many kinds: beside_libigl.py LODC [TRIANGLES] [POINTS].

Needs libigl (PyPI). Levels at 50, 10 and 1 % of each kind are measured by both: libigl by points
spread over the area of both surfaces and by the same vertices. Prints the largest difference of
distances of single points, how the largest distance found by points lies in the bounds, and the
ratio of root mean squares.
"""

import pathlib
import subprocess
import sys
import tempfile

import igl
import numpy as np

import files
import kinds
from distance import Surface, measure


def spread(surface, count, rng):
    """Points, as many in each triangle, and the area that each stands for. Half of the points are
    spread by area instead: small triangles and large ones are both looked at."""
    each = max(4, count // 2 // surface.count)
    ends = np.cumsum(surface.areas) / surface.area
    far = (np.arange(count // 2) + rng.random(count // 2)) / (count // 2)
    extra = np.searchsorted(ends, far).clip(max=surface.count - 1)
    t = np.concatenate([np.repeat(np.arange(surface.count), each), extra])
    a, b, c = surface.corners[t].reshape(-1, 3, 3).transpose(1, 0, 2)
    u, v = rng.random((2, len(t), 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    share = (surface.areas / np.bincount(t))[t] / surface.area
    return a + u * (b - a) + v * (c - a), share


def by_points(a, b, count, rng):
    """Largest and mean square distance of a from b by libigl, and how far distance.c differs."""
    points, share = spread(a, count, rng)
    corners = a.corners.reshape(-1, 3)
    both = np.concatenate([points, corners])
    faces = np.arange(3 * b.count).reshape(-1, 3)
    squares = igl.point_mesh_squared_distance(both, b.corners.reshape(-1, 3), faces)[0]
    differs = abs(b.distances(both) - np.sqrt(squares)).max()
    return np.sqrt(squares.max()), squares[: len(points)] @ share, differs


def main():
    lodc, size, count = (
        sys.argv[1],
        int((sys.argv + [0, 0])[2] or 3000),
        int((sys.argv + [0, 0, 0])[3] or 100000),
    )
    rng = np.random.default_rng(1)
    places, ratios, differences, beyond = [], [], [], 0
    with tempfile.TemporaryDirectory() as scratch:
        mesh, out = pathlib.Path(scratch) / "a.ply", pathlib.Path(scratch) / "a.lodc"
        for name in kinds.KINDS:
            positions, triangles, *more = kinds.make(name, size, 5)
            kinds.write(mesh, positions, triangles, *more)
            subprocess.run([lodc, "build", mesh, "-o", out, "--models", "none", "-q"], check=True)
            a, sequence = Surface(positions, triangles), files.Sequence(out)
            size_of = np.ptp(a.corners.reshape(-1, 3), axis=0).max()
            for share in (0.5, 0.1, 0.01):
                b = sequence.surface(sequence.step(int(share * len(triangles))))
                if not b.count:
                    continue
                m = measure(a, b)
                ways = [by_points(a, b, count, rng), by_points(b, a, count, rng)]
                far, mean = max(w[0] for w in ways), np.sqrt(max(w[1] for w in ways))
                differences.append(max(w[2] for w in ways) / size_of)
                is_beyond = far > m.high * (1 + 1e-9) + 1e-12 * size_of
                beyond += is_beyond
                places.append(far / m.low if m.low > 1e-9 * size_of else 1)
                ratios.append(m.rms / mean if mean > 1e-12 * size_of else 1)
                if is_beyond or not 0.97 < ratios[-1] < 1.03 or not 0.9 < places[-1] < 1.03:
                    print(
                        f"{name} {share}: {far:.6g} in [{m.low:.6g}, {m.high:.6g}], "
                        f"rms {m.rms:.6g} ({m.spread:.1%}) beside {mean:.6g}",
                        flush=True,
                    )
    spans = lambda x: f"{np.min(x):.4f} to {np.max(x):.4f}, median {np.median(x):.4f}"
    print(f"{len(places)} levels; single points differ by {max(differences):.2g} of the size")
    print(f"farthest point / lower bound: {spans(places)}; beyond the upper bound: {beyond}")
    print(f"rms / libigl's: {spans(ratios)}")


main()
