// Runs Khronos' glTF validator over binary glTF files.
//
//     npm install gltf-validator@2.0.0-dev.3.10 --prefix DIR
//     NODE_PATH=DIR/node_modules node scripts/check_gltf.mjs FILE...
//
// Prints one line of JSON per file: {"path", "errors", "warnings", "infos", "hints", "messages"}.
// Exit code 0: no errors and no warnings; 1: some; 2: the validator is not installed or no file was named.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

// `import` does not look at NODE_PATH, `require` does.
const require = createRequire(import.meta.url);
let validator;
try {
  validator = require("gltf-validator");
} catch {
  console.error("gltf-validator is not installed: npm install gltf-validator@2.0.0-dev.3.10 --prefix DIR, "
    + "then set NODE_PATH=DIR/node_modules");
  process.exit(2);
}

const paths = process.argv.slice(2);
if (paths.length === 0) {
  console.error("usage: node scripts/check_gltf.mjs FILE...");
  process.exit(2);
}

async function check(path) {
  try {
    const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(path)), { uri: path });
    const messages = issues.messages.map(({ code, message, pointer }) => ({ code, message, pointer }));
    const { numErrors: errors, numWarnings: warnings, numInfos: infos, numHints: hints } = issues;
    return { path, errors, warnings, infos, hints, messages };
  } catch (error) {
    const messages = [{ code: "UNREADABLE", message: String(error) }];
    return { path, errors: 1, warnings: 0, infos: 0, hints: 0, messages };
  }
}

let clean = true;
for (const path of paths) {
  const report = await check(path);
  clean &&= report.errors === 0 && report.warnings === 0;
  console.log(JSON.stringify(report));
}
process.exitCode = clean ? 0 : 1;
