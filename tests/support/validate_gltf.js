// Prints what the Khronos validator finds in files: a JSON list, for each file a list of its errors and warnings.
// usage: node validate_gltf.js FILE...     needs the npm package gltf-validator, here, above, or in NODE_PATH
const fs = require("fs");
const path = require("path");

let validator;
try {
  validator = require("gltf-validator");
} catch {
  console.error("the npm package gltf-validator is not installed");
  process.exit(3);
}

function validate(file) {
  const beside = (uri) => fs.promises.readFile(path.resolve(path.dirname(file), decodeURIComponent(uri)));
  const options = { uri: path.basename(file), maxIssues: 0, externalResourceFunction: beside };
  return validator
    .validateBytes(new Uint8Array(fs.readFileSync(file)), options)
    .then((report) => report.issues.messages.filter((issue) => issue.severity < 2));
}

Promise.all(process.argv.slice(2).map(validate)).then((found) => console.log(JSON.stringify(found)));
