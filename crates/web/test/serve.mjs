// A server of files, some of them slowly.

import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { extname, join, normalize } from 'node:path';

const TYPES = {
  '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm', '.png': 'image/png',
  '.jpg': 'image/jpeg',
};

/** Serves folders, the first that has a file; `?slow=N` sends it in N pieces, 50 ms apart. */
export async function serve(...folders) {
  const server = createServer(async (request, response) => {
    const url = new URL(request.url, 'http://localhost');
    const path = normalize(decodeURIComponent(url.pathname));
    for (const folder of folders) {
      const bytes = await readFile(join(folder, path)).catch(() => null);
      if (!bytes) continue;
      const type = TYPES[extname(path)] ?? 'application/octet-stream';
      response.writeHead(200, { 'Content-Type': type, 'Content-Length': bytes.length });
      const pieces = Number(url.searchParams.get('slow') ?? 1);
      const size = Math.ceil(bytes.length / pieces) || 1;
      for (let at = 0; at < bytes.length; at += size) {
        if (at > 0) await new Promise((resolve) => setTimeout(resolve, 50));
        response.write(bytes.subarray(at, at + size));
      }
      response.end();
      return;
    }
    response.writeHead(404).end();
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { server, url: `http://127.0.0.1:${server.address().port}` };
}
