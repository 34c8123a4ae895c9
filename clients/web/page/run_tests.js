// Runs every test of the page and of hapticd-stream, tests/clients/web/{page,stream}/*_test.js, which mirror src, but that of the archive for npm.
// Node 18 finds no files by pattern by itself.
import { spawnSync } from 'node:child_process';
import { readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const folders = ['page', 'stream'].map((name) => join(dirname(fileURLToPath(import.meta.url)), '../../../tests/clients/web', name));
const files = folders.flatMap((folder) => readdirSync(folder).map((name) => join(folder, name)))
  .filter((path) => path.endsWith('_test.js') && !path.endsWith('package_test.js'));
process.exit(spawnSync(process.execPath, ['--test', ...files], { stdio: 'inherit' }).status ?? 1);
