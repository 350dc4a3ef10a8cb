// The page, driven as a person would: mouse, keys, fingers, files. No console error, no request to
// another host; and whatever it is given, the room stays usable.
import assert from 'node:assert/strict';
import { truncateSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import { carpet, glb, hostile, meshDocument, meshGlb, pyramid } from './files.mjs';
import { findOnScreen, frame, open, stage, words } from './page.mjs';

const on = stage();
const press = async (page, key) => {
  await page.keyboard.press(key);
  return frame(page);
};
const near = (a, b) => Math.abs(a - b) <= 1e-9 * Math.abs(b);

// The room can still be used: what is chosen moves by the keys, and the lit area with it, and back.
async function isUsable(page) {
  const { lit } = await frame(page);
  const chosen = await page.locator('#chosen').inputValue();
  await page.selectOption('#chosen', 'lamp');
  await page.locator('#view').focus();
  const moved = await press(page, 'Shift+PageDown');
  assert.notEqual(moved.lit, lit);
  assert.ok(near((await press(page, 'Shift+PageUp')).lit, lit));
  await page.selectOption('#chosen', chosen);
}

test('the first picture', async (t) => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  const marks = await page.evaluate(() =>
    Object.fromEntries(
      performance.getEntriesByType('mark').map(({ name, startTime }) => [name, startTime]),
    ),
  );
  assert.ok(marks['the room is drawn'] <= marks['the shadows are drawn']);
  for (const [name, ms] of Object.entries(marks))
    t.diagnostic(`${name}: ${ms.toFixed(0)} ms after the page was asked for`);
  assert.equal(await page.title(), 'shadowcut: a walk through exact shadows');
  await isUsable(page);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('settings, by mouse and by keys', async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  const { lit, fragments } = await frame(page);
  for (const [key, kernel] of [
    ['2', 'exact'],
    ['1', 'fast'],
  ]) {
    const now = await press(page, key);
    assert.equal(now.kernel, kernel);
    assert.equal(await page.locator('#kernel').inputValue(), kernel);
    assert.ok(Math.abs(now.lit - lit) < 1e-4 * lit);
  }
  await page.selectOption('#kernel', 'exact');
  assert.equal((await frame(page)).kernel, 'exact');
  await page.selectOption('#kernel', 'fast');
  assert.deepEqual(await frame(page).then((now) => [now.lit, now.fragments]), [lit, fragments]);

  await page.locator('#view').focus();
  for (const key of ['o', 'o', 'o', 'c', 'o']) await press(page, key);
  assert.ok(await page.locator('#compare').isChecked());
  assert.ok(await page.locator('#divider').isVisible());
  const divider = await page.locator('#divider').boundingBox();
  await page.mouse.move(divider.x + divider.width / 2, 400);
  await page.mouse.down();
  await page.mouse.move(700, 300, { steps: 5 });
  await page.mouse.up();
  assert.equal(
    await page.locator('#divider').getAttribute('aria-valuenow'),
    String(Math.round((100 * 700) / 900)),
  );
  await page.locator('#divider').press('ArrowLeft');
  await frame(page);
  for (const size of ['512', '2048', '1024']) {
    await page.selectOption('#map-size', size);
    await frame(page);
    assert.match(await page.locator('#map-label').textContent(), new RegExp(size));
  }
  await page.mouse.move(600, 300);
  for (let k = 0; k < 12; ++k) await page.mouse.wheel(0, -100);
  await frame(page);
  assert.equal(await page.locator('#zoom').getAttribute('aria-valuetext'), '8.0 times');
  await page.locator('#zoom').fill('0');
  await frame(page);
  await page.locator('#measure').click();
  assert.match(await page.locator('#rebuild').textContent(), /^[\d.]+ ms \(fast\)$/);
  assert.match(await page.locator('#map').textContent(), /^[\d.]+ ms \(6 × 1024²\)$/);
  await page.locator('#view').focus();
  await press(page, 'c');
  assert.ok(!(await page.locator('#divider').isVisible()));

  await page.locator('#fold').click();
  assert.ok(!(await page.locator('#kernel').isVisible()));
  await press(page, 'h');
  assert.ok(await page.locator('#kernel').isVisible());
  assert.match(await page.locator('#vr-why').textContent(), /WebXR|headset/);
  await isUsable(page);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('walking, looking, moving what is chosen, and everything as it was', async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  const begun = await frame(page);
  const seen = () =>
    page.evaluate(() => [100, 300, 500].map((y) => window.walkthrough.under(700, y)).join());
  const first = await findOnScreen(page, 'desk.7');
  await page.locator('#view').focus();
  await page.keyboard.down('w');
  await page.waitForTimeout(500);
  await page.keyboard.up('w');
  await frame(page);
  const nearer = await findOnScreen(page, 'desk.7');
  assert.notDeepEqual(nearer, first);
  for (const key of ['a', 's', 'd', 'q', 'e', 'ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown']) {
    await page.keyboard.down(key);
    await frame(page);
    await page.keyboard.up(key);
  }
  assert.equal((await frame(page)).lit, begun.lit, 'who walks moves nothing');
  await press(page, 'Home');
  assert.deepEqual(await findOnScreen(page, 'desk.7'), first);

  const before = await seen();
  await page.mouse.move(700, 540);
  await page.mouse.down({ button: 'right' });
  await page.mouse.move(400, 500, { steps: 4 });
  await page.mouse.up({ button: 'right' });
  await frame(page);
  assert.notEqual(await seen(), before);
  await press(page, 'Home');

  await page.selectOption('#chosen', 'desk.7');
  await page.locator('#view').focus();
  let last = begun.lit;
  for (const key of [
    'Shift+ArrowLeft',
    'Shift+ArrowUp',
    'Shift+ArrowRight',
    'Shift+PageUp',
    'Shift+PageDown',
    'Shift+ArrowDown',
  ]) {
    const { lit } = await press(page, key);
    assert.notEqual(lit, last, key);
    last = lit;
  }
  await press(page, 'Shift+ArrowLeft');
  const { poses } = await page.evaluate(() => window.walkthrough.poses());
  await press(page, 'r');
  const { lit } = await frame(page);
  assert.ok(near(lit, begun.lit));
  assert.notDeepEqual((await page.evaluate(() => window.walkthrough.poses())).poses, poses);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('windows of other sizes', async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  for (const [width, height] of [
    [320, 480],
    [1400, 300],
    [640, 900],
    [900, 560],
  ]) {
    await page.setViewportSize({ width, height });
    await frame(page);
    const canvas = await page
      .locator('#view')
      .evaluate((view) => [view.clientWidth, view.clientHeight, view.width, view.height]);
    assert.deepEqual(canvas, [width, height, width, height]);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width);
  }
  await isUsable(page);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('fingers', async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address, {
    viewport: { width: 390, height: 760 },
    deviceScaleFactor: 2,
    hasTouch: true,
    isMobile: true,
  });
  const touches = await context.newCDPSession(page);
  const touch = (type, ...points) =>
    touches.send('Input.dispatchTouchEvent', {
      type,
      touchPoints: points.map(([x, y], id) => ({ x, y, id })),
    });
  assert.equal(await page.locator('#view').evaluate((view) => view.width), 780);
  const begun = await frame(page);
  const desk = await findOnScreen(page, 'desk.7');
  await touch('touchStart', desk);
  for (let k = 1; k <= 5; ++k) await touch('touchMove', [desk[0] + 8 * k, desk[1]]);
  await touch('touchEnd');
  const dragged = await frame(page);
  assert.notEqual(dragged.lit, begun.lit);

  const empty = [200, 740];
  assert.equal(await page.evaluate(([x, y]) => window.walkthrough.under(x, y), empty), undefined);
  const where = await findOnScreen(page, 'desk.7');
  await touch('touchStart', empty);
  for (let k = 1; k <= 5; ++k) await touch('touchMove', [empty[0] + 12 * k, empty[1]]);
  await touch('touchEnd');
  await frame(page);
  const looked = await findOnScreen(page, 'desk.7');
  assert.notDeepEqual(looked, where);

  await touch('touchStart', [150, 700], [200, 700]);
  for (let k = 1; k <= 5; ++k) await touch('touchMove', [150, 700 - 10 * k], [200, 700 - 10 * k]);
  await touch('touchEnd');
  await frame(page);
  assert.notDeepEqual(await findOnScreen(page, 'desk.7'), looked);

  const stick = await page.locator('#stick').boundingBox();
  const middle = [stick.x + stick.width / 2, stick.y + stick.height / 2];
  await page.locator('#fold').tap();
  await page.locator('#home').tap();
  await page.locator('#fold').tap();
  await frame(page);
  await touch('touchStart', middle);
  await touch('touchMove', [middle[0], middle[1] - 40]);
  await page.waitForTimeout(400);
  await touch('touchEnd');
  await frame(page);
  assert.notDeepEqual(await findOnScreen(page, 'desk.7'), where);
  assert.equal((await frame(page)).lit, dragged.lit, 'who looks and walks moves nothing');
  assert.deepEqual(complaints, []);
  await context.close();
});

// As when a file is dragged from a folder onto the page.
async function drop(page, name, bytes) {
  const transfer = await page.evaluateHandle(
    ([name, base64]) => {
      const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      const transfer = new DataTransfer();
      transfer.items.add(new File([bytes], name));
      return transfer;
    },
    [name, bytes.toString('base64')],
  );
  await page.dispatchEvent('#view', 'dragover', { dataTransfer: transfer });
  await page.dispatchEvent('#view', 'drop', { dataTransfer: transfer });
}
const settled = (page) =>
  page.waitForFunction(() => !/…$/.test(document.querySelector('#message span').textContent));

test("a user's GLB, dropped: stands in the room, casts, receives, and can be moved", async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  const begun = await frame(page);
  await drop(page, 'pyramid.glb', meshGlb(pyramid()));
  await settled(page);
  assert.equal(await words(page), '');
  const there = await frame(page);
  assert.ok(there.facing > begun.facing + 0.5, 'it receives light');
  assert.ok(there.lit < begun.lit + (there.facing - begun.facing), 'it casts a shadow');
  assert.equal(await page.locator('#chosen').inputValue(), 'pyramid.glb');
  await page.locator('#view').focus();
  assert.notEqual((await press(page, 'Shift+ArrowLeft')).lit, there.lit);
  const at = await findOnScreen(page, 'pyramid.glb');
  await page.mouse.move(...at);
  await page.mouse.down();
  await page.mouse.move(at[0] + 40, at[1] - 5, { steps: 4 });
  await page.mouse.up();
  await press(page, 'c');
  await press(page, 'c');
  await press(page, 'r');
  const reset = await frame(page);
  assert.ok(near(reset.lit, begun.lit) && near(reset.facing, begun.facing), 'it is gone again');
  assert.deepEqual(complaints, []);
  await context.close();
});

test("a user's GLB, chosen: it replaces the room, with its lights or with a lamp", async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  await page.selectOption('#where', 'alone');
  await page.locator('#file').setInputFiles({
    name: 'carpet.glb',
    mimeType: 'model/gltf-binary',
    buffer: meshGlb(carpet(30)),
  });
  await settled(page);
  assert.equal(await words(page), '');
  const lamp = await frame(page);
  assert.equal(lamp.lights, 1);
  assert.ok(lamp.lit > 0 && lamp.facing > 50 && lamp.facing < 70, 'eight metres by eight');
  await isUsable(page);

  const { document, bin } = meshDocument(pyramid());
  Object.assign(document, {
    extensionsUsed: ['KHR_lights_punctual'],
    extensions: {
      KHR_lights_punctual: {
        lights: [
          { type: 'point', intensity: 30 },
          { type: 'directional', intensity: 2 },
        ],
      },
    },
  });
  document.nodes.push(
    { translation: [1, 2, 0.5], extensions: { KHR_lights_punctual: { light: 0 } } },
    { rotation: [-0.6, 0, 0, 0.8], extensions: { KHR_lights_punctual: { light: 1 } } },
  );
  document.scenes[0].nodes.push(1, 2);
  await page
    .locator('#file')
    .setInputFiles({ name: 'lit.glb', mimeType: 'model/gltf-binary', buffer: glb(document, bin) });
  await settled(page);
  assert.equal((await frame(page)).lights, 2);
  await page.locator('#view').focus();
  await press(page, 'c');
  await press(page, 'c');
  await page.locator('#reset').click();
  await page.waitForFunction(() => document.querySelector('#chosen').options.length > 40);
  await frame(page);
  await isUsable(page);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('whatever is dropped, there are words for it, and the room stays usable', async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  for (const [name, [bytes, says]] of Object.entries(hostile())) {
    await drop(page, name, bytes);
    await settled(page);
    const said = await words(page);
    assert.match(said, says, name);
    assert.ok(said.startsWith(name), said);
    assert.ok(await page.locator('#message').isVisible());
  }
  await isUsable(page);
  const large = join(on.folder, 'large.glb');
  writeFileSync(large, meshGlb(pyramid()));
  truncateSync(large, 200 * 2 ** 20);
  await page.locator('#file').setInputFiles(large);
  await settled(page);
  assert.match(await words(page), /^large\.glb: 200 MB; this page takes GLBs of up to 64 MB/);
  await page.locator('#message button').click();
  assert.ok(!(await page.locator('#message').isVisible()));
  await isUsable(page);
  assert.deepEqual(complaints, []);
  await context.close();
});

test('more than the memory holds: words, and the room is there again', async () => {
  // 48 MiB, which the room fits in.
  const page = await on.browser.newPage();
  await page.addInitScript(() => {
    const { Memory } = WebAssembly;
    WebAssembly.Memory = function (wanted) {
      return new Memory({ ...wanted, maximum: 768 });
    };
  });
  const { complaints } = await open(on.browser, on.server.address, {}, page);
  const { lit } = await frame(page);
  for (const where of ['room', 'alone']) {
    await page.selectOption('#where', where);
    await page.locator('#file').setInputFiles({
      name: 'large.glb',
      mimeType: 'model/gltf-binary',
      buffer: meshGlb(carpet(200)),
    });
    await page.waitForFunction(() =>
      /large\.glb: its shadows need more memory/.test(
        document.querySelector('#message').textContent,
      ),
    );
    assert.ok(near((await frame(page)).lit, lit));
    await isUsable(page);
    await page.locator('#message button').click();
  }
  assert.deepEqual(complaints, []);
  await page.close();
});

test('VR: a button where a headset is, words where it is not', async () => {
  for (const [xr, enabled, says] of [
    [undefined, false, /no WebXR/],
    [{ supported: false }, false, /no headset/],
    [{ supported: true }, true, /headset is there/],
  ]) {
    const context = await on.browser.newContext();
    await context.addInitScript((xr) => {
      const fake = xr && {
        isSessionSupported: async () => xr.supported,
        requestSession: () => Promise.reject(new Error('the headset is busy')),
        addEventListener() {},
      };
      Object.defineProperty(navigator, 'xr', { value: fake });
    }, xr);
    const page = await context.newPage();
    await page.goto(on.server.address);
    await page.waitForFunction(() => document.querySelector('#vr-why').textContent !== '');
    assert.match(await page.locator('#vr-why').textContent(), says);
    assert.equal(await page.locator('#vr').isEnabled(), enabled);
    if (enabled) {
      await page.waitForFunction(
        () => performance.getEntriesByName('the shadows are drawn').length > 0,
      );
      await page.locator('#vr').click();
      await page.waitForFunction(() =>
        /VR did not begin: the headset is busy/.test(
          document.querySelector('#message').textContent,
        ),
      );
    }
    await context.close();
  }
});
