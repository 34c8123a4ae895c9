// Runs every test of the page: tests/clients/web/page/*_test.js, which mirror src. Node 18 finds no files by pattern by itself.
import { spawnSync } from 'node:child_process';
import { readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const folder = join(dirname(fileURLToPath(import.meta.url)), '../../../tests/clients/web/page');
const files = readdirSync(folder).filter((name) => name.endsWith('_test.js')).map((name) => join(folder, name));
process.exit(spawnSync(process.execPath, ['--test', ...files], { stdio: 'inherit' }).status ?? 1);
