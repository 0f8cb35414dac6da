// Takes out of the decoder what only formats messages of panics, which nobody could read: a panic
// is a trap with or without them. `node shrink.mjs FROM TO BINARYEN`

import { readFileSync, writeFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [from, to, folder] = process.argv.slice(2);
const { default: binaryen } = await import(pathToFileURL(`${folder}/index.js`));
const module = binaryen.readBinary(readFileSync(from));
module.setFeatures(binaryen.Features.All);
const FORMATTING = /core3fmt|core\.\.fmt|flt2dec|panic|_fail|unwrap_failed|handle_alloc_error|capacity_overflow/;
const functions = Array.from({ length: module.getNumFunctions() }, (_, i) => (
  binaryen.getFunctionInfo(module.getFunctionByIndex(i))));
for (const { name, base, params, results } of functions) {
  if (base || !FORMATTING.test(name)) continue;
  module.removeFunction(name);
  module.addFunction(name, params, results, [], module.unreachable());
}
writeFileSync(to, module.emitBinary());
