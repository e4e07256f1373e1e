// Makes a C++ source out of the built web client: node embed.mjs DIST OUTPUT.cpp
// Each file is kept compressed; the server unpacks it for the few who can't.
import { createHash } from 'node:crypto';
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { extname, join, posix, relative, sep } from 'node:path';
import { gzipSync } from 'node:zlib';

const types = {
  '.css': 'text/css; charset=utf-8',
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.json': 'application/json',
  '.png': 'image/png',
  '.svg': 'image/svg+xml',
  '.txt': 'text/plain; charset=utf-8',
};

// What one page may weigh at the first visit, and all files together, compressed: people on phones wait for the one,
// and packages carry the other.
const mostAtFirst = 320_000;
const mostBytes = 360_000;

const [dist, output] = process.argv.slice(2);
const names = readdirSync(dist, { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile())
  .map((entry) => relative(dist, join(entry.parentPath, entry.name)).split(sep).join('/'))
  .sort((a, b) => (a < b ? -1 : 1)); // by code units, as std::string_view compares

const arrays = [];
const rows = [];
const sizes = new Map();
let bytes = 0;
names.forEach((name, k) => {
  const type = types[extname(name)];
  if (!type) throw new Error(`embed.mjs: ${name}: no media type is known for this suffix`);
  const content = readFileSync(join(dist, name));
  const packed = gzipSync(content, { level: 9 });
  bytes += packed.length;
  sizes.set(`/${name}`, packed.length);
  const digest = createHash('sha256').update(content).digest('hex').slice(0, 16);
  arrays.push(`constexpr unsigned char kFile${k}[] = {${[...packed].join(',')}};`);
  rows.push(`    {"/${name}", "${type}", "${digest}", view(kFile${k})},`);
});

if (bytes > mostBytes) throw new Error(`embed.mjs: the web client has ${bytes} bytes compressed, ${mostBytes} at most`);
const kB = (n) => Math.round(n / 1000);
console.log(`The web client: ${names.length} files, ${kB(bytes)} kB compressed`);

/** The files that a file needs before anything is shown: those that it names, and what they import at once. */
function firstLoad(path, known = new Set()) {
  if (known.has(path) || !sizes.has(path)) return known;
  known.add(path);
  const text = readFileSync(join(dist, path), 'utf8');
  const named = path.endsWith('.html') ? [...text.matchAll(/(?:src|href)="([^"]+\.(?:js|css|svg))"/g)].map(([, file]) => file)
    : path.endsWith('.js') ? [...text.matchAll(/(?:from|import)\s*"(\.{1,2}\/[^"]+)"/g)].map(([, file]) => posix.join(posix.dirname(path), file)) : [];
  for (const file of named) firstLoad(file, known);
  return known;
}
const loads = names.filter((name) => name.endsWith('.html')).map((name) => {
  const files = [...firstLoad(`/${name}`)];
  return [name.slice(0, -'.html'.length), files.reduce((sum, file) => sum + sizes.get(file), 0)];
});
for (const [name, size] of loads) {
  if (size > mostAtFirst) throw new Error(`embed.mjs: ${name} needs ${size} bytes compressed at first, ${mostAtFirst} at most`);
}
console.log(`At the first visit: ${loads.map(([name, size]) => `${name} ${kB(size)}`).join(', ')} kB`);

writeFileSync(
  output,
  `// Made by web/embed.mjs.
#include <array>

#include "enfilade/service/http/web_files.h"

namespace enfilade::service::http {
namespace {

template <std::size_t N>
std::string_view view(const unsigned char (&bytes)[N]) {
  return {reinterpret_cast<const char*>(bytes), N};
}

${arrays.join('\n')}

}  // namespace

std::span<const WebFile> web_files() {
  static const std::array<WebFile, ${rows.length}> kFiles{{
${rows.join('\n')}
  }};
  return kFiles;
}

}  // namespace enfilade::service::http
`,
);
