// A server of files that tests may hold back.

import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { extname, join, normalize } from 'node:path';

const TYPES = {
  '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm', '.png': 'image/png',
  '.jpg': 'image/jpeg', '.json': 'application/json',
};

/** How much of a file is sent: a share that grows. */
class Gate {
  constructor() {
    this.share = 0;
    this.waiting = [];
  }

  open(share) {
    this.share = share;
    this.waiting.splice(0).forEach((go) => go());
  }

  opened() {
    return new Promise((resolve) => this.waiting.push(resolve));
  }
}

/**
 * Serves folders, the first that has a file, until the process ends. `gates` has those of files
 * that are held back, by their paths; `requests` the paths that were asked for.
 */
export async function serve(...folders) {
  const gates = new Map();
  const requests = [];
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
    requests.push(path);
    for (const folder of folders) {
      const bytes = await readFile(join(folder, path)).catch(() => null);
      if (!bytes) continue;
      const type = TYPES[extname(path)] ?? 'application/octet-stream';
      response.writeHead(200, { 'Content-Type': type, 'Content-Length': bytes.length });
      const gate = gates.get(path);
      for (let at = 0; at < bytes.length;) {
        const end = Math.ceil(bytes.length * (gate?.share ?? 1));
        if (end > at) response.write(bytes.subarray(at, end));
        else await gate.opened();
        at = Math.max(at, end);
      }
      response.end();
      return;
    }
    response.writeHead(404).end();
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  server.unref();
  const gate = (path) => {
    gates.set(path, new Gate());
    return gates.get(path);
  };
  return { url: `http://127.0.0.1:${server.address().port}`, gate, requests };
}
