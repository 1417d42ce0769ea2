// What the page of a report unpacks is what Node's zlib has packed: at every level, with fixed codes, and stored.
const assert = require("assert");
const fs = require("fs");
const zlib = require("zlib");

const script = fs.readFileSync(process.argv[2], "utf8");
const part = script.slice(script.indexOf("  const codes ="), script.indexOf("  const bytes ="));
const unpacked = new Function(`${part}; return unpacked;`)();

let state = 1;
const random = () => (state = (state * 48271) % 2147483647) / 2147483647;
const kinds = [
  () => random() * 256,
  (k) => (k % 97) * 3,
  () => random() * 3,
  () => (random() < 0.9 ? 65 : random() * 256),
  () => 0,
];
let cases = 0;
for (const kind of kinds)
  for (const size of [0, 1, 258, 70000])
    for (const level of [0, 1, 6, 9])
      for (const strategy of [zlib.constants.Z_DEFAULT_STRATEGY, zlib.constants.Z_FIXED, zlib.constants.Z_HUFFMAN_ONLY]) {
        const bytes = Buffer.alloc(size);
        for (let k = 0; k < size; k++) bytes[k] = kind(k);
        const packed = zlib.deflateRawSync(bytes, { level, strategy });
        assert.strictEqual(Buffer.compare(Buffer.from(unpacked(packed, size)), bytes), 0, `${size} ${level} ${strategy}`);
        cases += 1;
      }
console.log(`${cases} cases`);
