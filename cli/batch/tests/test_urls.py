"""Assets that come from an object store (moto's S3) and go there, with the files that they name."""

import json
import os
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request
from pathlib import Path

from lodc_batch import build, read_list
from lodc_batch.cluster import summary

from .test_cluster import LODC, Cluster, grid

PORT = 5071
PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de"
    "0000000c4944415408d763f8cfc000000301010018dd8db00000000049454e44ae426082"
)


class Urls(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="lodc-batch-")).resolve()
        os.chdir(self.folder)
        os.environ.update(
            AWS_ENDPOINT_URL=f"http://127.0.0.1:{PORT}",
            AWS_ACCESS_KEY_ID="test",
            AWS_SECRET_ACCESS_KEY="test",
            AWS_DEFAULT_REGION="us-east-1",
        )
        log = open("moto.log", "w")
        server = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(PORT)]
        self.server = subprocess.Popen(server, stdout=log, stderr=log)
        for _ in range(200):
            try:
                urllib.request.urlopen(os.environ["AWS_ENDPOINT_URL"])
                break
            except OSError:
                time.sleep(0.1)
        self.cluster = Cluster(self.folder, 2)

    def tearDown(self):
        self.cluster.stop()
        self.server.kill()
        self.server.wait()

    def run_list(self, output, options=()):
        tasks = read_list("list.jsonl")
        return build(tasks, self.cluster.file, LODC, output, options, timeout=60)

    def test_inputs_and_results_at_urls(self):
        import fsspec

        store = fsspec.filesystem("s3")
        for bucket in ("assets", "levels"):
            store.mkdir(bucket)
        text = "mtllib m.mtl\nusemtl m\n" + grid(5, 1)
        put = lambda name, data: store.pipe_file(f"assets/props/{name}", data)
        put("a.obj", text.encode())
        put("m.mtl", b"newmtl m\nmap_Kd tex/red.png\n")
        put("tex/red.png", PNG)
        put("b b.obj", grid(4, 2).encode())
        names = ["a.obj", "b b.obj", "missing.obj"]
        lines = [{"input": f"s3://assets/props/{name}"} for name in names]
        Path("list.jsonl").write_text("\n".join(map(json.dumps, lines)))

        first = self.run_list("s3://levels/built", ("--if-changed",))
        self.assertEqual(summary(first), {"built": 2, "up_to_date": 0, "failed": 1})
        self.assertIn("missing.obj", first[2]["error"])
        self.assertEqual(first[0]["output"], "s3://levels/built/a.obj.lodc")
        there = sorted(store.find("levels"))
        files = ["a.obj.lodc", "a.obj.lodc.key", "b b.obj.lodc", "b b.obj.lodc.key"]
        self.assertEqual(there, [f"levels/built/{name}" for name in files])
        # What was built here of the same files is the same.
        Path("tex").mkdir()
        for name in ("a.obj", "m.mtl", "tex/red.png"):
            store.get_file(f"assets/props/{name}", name)
        subprocess.run([LODC, "build", "a.obj", "-o", "a.lodc", "-q"], check=True)
        self.assertEqual(store.cat_file("levels/built/a.obj.lodc"), Path("a.lodc").read_bytes())

        again = self.run_list("s3://levels/built", ("--if-changed",))
        self.assertEqual([line["up_to_date"] for line in again], [True, True, False])
        put("tex/red.png", PNG + b"\0")
        fresh = self.run_list("s3://levels/built", ("--if-changed",))
        self.assertEqual([line["up_to_date"] for line in fresh], [False, True, False])
        # In from a server, out to a folder.
        local = self.run_list("out")
        self.assertEqual(local[1]["output"], "out/b b.obj.lodc")
        self.assertTrue(Path("out/b b.obj.lodc").is_file())


if __name__ == "__main__":
    unittest.main()
