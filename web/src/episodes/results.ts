/** Results files in the browser: read as the C++ reads them, kept for the pages of this browser. */

/** A trajectory: its viewpoint ids, turns on the spot left out. */
export interface Walk {
  readonly viewpoints: readonly string[];
}
export type Results = ReadonlyMap<string, Walk>;

/**
 * The viewpoints of a trajectory in any form found in the wild: [viewpoint, heading, elevation]
 * triples, [viewpoint] singles, plain ids, or lists of those. Throws Error with the JSON path.
 */
function viewpointsOf(value: unknown, path: string): string[] {
  if (typeof value === 'string') return [value];
  if (!Array.isArray(value)) throw new Error(`${path}: neither a viewpoint nor a list of them`);
  const list: unknown[] = value;
  const isTriple = typeof list[0] === 'string' && list.slice(1).every((x) => typeof x === 'number');
  if (isTriple) return [list[0] as string];
  return list.flatMap((one, k) => viewpointsOf(one, `${path}[${k}]`));
}

/** Viewpoints in order; where one stays, that one once. */
export const withoutTurns = (ids: readonly string[]): string[] => ids.filter((id, n) => id !== ids[n - 1]);

/** Throws Error for what is no results file. Whether it fits a split is the server's to check. */
export function parseResults(text: string): Results {
  const file: unknown = JSON.parse(text);
  if (!Array.isArray(file)) throw new Error('$: not a list of {instr_id, trajectory}');
  const results = new Map<string, Walk>();
  file.forEach((entry: unknown, k) => {
    const { instr_id, trajectory } = (entry ?? {}) as { instr_id?: unknown; trajectory?: unknown };
    if (typeof instr_id !== 'string') throw new Error(`$[${k}].instr_id: not a text`);
    const all = viewpointsOf(trajectory, `$[${k}].trajectory`);
    if (all.length === 0) throw new Error(`$[${k}].trajectory: empty`);
    results.set(instr_id, { viewpoints: withoutTurns(all) });
  });
  return results;
}

const store = 'results';

function open(): Promise<IDBDatabase> {
  return new Promise((resolve, reject) => {
    const request = indexedDB.open('enfilade', 1);
    request.onupgradeneeded = () => request.result.createObjectStore(store);
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error('the browser keeps no data'));
  });
}

function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error('the browser keeps no data'));
  });
}

/** Keeps the text of a results file of a split in this browser; nothing is sent. */
export async function keepResults(split: string, text: string): Promise<void> {
  const database = await open();
  await done(database.transaction(store, 'readwrite').objectStore(store).put(text, split));
  database.close();
}

export async function forgetResults(split: string): Promise<void> {
  const database = await open();
  await done(database.transaction(store, 'readwrite').objectStore(store).delete(split));
  database.close();
}

/** Those kept last; nothing if there are none. */
export async function keptResults(split: string): Promise<Results | undefined> {
  const database = await open();
  const text: unknown = await done(database.transaction(store).objectStore(store).get(split));
  database.close();
  return typeof text === 'string' ? parseResults(text) : undefined;
}
