// Validates the glTF files of a list: node validate.js VALIDATOR LIST.json [--with-files].
// Prints {file: [error codes]}. With files, those that a glTF names are read from beside it.
const fs = require("fs");
const path = require("path");
const [validatorPath, list, withFiles] = process.argv.slice(2);
const validator = require(validatorPath);

const beside = (name) => (uri) => {
  const file = path.join(path.dirname(name), decodeURIComponent(uri));
  return fs.promises.readFile(file).then((bytes) => new Uint8Array(bytes));
};
const leftOut = () => Promise.reject(new Error("left out"));

(async () => {
  const result = {};
  for (const name of JSON.parse(fs.readFileSync(list, "utf8"))) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(name)), {
      uri: name,
      maxIssues: 0,
      externalResourceFunction: withFiles ? beside(name) : leftOut,
    });
    const errors = report.issues.messages.filter((m) => m.severity === 0);
    result[name] = [...new Set(errors.map((m) => m.code))].sort();
  }
  console.log(JSON.stringify(result));
})().catch((error) => {
  console.error(error);
  process.exit(1);
});
