// In a browser: a scene with two lights of different colours, drawn by fragments and by three.js'
// shadow maps. SHADOWCUT_PICTURES is a folder for the pictures; SHADOWCUT_CHROMIUM, the browser.
import assert from 'node:assert/strict';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import test from 'node:test';
import { chromium } from 'playwright-core';

const root = fileURLToPath(new URL('../../', import.meta.url));
const types = { '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm' };

async function serve() {
  const server = createServer(async (request, response) => {
    const path = normalize(new URL(request.url, 'http://x').pathname);
    try {
      const body = await readFile(join(root, path));
      response
        .writeHead(200, { 'content-type': types[extname(path)] ?? 'application/octet-stream' })
        .end(body);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return server;
}

test('fragments shade as shadow maps do, but for the edges', { timeout: 180000 }, async () => {
  const server = await serve();
  const browser = await chromium.launch({
    executablePath: process.env.SHADOWCUT_CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox'],
  });
  try {
    const page = await browser.newPage({ viewport: { width: 800, height: 500 } });
    const said = [];
    page.on(
      'console',
      (message) => ['error', 'warning'].includes(message.type()) && said.push(message.text()),
    );
    page.on('pageerror', (error) => said.push(String(error)));
    await page.goto(`http://127.0.0.1:${server.address().port}/three/test/picture.html`);
    await page.waitForFunction(() => window.ready, undefined, { timeout: 60000 });
    const { pictures, ...result } = await page.evaluate(() => window.run());
    const folder = process.env.SHADOWCUT_PICTURES;
    if (folder) {
      await mkdir(folder, { recursive: true });
      for (const [name, url] of Object.entries(pictures))
        await writeFile(join(folder, `${name}.png`), Buffer.from(url.split(',')[1], 'base64'));
    }
    console.log(JSON.stringify(result), said);
    assert.deepEqual(
      said.filter((line) => !/GPU stall due to ReadPixels|swiftshader|software WebGL/i.test(line)),
      [],
    );
    assert.equal(result.errors, 0);
    assert.equal(result.issues, 0);
    assert.ok(result.both.share < 0.02, `${result.both.share} of the pixels differ`);
    assert.ok(
      result.both.farthest <= 3,
      `a pixel differs ${result.both.farthest} pixels from an edge`,
    );
    assert.ok(result.ranges.share < 0.0005, 'what was uploaded in ranges is what there is');
    assert.ok(result.unshadowed > 0.05, 'the shadows are there');
  } finally {
    await browser.close();
    server.close();
  }
});
