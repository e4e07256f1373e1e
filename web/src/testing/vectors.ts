/** The data of tests/vectors, read as the C++ does. */
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import type { Scan, Viewpoint } from '../scan/scan.ts';
import type { Vec3 } from '../geometry/geometry.ts';

interface Entry {
  readonly image_id: string;
  readonly pose: readonly number[];
  readonly included: boolean;
  readonly height?: number;
  readonly unobstructed: readonly boolean[];
}

export const vectorsFolder = fileURLToPath(new URL('../../../tests/vectors/', import.meta.url));

export const readJson = <T>(file: string): T => JSON.parse(readFileSync(file, 'utf8')) as T;

/** A connectivity file as the server would send it. */
export function readScan(connectivity: string, scan: string): Scan {
  const entries = readJson<Entry[]>(`${connectivity}/${scan}_connectivity.json`);
  const viewpoints = entries.map((entry, row): Viewpoint => ({
    id: entry.image_id,
    included: entry.included,
    position: [entry.pose[3], entry.pose[7], entry.pose[11]].map((x) => Math.fround(x!)) as unknown as Vec3,
    height: entry.height ?? 0,
    neighbours: entry.included
      ? entry.unobstructed.flatMap((open, k) => (open && entries[k]!.included && k !== row ? [k] : []))
      : [],
    layers: [],
  }));
  return { scan, synthetic: false, storeys: [], viewpoints };
}
