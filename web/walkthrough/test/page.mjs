// Serves the built page, opens it in Chromium, and hears what it complains of. Software draws: no
// graphics processor is needed.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before } from 'node:test';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { preview } from 'vite';

const folder = fileURLToPath(new URL('..', import.meta.url));
const executablePath =
  process.env.SHADOWCUT_CHROMIUM ??
  ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);

export const program =
  process.env.SHADOWCUT_PROGRAM ??
  fileURLToPath(new URL('../../../build/release/bin/shadowcut', import.meta.url));
export const roomFile = `${folder}dist/room.glb`;

// Runs the native program; what it prints.
export const native = (...args) =>
  execFileSync(program, args, { encoding: 'utf8', maxBuffer: 2 ** 28 });

export async function serve() {
  assert.ok(
    existsSync(roomFile),
    'the page has not been built: npm run build -w shadowcut-walkthrough',
  );
  const server = await preview({
    root: folder,
    preview: { port: 0, host: '127.0.0.1' },
    logLevel: 'warn',
  });
  return { address: server.resolvedUrls.local[0], close: () => server.close() };
}

export const launch = () =>
  chromium.launch({ executablePath, args: ['--no-sandbox', '--enable-precise-memory-info'] });

// What a file of tests needs, from its first test to its last: { server, browser, folder }, a
// folder for its files.
export function stage() {
  const all = {};
  before(async () => {
    all.folder = mkdtempSync(join(tmpdir(), 'walkthrough-'));
    all.server = await serve();
    all.browser = await launch();
  });
  after(async () => {
    await all.browser?.close();
    await all.server?.close();
    rmSync(all.folder, { recursive: true });
  });
  return all;
}

// A page that has drawn its shadows. `complaints` fills with console errors, exceptions and
// requests to other hosts.
export async function open(browser, address, options = {}, given = undefined) {
  const context =
    given?.context() ??
    (await browser.newContext({ viewport: { width: 900, height: 560 }, ...options }));
  const page = given ?? (await context.newPage());
  page.setDefaultTimeout(120_000); // a busy machine that draws by software
  const complaints = [];
  page.on(
    'console',
    (message) =>
      ['error', 'warning'].includes(message.type()) &&
      !isOfTheDriver(message.text()) &&
      complaints.push(`${message.type()}: ${message.text()}`),
  );
  page.on('pageerror', (error) => complaints.push(`exception: ${error.stack}`));
  page.on(
    'request',
    (request) =>
      /^(https?|wss?):/.test(request.url()) &&
      new URL(request.url()).origin !== new URL(address).origin &&
      complaints.push(`request: ${request.url()}`),
  );
  page.on('requestfailed', (request) => complaints.push(`failed: ${request.url()}`));
  await page.goto(address);
  await page.waitForFunction(
    () => performance.getEntriesByName('the shadows are drawn').length > 0,
  );
  return { page, context, complaints };
}

// The software's that draws here in the place of a graphics processor: it says that reading pixels
// waits.
const isOfTheDriver = (text) =>
  /GL Driver Message.*(GPU stall due to ReadPixels|Performance)/.test(text);

// The next frame's figures.
export const frame = (page) => page.evaluate(() => window.walkthrough.frame());
export const words = (page) => page.locator('#message span').textContent();

// Where on the screen something of that name can be taken hold of: the middle of what is seen of
// it.
export async function findOnScreen(page, name) {
  const at = await page.evaluate((wanted) => {
    const hits = [];
    for (let y = 8; y < innerHeight; y += 16)
      for (let x = 8; x < innerWidth; x += 16)
        if (
          document.elementFromPoint(x, y)?.id === 'view' &&
          window.walkthrough.under(x, y) === wanted
        )
          hits.push([x, y]);
    return hits[hits.length >> 1];
  }, name);
  assert.ok(at, `${name} is not to be seen`);
  return at;
}
