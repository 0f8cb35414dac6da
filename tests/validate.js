// Validates the GLB files of a list: node validate.js VALIDATOR LIST.json.
// Prints {file: [error codes]}.
const fs = require("fs");
const [validatorPath, list] = process.argv.slice(2);
const validator = require(validatorPath);

(async () => {
  const result = {};
  for (const name of JSON.parse(fs.readFileSync(list, "utf8"))) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(name)), {
      uri: name,
      maxIssues: 0,
      externalResourceFunction: () => Promise.reject(new Error("left out")),
    });
    const errors = report.issues.messages.filter((m) => m.severity === 0);
    result[name] = [...new Set(errors.map((m) => m.code))].sort();
  }
  console.log(JSON.stringify(result));
})().catch((error) => {
  console.error(error);
  process.exit(1);
});
