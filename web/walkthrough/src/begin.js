// The first that runs, and small: the engine is compiled while it arrives, and the room fetched,
// while three.js and the rest of the page are read.
import { load } from 'shadowcut';
import wasmUrl from 'shadowcut/shadowcut.wasm?url';
import { fetchRoom } from './fetch.js';

const engine = load({ wasmUrl }),
  room = fetchRoom();
for (const each of [engine, room]) each.catch(() => {}); // said by the page, once it is there
const { begin } = await import('./main.js');
begin(engine, room);
