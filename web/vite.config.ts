import { readdirSync, readFileSync } from 'node:fs';
import { basename } from 'node:path';
import { fileURLToPath } from 'node:url';
import type { Plugin } from 'vite';
import { defineConfig } from 'vitest/config';

const here = (path: string) => fileURLToPath(new URL(path, import.meta.url));
// /styles shows the style sheet: `npx vite` has it, and builds that ask for it.
const withStyles = Boolean(process.env['ENFILADE_STYLES']);
const pages = readdirSync(here('pages')).filter((name) => name.endsWith('.html') && (withStyles || name !== 'styles.html'));

/** A file of pages/ has its title and its main element; all else is the same: src/frame.html. */
const framed: Plugin = {
  name: 'framed',
  transformIndexHtml: {
    order: 'pre',
    handler(page, { filename, server }) {
      const [title = '', main = ''] = page.trim().split('\n');
      const whole = readFileSync(here('src/frame.html'), 'utf8')
        .replace('<!-- title -->', title)
        .replace('<!-- main -->', main)
        .replace('NAME', basename(filename, '.html'));
      return server ? whole.replaceAll('"../src/', `"/@fs${here('src')}/`) : whole; // it lies beside the server's root
    },
  },
};

export default defineConfig({
  plugins: [framed],
  root: here('pages'),
  base: '/',
  build: {
    // The C++ build says where; by hand it is web/dist.
    outDir: process.env['ENFILADE_WEB_DIST'] ?? here('dist'),
    emptyOutDir: true,
    target: 'es2022',
    modulePreload: { polyfill: false }, // an inline script, which our content policy forbids
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 700, // kB before compression; three.js is 500 of them
    rollupOptions: {
      input: [...pages.map((name) => `pages/${name}`), 'src/viewer/enfilade-viewer.ts'].map(here),
      preserveEntrySignatures: 'exports-only',
      output: {
        // The library has one address for ever; all else changes its name with its content.
        entryFileNames: ({ name }) =>
          name === 'enfilade-viewer' ? '[name].js' : 'assets/[name]-[hash].js',
      },
    },
  },
  server: {
    fs: { allow: [here('.')] },
    proxy: { '/api': process.env['ENFILADE_SERVER'] ?? 'http://127.0.0.1:8080' },
  },
  // Unit tests; `--dir e2e` has those in the browser, which make homes and draw them without a GPU.
  test: { root: here('.'), dir: 'src', testTimeout: 600_000, hookTimeout: 600_000, fileParallelism: false },
});
