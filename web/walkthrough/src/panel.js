// The panel: writes figures, and says when a setting was changed. What the figures are is said in
// index.html, under "What is what".
import { percentile } from './meter.js';

const byId = (id) => document.getElementById(id);
const ms = (value) => (value === undefined ? '–' : `${value.toFixed(value < 10 ? 2 : 1)} ms`);
const kilobytes = (bytes) => `${(bytes / 1024).toFixed(1)} kB`;
const history = 1000;

export class Panel {
  updates = []; // ms of the last ones
  #shown = new Map();

  // on: { kernel, outlines, compare, mapSize, zoom, chosen, file, reset, home, measure, vr },
  // functions of the new value.
  constructor(on) {
    this.#listen('kernel', 'change', (field) => on.kernel(field.value));
    this.#listen('outlines', 'change', (field) => on.outlines(field.checked));
    this.#listen('compare', 'change', (field) => on.compare(field.checked));
    this.#listen('map-size', 'change', (field) => on.mapSize(Number(field.value)));
    this.#listen('zoom', 'input', (field) => on.zoom(2 ** Number(field.value)));
    this.#listen('chosen', 'change', (field) => on.chosen(field.value));
    for (const button of ['reset', 'home', 'measure', 'vr'])
      this.#listen(button, 'click', () => on[button]());
    this.#listen('file', 'change', (field) => {
      if (field.files.length > 0) on.file(field.files[0]);
      field.value = ''; // so that the same file can be chosen again
    });
    this.#listen('fold', 'click', () => this.fold(!byId('panel').classList.contains('folded')));
    byId('message').lastElementChild.addEventListener('click', () => this.say(''));
    if (innerWidth < 640) this.fold(true);
  }
  #listen(id, event, handler) {
    byId(id).addEventListener(event, () => handler(byId(id)));
  }

  fold(folded) {
    byId('panel').classList.toggle('folded', folded);
    byId('fold').setAttribute('aria-expanded', String(!folded));
  }
  // A key does what the field does.
  toggle(id) {
    byId(id).click();
  }
  set(id, value) {
    const field = byId(id);
    if (field.type === 'checkbox') field.checked = value;
    else field.value = value;
  }
  get alone() {
    return byId('where').value === 'alone';
  }

  // Words across the view; none: takes them away.
  say(words) {
    byId('message').hidden = !words;
    byId('message').firstElementChild.textContent = words;
  }
  vr(enabled, words) {
    byId('vr').disabled = !enabled;
    byId('vr-why').textContent = words;
  }
  names(names, chosen) {
    byId('chosen').replaceChildren(
      ...names.map((name) => new Option(name, name, false, name === chosen)),
    );
  }

  // What one update did, uploads included.
  update({ engineMs, buffersMs, uploadMs, uploadedBytes, gone, added }) {
    const all = engineMs + buffersMs + uploadMs;
    this.updates.push(all);
    if (this.updates.length > history) this.updates.shift();
    this.#write('update', ms(all));
    this.#write('engine', ms(engineMs));
    this.#write('buffers', ms(buffersMs));
    this.#write('upload', `${ms(uploadMs)}, ${kilobytes(uploadedBytes)}`);
    this.#write('changed', `${gone}, ${added}`);
    this.#write('history', `${this.updates.length} updates: median`);
    this.#write('middle', ms(percentile(this.updates, 0.5)));
    this.#write('most', ms(percentile(this.updates, 0.99)));
  }
  state({ fragments, lit, facing, lights }) {
    this.#write('fragments', String(fragments));
    const share = facing > 0 ? ` (${((100 * lit) / facing).toFixed(1)} %)` : '';
    this.#write('lit', lights === 0 ? 'no light' : `${lit.toFixed(6)} m²${share}`);
  }
  forgetUpdates() {
    this.updates.length = 0;
    for (const id of [
      'update',
      'engine',
      'buffers',
      'upload',
      'changed',
      'middle',
      'most',
      'rebuild',
      'map',
    ])
      this.#write(id, '–');
  }
  rebuild(value, kernel) {
    this.#write('rebuild', `${ms(value)} (${kernel})`);
  }
  map(value, size, lights) {
    this.#write('map', `${ms(value)} (${lights > 1 ? `${lights} × ` : ''}${size})`);
  }
  zoom(zoom, size) {
    const field = byId('zoom');
    field.value = String(Math.log2(zoom));
    field.setAttribute('aria-valuetext', `${zoom.toFixed(1)} times`);
    this.#write('map-label', `shadow map of 6 × ${size} × ${size}`);
  }
  halves(shown, share) {
    byId('halves').hidden = !shown;
    byId('divider').style.left = `${100 * share}%`;
    byId('left-label').style.left = `calc(${100 * share}% - 0.8rem)`;
    byId('right-label').style.left = `calc(${100 * share}% + 0.8rem)`;
  }

  #write(id, text) {
    if (this.#shown.get(id) === text) return;
    this.#shown.set(id, text);
    byId(id).textContent = text;
  }
}
