// The page beside the native program: the same room, furniture and lamp dragged by the mouse, and
// the lit area and the number of fragments after every step. They are the same to the last bit with
// every kernel: the room's coordinates are floats (make_room.mjs), poses are doubles on both sides,
// the module computes as native code does, and the page is told to leave the file's triangles and
// the engine's settings as they are.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import { findOnScreen, frame, native, open, roomFile, stage } from './page.mjs';

const on = stage();
const poses = (page) => page.evaluate(() => window.walkthrough.poses());

// An edit for everything that is elsewhere, in the scene's order.
function editsBetween(before, now) {
  const edits = [];
  for (const [object, matrix] of Object.entries(now.poses)) {
    if (matrix.some((number, k) => number !== before.poses[object][k]))
      edits.push({ op: 'pose', object, matrix });
  }
  now.lights.forEach(
    (at, light) =>
      at.some((number, k) => number !== before.lights[light][k]) &&
      edits.push({ op: 'light', light, at }),
  );
  return edits;
}

// Drags what is at `from` along a path of points, and writes down what the page did after each.
async function drag(page, from, path, history) {
  let last = await poses(page);
  await page.mouse.move(...from);
  await page.mouse.down();
  for (const point of path) {
    await page.mouse.move(...point);
    const { allFragments, lit } = await frame(page);
    const now = await poses(page);
    const edits = editsBetween(last, now);
    if (edits.length > 0) history.push({ edits, allFragments, lit });
    last = now;
  }
  await page.mouse.up();
}

function replayed(kernel, history) {
  const script = join(on.folder, `${kernel}.jsonl`);
  const lines = history.flatMap(({ edits }) => [...edits, { op: 'update' }]);
  writeFileSync(script, lines.map((line) => JSON.stringify(line)).join('\n'));
  return JSON.parse(
    native(
      'replay',
      roomFile,
      script,
      '--quiet',
      '--kernel',
      kernel,
      '--threads',
      '1',
      '--json',
      '-',
    ),
  );
}

const spiral = ([x, y], count, width, height) =>
  Array.from({ length: count }, (_, k) => {
    const turn = (4 * Math.PI * (k + 1)) / count,
      far = (k + 1) / count;
    return [x + width * far * Math.sin(turn), y + (height * far * (1 - Math.cos(turn))) / 2];
  });

// The page as it is joins triangles to polygons: fewer faces and fragments of the same region. Its
// corners are within a unit in the last place of it, as the native program's are, and the areas are
// added up in another order.
test('as the page is by itself: the same lit area, within 1e-12 of it, kernel exact', async () => {
  const { page, context, complaints } = await open(on.browser, on.server.address);
  await page.selectOption('#kernel', 'exact');
  const start = await frame(page);
  const history = [];
  const desk = await findOnScreen(page, 'desk.7');
  await drag(page, desk, spiral(desk, 20, 120, 60), history);
  const { build, updates } = replayed('exact', history);
  [start, ...history].forEach(({ lit, allFragments }, k) => {
    const { lit_area, fragments } = [build, ...updates][k];
    assert.ok(
      Math.abs(lit - lit_area) <= 1e-12 * lit_area,
      `update ${k}: ${lit}, native ${lit_area}`,
    );
    assert.ok(allFragments < fragments);
  });
  assert.deepEqual(complaints, []);
  await context.close();
});

for (const kernel of ['exact', 'fast']) {
  test(`a desk with all that is on it, and the lamp: kernel ${kernel}`, async (t) => {
    const { page, context, complaints } = await open(on.browser, on.server.address);
    await page.selectOption('#kernel', kernel);
    await page.evaluate(() => window.walkthrough.asNative());
    const start = await frame(page);
    const history = [];
    const desk = await findOnScreen(page, 'desk.7');
    await drag(page, desk, spiral(desk, 50, 120, 60), history);
    assert.equal(history.length, 50);
    assert.ok(history[0].edits.length >= 3, 'the desk has carried its computer along');
    const lamp = await findOnScreen(page, 'lamp');
    await drag(page, lamp, spiral(lamp, 10, 60, -20), history);
    assert.equal(history.length, 60);

    const { build, updates } = replayed(kernel, history);
    assert.equal(start.lit, build.lit_area);
    assert.equal(start.allFragments, build.fragments);
    assert.deepEqual(
      history.map(({ lit }) => lit),
      updates.map((update) => update.lit_area),
    );
    assert.deepEqual(
      history.map(({ allFragments }) => allFragments),
      updates.map((update) => update.fragments),
    );
    const { fragments, facing } = await frame(page),
      lit = updates.at(-1).lit_area;
    assert.equal(
      await page.locator('#lit').textContent(),
      `${lit.toFixed(6)} m² (${((100 * lit) / facing).toFixed(1)} %)`,
    );
    assert.equal(await page.locator('#fragments').textContent(), String(fragments));
    assert.deepEqual(complaints, []);
    t.diagnostic(
      `lit areas from ${Math.min(...updates.map((u) => u.lit_area))} ` +
        `to ${Math.max(...updates.map((u) => u.lit_area))} m²: the same bits`,
    );
    await context.close();
  });
}
