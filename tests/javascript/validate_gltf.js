// Validates a glTF file with the validator of its authors (Khronos) and prints the issues as JSON.
"use strict";

const { readFile } = require("node:fs/promises");
const { validateBytes } = require("gltf-validator");

async function main(path) {
  const { issues } = await validateBytes(new Uint8Array(await readFile(path)));
  console.log(JSON.stringify(issues));
}

main(process.argv[2]).catch((error) => {
  console.error(error);
  process.exit(1);
});
