/** Checks the imports of web/src: between rooms they point down, and no files import each other in a circle. */
import { readdirSync, readFileSync } from 'node:fs';
import { dirname, join, normalize } from 'node:path/posix';

/** The rooms from the lowest up, each with those that it may import. Any unit test may import testing. */
export const rooms: Readonly<Record<string, readonly string[]>> = {
  geometry: [],
  scan: ['geometry'],
  server: ['scan'],
  elements: ['server'],
  viewer: ['elements', 'geometry', 'scan', 'server'],
  roam: ['elements', 'geometry', 'scan', 'viewer'],
  episodes: ['elements', 'geometry', 'scan', 'server', 'viewer'],
  replay: ['elements', 'episodes', 'geometry', 'scan', 'server', 'viewer'],
  evaluation: ['elements', 'episodes', 'geometry', 'scan', 'server', 'viewer'],
  collecting: ['elements', 'geometry', 'server'],
  work: ['collecting', 'elements', 'geometry', 'scan', 'server', 'viewer'],
  review: ['collecting', 'elements', 'scan', 'server', 'viewer', 'work'],
  pages: [
    'collecting', 'elements', 'episodes', 'evaluation', 'geometry', 'replay', 'review', 'roam', 'scan', 'server', 'viewer', 'work',
  ],
  testing: ['geometry', 'scan'],
};

/** Packages, and the rooms that may import them: pages without a viewer must not load three.js. */
const packages: Readonly<Record<string, readonly string[]>> = { three: ['viewer', 'roam'], marked: ['elements'], pako: ['elements'] };

/** Texts of files by their paths within src: "viewer/stage.ts". */
export type Sources = ReadonlyMap<string, string>;

export function readSources(folder: string): Sources {
  const names = readdirSync(folder, { recursive: true, encoding: 'utf8' }).map((name) => name.replaceAll('\\', '/'));
  return new Map(names.filter((name) => name.endsWith('.ts')).sort()
    .map((name) => [name, readFileSync(`${folder}/${name}`, 'utf8')]));
}

const statement = /^\s*(?:import|export)\s[^'";()=]*?\bfrom\s+['"]([^'"]+)|^\s*import\s+['"]([^'"]+)|\bimport\(\s*['"]([^'"]+)/gm;

/** What a file imports, types and later imports included. */
export const importsOf = (text: string): string[] =>
  [...text.matchAll(statement)].map(([, from, alone, later]) => (from ?? alone ?? later)!);

const isTest = (file: string): boolean => file.endsWith('.test.ts');

/** The room of a file; nothing for a file right in src. */
const roomOf = (file: string): string | undefined => (file.includes('/') ? file.slice(0, file.indexOf('/')) : undefined);

/** What is wrong with one import, if anything. */
function faultOf(file: string, room: string, name: string): string | undefined {
  if (!name.startsWith('.')) {
    const allowed = packages[name.split('/')[0]!];
    if (allowed ? allowed.includes(room) : isTest(file) || room === 'testing') return undefined;
    return `${file}: ${room}/ may not import the package ${name}`;
  }
  const target = normalize(join(dirname(file), name));
  const other = roomOf(target);
  const mayImport = other === room || (other === 'testing' && isTest(file)) || (other !== undefined && rooms[room]!.includes(other));
  return mayImport ? undefined : `${file}: ${room}/ may not import ${target}`;
}

/** Circles of files, each written from its first file on: "a/b.ts -> a/c.ts -> a/b.ts". */
function circlesOf(sources: Sources): string[] {
  const found: string[] = [];
  const done = new Set<string>();
  const follow = (file: string, chain: readonly string[]): void => {
    const at = chain.indexOf(file);
    if (at >= 0) found.push(`a circle: ${[...chain.slice(at), file].join(' -> ')}`);
    if (at >= 0 || done.has(file)) return;
    for (const name of importsOf(sources.get(file) ?? '')) {
      if (name.startsWith('.')) follow(normalize(join(dirname(file), name)), [...chain, file]);
    }
    done.add(file);
  };
  for (const file of sources.keys()) follow(file, []);
  return found;
}

/** All faults, each as a line. */
export function checkImports(sources: Sources): string[] {
  const found: string[] = [];
  for (const [file, text] of sources) {
    const room = roomOf(file);
    if (room === undefined || !Object.hasOwn(rooms, room)) {
      found.push(`${file}: lies in no room of the table in testing/imports.ts`);
      continue;
    }
    for (const name of importsOf(text)) {
      const fault = faultOf(file, room, name);
      if (fault) found.push(fault);
    }
  }
  return [...found, ...circlesOf(sources)];
}
