// How long it takes until a move is in the buffers of the graphics processor's side: a desk of the room, a thousand moves. Reports; a time decides
// nothing. Pictures are drawn by software here, on the processor that the engine runs on, so each is waited for before the next move.
import assert from 'node:assert/strict';
import test from 'node:test';
import { launch, open, serve } from './page.mjs';

const moves = Number(process.env.SHADOWCUT_MOVES ?? 1000);
const at = (numbers, share) => Float64Array.from(numbers).sort()[Math.ceil(share * numbers.length) - 1];
const say = (numbers) => `median ${at(numbers, 0.5).toFixed(3)} ms, 99 % under ${at(numbers, 0.99).toFixed(3)} ms, most ${at(numbers, 1).toFixed(3)} ms`;

test(`${moves} moves of a desk`, async (t) => {
  const server = await serve(), browser = await launch();
  const { page, complaints } = await open(browser, server.address, { viewport: { width: 480, height: 320 } });
  const updates = await page.evaluate(async (moves) => {
    const { poses } = window.walkthrough.poses();
    const [x, y, z] = [3, 7, 11].map((k) => poses['desk.4'][k]);
    const updates = [], gl = document.querySelector('#view').getContext('webgl2'), pixel = new Uint8Array(4);
    for (let k = 0; k < moves + 50; ++k) {
      const turn = k / 60;
      window.walkthrough.place('desk.4', [x + 0.5 * Math.sin(turn), y, z + 0.4 * Math.sin(1.3 * turn)]);
      const { update } = await window.walkthrough.frame();
      if (k >= 50) updates.push(update);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    }
    return updates;
  }, moves);
  assert.equal(updates.length, moves);
  assert.ok(updates.filter(({ applied }) => applied === 1).length >= moves - 2);
  t.diagnostic(`update and upload: ${say(updates.map(({ ms, uploadMs }) => ms + uploadMs))}`);
  t.diagnostic(`engine: ${say(updates.map(({ engineMs }) => engineMs))}`);
  t.diagnostic(`buffers: ${say(updates.map(({ ms, engineMs }) => ms - engineMs))}`);
  t.diagnostic(`upload: ${say(updates.map(({ uploadMs }) => uploadMs))}, ${(updates.reduce((sum, u) => sum + u.uploadedBytes, 0) / moves / 1024).toFixed(1)} kB each`);
  t.diagnostic(`the page is isolated, its clock fine: ${await page.evaluate(() => crossOriginIsolated)}`);
  assert.deepEqual(complaints, []);
  await browser.close();
  await server.close();
});
