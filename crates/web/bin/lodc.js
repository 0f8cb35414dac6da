#!/usr/bin/env node
// `npx lodc`: runs the program of this machine, which an optional package of its own brings along.

import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { constants } from 'node:os';

const PLATFORMS = [
  'linux-x64', 'linux-arm64', 'linux-x64-musl', 'linux-arm64-musl', 'darwin-x64', 'darwin-arm64',
  'win32-x64', 'win32-arm64',
];

/** Names of platforms whose program runs here, the best first. */
function platforms() {
  const { platform, arch, report } = process;
  const name = `${platform}-${arch}`;
  if (platform !== 'linux') return [name];
  // A program that is linked statically runs beside any C library.
  report.excludeNetwork = true;
  const hasGlibc = report.getReport().header.glibcVersionRuntime !== undefined;
  return hasGlibc ? [name, `${name}-musl`] : [`${name}-musl`];
}

/** The path of the program; null where its package is not installed. */
function program(names) {
  const { resolve } = createRequire(import.meta.url);
  const file = process.platform === 'win32' ? 'lodc.exe' : 'lodc';
  for (const name of names) {
    try {
      return resolve(`@lodc/${name}/${file}`);
    } catch {
      // The next one may be there.
    }
  }
  return null;
}

const names = platforms();
const path = program(names);
if (path) {
  const child = spawn(path, process.argv.slice(2), { stdio: 'inherit' });
  // A terminal interrupts both: the program cleans up and ends, and says how.
  process.on('SIGINT', () => {});
  for (const signal of ['SIGTERM', 'SIGHUP']) process.on(signal, () => child.kill(signal));
  child.on('error', (error) => {
    console.error(`lodc: ${path} does not start: ${error.message}`);
    process.exitCode = 1;
  });
  child.on('exit', (code, signal) => {
    process.exitCode = code ?? 128 + constants.signals[signal];
  });
} else {
  const isKnown = names.some((name) => PLATFORMS.includes(name));
  const why = isKnown
    ? `the optional package @lodc/${names[0]} is not installed; `
      + 'run npm install without --omit=optional'
    : `there is none for ${names[0]}; build it with cargo install lodc-cli`;
  console.error(`lodc: the program is missing: ${why}`);
  process.exitCode = 1;
}
