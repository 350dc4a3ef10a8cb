// Writes what JavaScript has to know of c.h: its constants, the layout of its structs as wasm32 has
// them, and the names of its functions.
//
//   node interface.mjs include/shadowcut/c.h dist/interface.js
//
// Read from the header itself, so that the two cannot differ. Struct members and the words of enums
// become camelCase.
import { readFileSync, writeFileSync } from 'node:fs';

const scalars = { int32_t: 4, uint32_t: 4, float: 4, double: 8, uint64_t: 8 };
// Members of type int32_t whose values are an enum's words, and its first constant; all others are
// flags.
const enumOf = {
  sides: 'SIDES_AUTOMATIC',
  kind: 'POINT',
  reason: 'NON_FINITE',
  kernel: 'KERNEL_FAST',
  form: 'FORM_PIECES',
  order: 'ORDER_SOLID_ANGLE',
  facing: 'FACING_REFUSED',
  show: 'SHOW_ALL',
  stream: 'POSITIONS',
};

const camel = (name) => name.toLowerCase().replace(/_(.)/g, (_, letter) => letter.toUpperCase());

export function readInterface(text) {
  text = text.replace(/\/\*[\s\S]*?\*\//g, '');
  const functions = [...text.matchAll(/SHADOWCUT_API\s[^;(]*?(shadowcut_\w+)\s*\(/g)].map(
    (match) => match[1],
  );
  const constants = [...text.matchAll(/enum\s*{([^}]*)}/g)].map((match) =>
    Object.fromEntries(
      [...match[1].matchAll(/SHADOWCUT_(\w+)\s*=\s*(\d+)/g)].map((entry) => [
        entry[1],
        Number(entry[2]),
      ]),
    ),
  );
  const status = constants.find((names) => 'OK' in names);
  const enums = {};
  for (const [member, first] of Object.entries(enumOf)) {
    const names = Object.keys(constants.find((values) => first in values));
    const prefix = `${member.toUpperCase()}_`;
    enums[member] = names.map((name) =>
      camel(name.startsWith(prefix) ? name.slice(prefix.length) : name),
    );
  }
  const structs = {};
  for (const [, body, name] of text.matchAll(/typedef struct {([^}]*)}\s*shadowcut_(\w+);/g))
    structs[camel(name)] = layout(body, structs);
  return { functions, status, enums, structs };
}

// Members one after another, each aligned to its own size, as C has them.
function layout(body, structs) {
  const members = [];
  let end = 0,
    align = 1;
  for (const [, type, declarators] of body.matchAll(/(const char\*|\w+)\s+([^;]*);/g)) {
    for (const [, name, dimensions] of declarators.matchAll(/(\w+)((?:\[\d+\])*)/g)) {
      const nested = structs[camel(type.replace(/^shadowcut_/, ''))];
      const kind = nested
        ? camel(type.replace(/^shadowcut_/, ''))
        : type === 'const char*'
          ? 'text'
          : type;
      const size = nested ? nested.size : kind === 'text' ? 4 : scalars[type];
      if (!size) throw new Error(`interface.mjs does not know the type ${type}`);
      const shape = [...dimensions.matchAll(/\d+/g)].map(Number);
      const boundary = nested ? nested.align : size;
      const offset = Math.ceil(end / boundary) * boundary;
      const is = kind !== 'int32_t' ? kind : name in enumOf ? 'enum' : 'flag';
      members.push({ name: camel(name), key: name, is, offset, shape, size });
      end = offset + size * shape.reduce((a, b) => a * b, 1);
      align = Math.max(align, boundary);
    }
  }
  return { size: Math.ceil(end / align) * align, align, members };
}

if (process.argv[2]) {
  const header = readInterface(readFileSync(process.argv[2], 'utf8'));
  const lines = Object.entries(header).map(
    ([name, value]) => `export const ${name} = ${JSON.stringify(value)};\n`,
  );
  writeFileSync(process.argv[3], `// Written by interface.mjs from c.h.\n${lines.join('')}`);
}
