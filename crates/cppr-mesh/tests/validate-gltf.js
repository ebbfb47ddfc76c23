// Khronos' validator on glTF files: no error, no warning, no hint.
const fs = require("fs");
const { validateBytes } = require("gltf-validator");
(async () => {
    const files = process.argv.slice(2);
    for (const file of files) {
        const { issues, info } = await validateBytes(new Uint8Array(fs.readFileSync(file)));
        if (issues.messages.length > 0 || info.totalTriangleCount === 0) {
            console.error(file, issues.messages, info.totalTriangleCount);
            process.exit(1);
        }
    }
    console.log(`${files.length} glTF files are valid`);
})();
