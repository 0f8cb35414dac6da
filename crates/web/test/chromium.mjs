// Chromium without a window, spoken to over a pipe. Whatever becomes of a test, nothing here keeps
// its process alive or makes it wait without an end.

import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const FLAGS = [
  '--headless=new', '--no-sandbox', '--remote-debugging-pipe', '--no-first-run', '--mute-audio',
  '--enable-unsafe-swiftshader', '--use-angle=swiftshader', '--hide-scrollbars',
  '--disable-background-networking', '--disable-component-update', '--disable-dev-shm-usage',
  // What a busy machine makes slow is not to be ended for it.
  '--disable-gpu-watchdog', '--disable-hang-monitor', '--disable-renderer-backgrounding',
];

/** Answers that take longer never come: milliseconds. */
const LONGEST = 120_000;

/** A browser with one page. */
export class Chromium {
  static async start(...flags) {
    const profile = mkdtempSync(join(tmpdir(), 'lodc-chromium-'));
    const stdio = ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'];
    const child = spawn('chromium', [...FLAGS, ...flags, `--user-data-dir=${profile}`], { stdio });
    const browser = new Chromium(child, profile);
    process.on('exit', () => child.kill('SIGKILL'));
    const { targetId } = await browser.send('Target.createTarget', { url: 'about:blank' });
    const attached = await browser.send('Target.attachToTarget', { targetId, flatten: true });
    browser.session = attached.sessionId;
    const domains = ['Inspector', 'Page', 'Runtime', 'Log'];
    for (const domain of domains) await browser.send(`${domain}.enable`);
    return browser;
  }

  constructor(child, profile) {
    Object.assign(this, { child, profile });
    this.next = 1;
    this.open = new Map();
    this.waits = [];
    /** What the page wrote to its console, and errors. */
    this.console = [];
    let text = '';
    child.stdio[4].setEncoding('utf8').on('data', (piece) => {
      const messages = (text + piece).split('\0');
      text = messages.pop();
      for (const message of messages) this.take(JSON.parse(message));
    });
    this.ended = new Promise((resolve) => {
      for (const event of ['exit', 'error']) child.once(event, resolve);
    });
    const crashed = new Promise((resolve) => {
      this.waits.push({ method: 'Inspector.targetCrashed', resolve });
    });
    this.gone = Promise.race([
      this.ended.then(() => 'Chromium ended'), crashed.then(() => 'the page crashed'),
    ]);
    // A failure outside of all tests would wait for them.
    for (const handle of [child, child.stdio[3], child.stdio[4]]) handle.unref();
    child.stdio[3].on('error', () => {});
  }

  take({ id, result, error, method, params }) {
    if (id) {
      const { resolve, reject } = this.open.get(id) ?? {};
      this.open.delete(id);
      if (!resolve) return;
      if (error) reject(new Error(error.message));
      else resolve(result);
      return;
    }
    if (method === 'Runtime.consoleAPICalled') {
      const words = params.args.map((arg) => arg.value ?? arg.description).join(' ');
      this.console.push(`${params.type}: ${words}`);
    }
    if (method === 'Log.entryAdded') {
      this.console.push(`${params.entry.level}: ${params.entry.text} ${params.entry.url ?? ''}`);
    }
    if (method === 'Runtime.exceptionThrown') {
      const { exception, text } = params.exceptionDetails;
      this.console.push(`error: ${exception?.description ?? text}`);
    }
    this.waits.filter((wait) => wait.method === method).forEach(({ resolve }) => resolve(params));
    this.waits = this.waits.filter((wait) => wait.method !== method);
  }

  send(method, params = {}) {
    const id = this.next++;
    const isOfPage = this.session && !method.startsWith('Target.');
    const session = isOfPage ? { sessionId: this.session } : {};
    const answer = new Promise((resolve, reject) => {
      this.open.set(id, { resolve, reject });
      this.child.stdio[3].write(`${JSON.stringify({ id, method, params, ...session })}\0`);
    });
    return this.within(answer, `${method} ${params.expression ?? ''}`);
  }

  event(method) {
    return this.within(new Promise((resolve) => this.waits.push({ method, resolve })), method);
  }

  /** What is waited for, or an error if the browser ends before or takes too long. */
  async within(wanted, what) {
    let timer;
    const late = new Promise((resolve) => { timer = setTimeout(resolve, LONGEST, 'no answer'); });
    const failed = Promise.race([late, this.gone]).then((why) => {
      throw new Error(`${what}: ${why}\n${this.console.join('\n')}`);
    });
    try {
      return await Promise.race([wanted, failed]);
    } finally {
      clearTimeout(timer);
    }
  }

  /** Waits until an expression is true. */
  async until(expression) {
    const begun = Date.now();
    while (!await this.value(expression)) {
      const late = Date.now() - begun > LONGEST;
      if (late) throw new Error(`never true: ${expression}\n${this.console.join('\n')}`);
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  }

  /** Opens an address and waits until it is loaded. */
  async goto(url) {
    const loaded = this.event('Page.loadEventFired');
    await Promise.all([loaded, this.send('Page.navigate', { url })]);
  }

  /** The value of an expression, which may be a promise. */
  async value(expression) {
    const call = { expression, awaitPromise: true, returnByValue: true };
    const { result, exceptionDetails } = await this.send('Runtime.evaluate', call);
    if (exceptionDetails) {
      const { exception, text } = exceptionDetails;
      throw new Error(`${exception?.description ?? text}\n${this.console.join('\n')}`);
    }
    return result.value;
  }

  /** Size of the page in pixels. */
  size(width, height) {
    const metrics = { width, height, deviceScaleFactor: 1, mobile: false };
    return this.send('Emulation.setDeviceMetricsOverride', metrics);
  }

  /** A picture of the page as PNG. */
  async picture() {
    const { data } = await this.send('Page.captureScreenshot', { format: 'png' });
    return Buffer.from(data, 'base64');
  }

  async close() {
    const late = setTimeout(() => this.child.kill('SIGKILL'), 10_000);
    this.send('Browser.close').catch(() => {});
    await this.ended;
    clearTimeout(late);
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
  }
}
