// One picture of all pages out of the tests' screenshots: node e2e/contact_sheet.mjs SCREENSHOTS OUTPUT.jpg
// (ENFILADE_SCREENSHOTS=SCREENSHOTS npm run e2e makes them.) Model homes: whatever it shows is synthetic. A page of pages/ that is not among
// them is an error.
import { existsSync, readdirSync, statSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const [folder, output] = process.argv.slice(2);
if (!folder || !output) throw new Error('contact_sheet.mjs: two arguments: the folder of screenshots, and the picture to write');

const kinds = ['desktop', 'desktop-dark', 'phone', 'phone-dark'];
const mostBytes = 1_500_000; // of the docs' largest picture

// Pages in the order of the tests' names; those in other states stand beside them.
const names = readdirSync(folder)
  .filter((name) => name.endsWith('-desktop.png'))
  .map((name) => name.slice(0, -'-desktop.png'.length))
  .filter((name) => kinds.every((kind) => existsSync(join(folder, `${name}-${kind}.png`))))
  .sort();
if (names.length === 0) throw new Error(`contact_sheet.mjs: ${folder}: no page has all of ${kinds.map((kind) => `NAME-${kind}.png`).join(', ')}`);

// A screenshot's name begins with its page: "view", "view-episode".
const pages = readdirSync(join(import.meta.dirname, '../pages')).filter((name) => name.endsWith('.html')).map((name) => name.slice(0, -'.html'.length));
const absent = pages.filter((page) => !names.some((name) => name === page || name.startsWith(`${page}-`)));
if (absent.length > 0) throw new Error(`contact_sheet.mjs: ${folder}: no screenshot of ${absent.join(', ')}`);

const picture = (name, kind) =>
  `<img class="${kind.startsWith('phone') ? 'phone' : 'desktop'}" src="${name}-${kind}.png">`;
const html = `<!doctype html><meta charset="utf-8"><style>
  body { margin: 0; padding: 16px; width: 2144px; font: 13px Arial, sans-serif; background: #d9d6cf; }
  h1 { font-size: 24px; margin: 0 0 12px; } ul { list-style: none; margin: 0; padding: 0; display: grid; grid-template-columns: repeat(6, 1fr); gap: 10px 12px; }
  li div { display: flex; gap: 4px; align-items: start; } p { margin: 0 0 4px; font-weight: 700; }
  img { display: block; object-fit: cover; object-position: top; background: #fff; }
  .desktop { width: 160px; height: 100px; } .phone { width: 93px; height: 204px; } .pair { flex-direction: column; }
</style><h1>Pages of enfilade serve, at 1440 and at 390 pixels, light and dark. Model homes: SYNTHETIC</h1>
<ul>${names.map((name) => `<li><p>${name}</p><div><div class="pair">${picture(name, 'desktop')}${picture(name, 'desktop-dark')}</div>${picture(name, 'phone')}${picture(name, 'phone-dark')}</div></li>`).join('')}</ul>`;

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox'] });
const page = await browser.newPage({ viewport: { width: 2176, height: 1000 }, deviceScaleFactor: 1 });
page.setDefaultTimeout(600_000);
// A page beside the pictures, which stays there: all of them in one message are too much for a browser.
const sheet = resolve(folder, 'index.html');
writeFileSync(sheet, html);
await page.goto(pathToFileURL(sheet).href, { waitUntil: 'load' });
for (const quality of [85, 75, 65, 55, 45]) {
  writeFileSync(output, await page.screenshot({ fullPage: true, type: 'jpeg', quality }));
  if (statSync(output).size <= mostBytes) break;
}
await browser.close();
const bytes = statSync(output).size;
if (bytes > mostBytes) throw new Error(`contact_sheet.mjs: ${output} has ${bytes} bytes, ${mostBytes} at most`);
console.log(`${output}: ${names.length} pages, ${Math.round(bytes / 1000)} kB`);
