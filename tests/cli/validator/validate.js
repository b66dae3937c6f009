// Prints what Khronos's validator finds in a glTF file: nothing, or its messages, one a line.
const fs = require('fs');
const validator = require('gltf-validator');

validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2]))).then((report) => {
  for (const message of report.issues.messages) {
    console.log(`${message.severity} ${message.code} ${message.pointer}: ${message.message}`);
  }
});
