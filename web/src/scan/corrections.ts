/** People's corrections to a graph: the file that `enfilade homes --corrections` takes (docs/graph.md). */
import type { Scan } from './scan.ts';

export type Action = 'add-edge' | 'remove-edge' | 'exclude' | 'include';

export interface Correction {
  readonly action: Action;
  readonly from: string;
  /** Of edges only. */
  readonly to?: string;
  readonly who: string;
  readonly why: string;
  /** ISO 8601. */
  readonly when: string;
}

/** The graph with them applied in their order; both directions of an edge change. */
export function applyCorrections(scan: Scan, list: readonly Correction[]): Scan {
  const index = new Map(scan.viewpoints.map(({ id }, k) => [id, k]));
  const neighbours = scan.viewpoints.map((v) => new Set(v.neighbours));
  const included = scan.viewpoints.map((v) => v.included);
  for (const { action, from, to } of list) {
    const a = index.get(from);
    const b = index.get(to ?? from);
    if (a === undefined || b === undefined) throw new Error(`${scan.scan} has no viewpoint ${from} or ${to}`);
    if (action === 'add-edge') [neighbours[a]!.add(b), neighbours[b]!.add(a)];
    if (action === 'remove-edge') [neighbours[a]!.delete(b), neighbours[b]!.delete(a)];
    if (action === 'exclude') included[a] = false;
    if (action === 'include') included[a] = true;
  }
  return {
    ...scan,
    viewpoints: scan.viewpoints.map((v, k) => ({
      ...v,
      included: included[k]!,
      neighbours: included[k] ? [...neighbours[k]!].filter((n) => included[n]) : [],
    })),
  };
}

/** The file's content. */
export const correctionsFile = (scan: string, list: readonly Correction[]): string =>
  `${JSON.stringify({ scan, corrections: list }, null, 1)}\n`;

// Kept in this browser until they are written to a file: a reload loses nothing.
const keyOf = (scan: string) => `enfilade-corrections/${scan}`;

export function keptCorrections(scan: string): Correction[] {
  const text = localStorage.getItem(keyOf(scan));
  return text ? (JSON.parse(text) as Correction[]) : [];
}

export function keepCorrections(scan: string, list: readonly Correction[]): void {
  if (list.length > 0) localStorage.setItem(keyOf(scan), JSON.stringify(list));
  else localStorage.removeItem(keyOf(scan));
}
