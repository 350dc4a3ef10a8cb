// How long it takes until a move is on its way to the graphics processor: a desk of the room, a
// thousand moves along a closed path. Reports; a time decides nothing. Twice: a move a frame, as a
// person sees it, where the processor has slept since the last frame, or drawn a picture by
// software, which is waited for; and one move after the other without a picture. Where other
// programs run too, the path is gone along several times (SHADOWCUT_RUNS): each move's shortest
// time is what it takes.
import assert from 'node:assert/strict';
import test from 'node:test';
import { percentile } from '../src/meter.js';
import { launch, open, serve } from './page.mjs';

const moves = Number(process.env.SHADOWCUT_MOVES ?? 1000),
  runs = Number(process.env.SHADOWCUT_RUNS ?? 1);
const say = (numbers) => {
  const [median, p99, most] = [0.5, 0.99, 1].map((share) => percentile(numbers, share).toFixed(3));
  return `median ${median} ms, 99 % under ${p99} ms, most ${most} ms`;
};

// Along the path once; what each update did.
const along = (page, moves, drawn) =>
  page.evaluate(
    async ([moves, drawn]) => {
      const gl = document.querySelector('#view').getContext('webgl2'),
        pixel = new Uint8Array(4);
      const [x, y, z] = (window.begun ??= [3, 7, 11].map(
        (k) => window.walkthrough.poses().poses['desk.4'][k],
      ));
      const updates = [];
      for (let k = 1; k <= moves; ++k) {
        const turn = (2 * Math.PI * k) / moves;
        const to = [x + 0.5 * Math.sin(16 * turn), y, z + 0.4 * Math.sin(21 * turn)];
        if (drawn) window.walkthrough.place('desk.4', to);
        const { update } = await (drawn
          ? window.walkthrough.frame()
          : window.walkthrough.undrawn('desk.4', to));
        updates.push(update);
        if (drawn) gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      }
      return updates;
    },
    [moves, drawn],
  );

test(`${moves} moves of a desk`, async (t) => {
  const server = await serve(),
    browser = await launch();
  const { page, complaints } = await open(browser, server.address, {
    viewport: { width: 240, height: 160 },
  });
  t.diagnostic(`the clock is fine: ${await page.evaluate(() => crossOriginIsolated)}`);
  for (const drawn of [true, false]) {
    await along(page, Math.ceil(moves / 10), drawn); // the code is compiled
    const all = [];
    for (let run = 0; run < runs; ++run) all.push(await along(page, moves, drawn));
    for (const updates of all)
      assert.equal(updates.filter(({ applied }) => applied === 1).length, moves);

    t.diagnostic(drawn ? 'a move a frame' : 'one after the other');
    const report = (what, time) => {
      const best = all[0].map((_, k) => Math.min(...all.map((updates) => time(updates[k]))));
      const name = runs > 1 ? `${what}, the best of ${runs} runs` : what;
      t.diagnostic(`  ${name}: ${say(best)}`);
    };
    report('update and upload', ({ ms, uploadMs }) => ms + uploadMs);
    report('engine', ({ engineMs }) => engineMs);
    report('buffers', ({ ms, engineMs }) => ms - engineMs);
    report('upload', ({ uploadMs }) => uploadMs);
    const bytes = all[0].reduce((sum, u) => sum + u.uploadedBytes, 0);
    t.diagnostic(`  ${(bytes / moves / 1024).toFixed(1)} kB a move`);
  }
  assert.deepEqual(complaints, []);
  await browser.close();
  await server.close();
});
