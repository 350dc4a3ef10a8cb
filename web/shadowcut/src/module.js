// The WebAssembly module and its memory: how numbers, arrays, texts and structs go in and out, and
// how a status becomes an exception.
import { enums, status as statuses, structs } from '../dist/interface.js';

const page = 65536;
const most = 65536; // pages: the 4 GiB that 32-bit addresses reach
const initial = 256; // pages; as linked

export class ShadowcutError extends Error {
  constructor(status, message) {
    super(message);
    this.name = 'ShadowcutError';
    this.status = status;
  }
}

async function compiled({ wasmBinary, wasmUrl }) {
  if (wasmBinary) return WebAssembly.compile(wasmBinary);
  const url = new URL(
    wasmUrl ?? new URL('../dist/shadowcut.wasm', import.meta.url),
    globalThis.location?.href,
  );
  if (url.protocol === 'file:')
    return WebAssembly.compile(
      await (await import(/* @vite-ignore */ 'node:fs/promises')).readFile(url),
    );
  const response = await fetch(url);
  if (!response.ok)
    throw new ShadowcutError('NOT_FOUND', `${url}: ${response.status} ${response.statusText}`);
  // While it arrives, where the server says what it is.
  if (response.headers.get('content-type') === 'application/wasm')
    return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}

const decoder = new TextDecoder();
const names = Object.entries(statuses).reduce(
  (list, [name, number]) => ((list[number] = name), list),
  [],
);

export class Module {
  static async load(options = {}) {
    const pages =
      options.maximumMemory === undefined ? most : Math.floor(options.maximumMemory / page);
    if (!(pages >= initial && pages <= most)) {
      throw new ShadowcutError(
        'INVALID_ARGUMENT',
        `maximumMemory must be between ${initial * page} and ${most * page} bytes`,
      );
    }
    const memory = new WebAssembly.Memory({ initial, maximum: pages });
    const instance = await WebAssembly.instantiate(await compiled(options), surroundings(memory));
    return new Module(memory, instance.exports);
  }

  constructor(memory, functions) {
    this.memory = memory;
    this.c = functions;
    this.view = new DataView(memory.buffer);
    functions._initialize();
    // Room for arguments and results of one call, used from its begin on.
    this.roomSize = 65536;
    this.room = functions.malloc(this.roomSize) >>> 0;
    this.used = 0;
    this.lent = []; // what did not fit
    // by kind of struct: the function that sets it; null where there is none
    this.inits = new Map();
  }

  get buffer() {
    return this.memory.buffer;
  }
  // Anew when memory has grown.
  get data() {
    if (this.view.buffer !== this.memory.buffer) this.view = new DataView(this.memory.buffer);
    return this.view;
  }

  // Calls body, and gives back all room that it took.
  within(body) {
    const { used } = this;
    const lent = this.lent.length;
    try {
      return body();
    } finally {
      this.used = used;
      while (this.lent.length > lent) this.c.free(this.lent.pop());
    }
  }
  take(bytes) {
    const size = (bytes + 7) & ~7;
    if (bytes <= this.roomSize - this.used) {
      const at = this.room + this.used;
      this.used += size;
      return at;
    }
    const at = bytes < 2 ** 32 ? this.c.malloc(bytes) >>> 0 : 0;
    if (at === 0) throw new ShadowcutError('OUT_OF_MEMORY', 'out of memory');
    this.lent.push(at);
    return at;
  }

  text(at) {
    const bytes = new Uint8Array(this.buffer, at >>> 0);
    return decoder.decode(bytes.subarray(0, bytes.indexOf(0)).slice());
  }
  putText(text) {
    const bytes = new TextEncoder().encode(`${text}\0`);
    return this.putArray(bytes, Uint8Array);
  }
  // A copy of a list of numbers, as elements of a kind of typed array.
  putArray(values, Kind) {
    const at = this.take(Math.max(values.length, 1) * Kind.BYTES_PER_ELEMENT);
    new Kind(this.buffer, at, values.length).set(values);
    return at;
  }
  array(Kind, at, length) {
    return new Kind(this.buffer, at >>> 0, length);
  }

  // Calls a function of c.h that returns a status.
  call(name, ...args) {
    const status = this.c[`shadowcut_${name}`](...args);
    if (status !== 0)
      throw new ShadowcutError(names[status], this.text(this.c.shadowcut_message()));
  }
  // The same, and what it hands out through `count` last parameters of 32 bits each.
  values(count, name, ...args) {
    return this.within(() => {
      const at = this.take(4 * count);
      const out = [];
      for (let k = 0; k < count; ++k) args.push(at + 4 * k);
      this.call(name, ...args);
      for (let k = 0; k < count; ++k) out.push(this.data.getUint32(at + 4 * k, true));
      return out;
    });
  }
  value(name, ...args) {
    return this.values(1, name, ...args)[0];
  }
  // The same for a struct, which begins with its size if it has a function that sets it.
  struct(kind, name, ...args) {
    return this.within(() => {
      const at = this.begin(kind);
      this.call(name, ...args, at);
      return this.read(kind, at);
    });
  }
  // The same, of which one member is wanted.
  member(kind, member, name, ...args) {
    return this.within(() => {
      const at = this.begin(kind);
      this.call(name, ...args, at);
      const found = structs[kind].members.find((m) => m.name === member);
      return this.readMember(found, at + found.offset, found.shape);
    });
  }
  // The same for `count` elements from `first` on; name(..., first, count, elements).
  list(kind, first, count, name, ...args) {
    return this.within(() => {
      const { size } = structs[kind];
      const at = this.take(size * count);
      this.call(name, ...args, first, count, at);
      return Array.from({ length: count }, (_, k) => this.read(kind, at + k * size));
    });
  }
  // The same for `count` numbers: a copy.
  numbers(Kind, count, name, ...args) {
    return this.within(() => {
      const at = this.take(Kind.BYTES_PER_ELEMENT * count);
      this.call(name, ...args, at);
      return this.array(Kind, at, count).slice();
    });
  }

  // A struct as its *_init function leaves it; of one without, nothing.
  begin(kind) {
    const at = this.take(structs[kind].size);
    let init = this.inits.get(kind);
    if (init === undefined)
      this.inits.set(
        kind,
        (init = this.c[`shadowcut_${snake(kind)}_init`] ? `${snake(kind)}_init` : null),
      );
    if (init !== null) this.call(init, at);
    return at;
  }
  read(kind, at) {
    const out = {};
    for (const member of structs[kind].members) {
      if (member.name !== 'size')
        out[member.name] = this.readMember(member, at + member.offset, member.shape);
    }
    return out;
  }
  readMember(member, at, shape) {
    if (shape.length === 1 && member.is === 'double')
      return Array.from(this.array(Float64Array, at, shape[0]));
    if (shape.length > 0) {
      const [count, ...rest] = shape;
      const step = member.size * rest.reduce((a, b) => a * b, 1);
      return Array.from({ length: count }, (_, k) => this.readMember(member, at + k * step, rest));
    }
    const { data } = this;
    switch (member.is) {
      case 'double':
        return data.getFloat64(at, true);
      case 'uint32_t':
        return data.getUint32(at, true);
      case 'uint64_t':
        return Number(data.getBigUint64(at, true));
      case 'flag':
        return data.getInt32(at, true) !== 0;
      case 'enum':
        return enums[member.key][data.getInt32(at, true)];
      case 'text':
        return this.text(data.getUint32(at, true));
      default:
        return this.read(member.is, at);
    }
  }

  // A struct with these members, and the values of its *_init function for all others. Throws for
  // unknown members.
  put(kind, values = {}) {
    const at = this.begin(kind);
    this.write(kind, at, values);
    return at;
  }
  write(kind, at, values) {
    const { members } = structs[kind];
    for (const [name, value] of Object.entries(values)) {
      const member = members.find((m) => m.name === name && name !== 'size');
      if (!member) throw new ShadowcutError('INVALID_ARGUMENT', `there is no ${name} in ${kind}`);
      if (value !== undefined) this.writeMember(member, at + member.offset, value);
    }
  }
  // The id of an object or a light: as put() would, without looking for names, because edits come
  // every frame.
  putId(id) {
    if (typeof id?.index !== 'number')
      throw new ShadowcutError('INVALID_ARGUMENT', 'an argument is not an id');
    const at = this.take(12);
    const { data } = this;
    data.setUint32(at, id.index, true);
    data.setUint32(at + 4, id.generation, true);
    data.setUint32(at + 8, id.scene, true);
    return at;
  }
  writeMember(member, at, value) {
    if (member.shape.length > 0) {
      const [count] = member.shape;
      if (value?.length !== count)
        throw new ShadowcutError('INVALID_ARGUMENT', `${member.name} must have ${count} numbers`);
      this.array(Float64Array, at, count).set(value);
      return;
    }
    switch (member.is) {
      case 'double':
        return this.data.setFloat64(at, value, true);
      case 'uint32_t':
        return this.data.setUint32(at, value, true);
      case 'uint64_t':
        return this.data.setBigUint64(at, BigInt(value), true);
      case 'flag':
        return this.data.setInt32(at, value ? 1 : 0, true);
      case 'enum':
        return this.data.setInt32(at, numberOf(member.key, value), true);
      case 'text': {
        const text = this.putText(value);
        return this.data.setUint32(at, text, true);
      }
      default:
        return this.write(member.is, at, value);
    }
  }
}

export function numberOf(kind, word) {
  const number = enums[kind].indexOf(word);
  if (number < 0)
    throw new ShadowcutError(
      'INVALID_ARGUMENT',
      `${kind} must be one of ${enums[kind].join(', ')}, and is ${word}`,
    );
  return number;
}

const snake = (name) => name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);

// All that the module asks for: its memory, a steady clock, and what is to happen when the C
// library gives up.
function surroundings(memory) {
  return {
    env: { memory, emscripten_notify_memory_growth() {} },
    wasi_snapshot_preview1: {
      clock_time_get(clock, precision, at) {
        new DataView(memory.buffer).setBigUint64(
          at >>> 0,
          BigInt(Math.round(performance.now() * 1e6)),
          true,
        );
        return 0;
      },
      proc_exit(code) {
        throw new ShadowcutError('INTERNAL_ERROR', `the engine has stopped (${code})`);
      },
    },
  };
}
