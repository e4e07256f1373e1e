import { fileURLToPath } from 'node:url';
import { describe, expect, it } from 'vitest';
import { checkImports, importsOf, readSources, rooms } from './imports.ts';

const faults = (files: Readonly<Record<string, string>>) => checkImports(new Map(Object.entries(files)));

describe('imports of web/src', () => {
  const sources = readSources(fileURLToPath(new URL('..', import.meta.url)));

  it('point down between rooms, and form no circle', () => {
    expect(sources.size).toBeGreaterThan(80);
    expect(checkImports(sources)).toEqual([]);
  });
  it('use each arrow of the table', () => {
    const all = [...sources].map(([file, text]) => `${file.split('/')[0]} ${importsOf(text).join(' ')} `);
    const isUsed = (room: string, below: string) => all.some((line) => line.startsWith(`${room} `) && line.includes(` ../${below}/`));
    const unused = Object.entries(rooms).flatMap(([room, list]) =>
      list.filter((below) => !isUsed(room, below)).map((below) => `${room} -> ${below}`));
    expect(unused).toEqual([]);
  });
});

describe('the table of rooms', () => {
  it('lists rooms from the lowest up', () => {
    const names = Object.keys(rooms);
    for (const [k, name] of names.entries()) expect(names.slice(0, k)).toEqual(expect.arrayContaining([...rooms[name]!]));
  });
});

describe('the check of imports', () => {
  it('reads all kinds of imports', () => {
    const text = `/** In a comment: import { a } from './no.ts' */
import './side.ts';
import type { B } from './type.ts';
import {
  c,
} from "./double.ts";
import {
  d,
} from './lines.ts';
export { e } from './export.ts';
export * from './star.ts';
export const list = Array.from('abc');
const { f } = await import('./later.ts');
`;
    expect(importsOf(text)).toEqual(['./side.ts', './type.ts', './double.ts', './lines.ts', './export.ts', './star.ts', './later.ts']);
  });
  it('finds circles, also of types and later imports', () => {
    expect(faults({
      'viewer/a.ts': "import type { B } from './b.ts';",
      'viewer/b.ts': "const { c } = await import('./c.ts');",
      'viewer/c.ts': "import { a } from './a.ts';",
    })).toEqual(['a circle: viewer/a.ts -> viewer/b.ts -> viewer/c.ts -> viewer/a.ts']);
    expect(faults({ 'scan/a.ts': "import { a } from './a.ts';" })).toEqual(['a circle: scan/a.ts -> scan/a.ts']);
  });
  it('finds imports that point up', () => {
    expect(faults({ 'scan/a.ts': "import { b } from '../viewer/b.ts';", 'viewer/b.ts': '' }))
      .toEqual(['scan/a.ts: scan/ may not import viewer/b.ts']);
    expect(faults({ 'viewer/b.ts': "import { a } from '../scan/a.ts';", 'scan/a.ts': '' })).toEqual([]);
  });
  it('finds files without a room, and imports of them', () => {
    expect(faults({ 'a.ts': '', 'attic/b.ts': '' })).toHaveLength(2);
    expect(faults({ 'scan/a.ts': "import { b } from '../b.ts';" })).toEqual(['scan/a.ts: scan/ may not import b.ts']);
  });
  it('keeps packages and the tests’ helpers where they belong', () => {
    expect(faults({ 'viewer/a.ts': "import * as three from 'three';" })).toEqual([]);
    expect(faults({ 'elements/a.ts': "import * as three from 'three';" })).toHaveLength(1);
    expect(faults({ 'elements/a.ts': "import { readFileSync } from 'node:fs';" })).toHaveLength(1);
    const helped = "import { readScan } from '../testing/vectors.ts';";
    expect(faults({ 'viewer/a.test.ts': helped, 'testing/vectors.ts': '' })).toEqual([]);
    expect(faults({ 'viewer/a.ts': helped, 'testing/vectors.ts': '' })).toHaveLength(1);
  });
});
