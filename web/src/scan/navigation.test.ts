import { existsSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { halfFieldOfView, navigable } from './navigation.ts';
import type { Scan } from './scan.ts';
import { readJson, readScan, vectorsFolder } from '../testing/vectors.ts';

interface Case {
  readonly scan: string;
  readonly viewpoint: string;
  readonly heading: number;
  readonly elevation: number;
  readonly width: number;
  readonly height: number;
  readonly vfov: number;
  readonly restricted: boolean;
  readonly navigable: readonly (readonly [string, number, number, number])[];
}

/** Runs a file of vectors; that is `check_vectors` of the C++. */
function check(file: string, connectivity: string): number {
  const scans = new Map<string, Scan>();
  const { cases } = readJson<{ cases: Case[] }>(file);
  cases.forEach((one, k) => {
    let scan = scans.get(one.scan);
    if (!scan) scans.set(one.scan, (scan = readScan(connectivity, one.scan)));
    const from = scan.viewpoints.findIndex(({ id }) => id === one.viewpoint);
    const steps = navigable(scan, from, one, one.restricted ? halfFieldOfView(one) : undefined);
    expect(steps.map(({ viewpoint }) => scan.viewpoints[viewpoint]!.id), `case ${k}`).toEqual(
      one.navigable.map(([id]) => id),
    );
    steps.forEach((step, n) => {
      const [, heading, elevation, distance] = one.navigable[n]!;
      // The C++ tool's tolerance: angles of other tools have the bits of other atan2.
      expect(Math.abs(step.relHeading - heading), `case ${k}`).toBeLessThanOrEqual(1e-5);
      expect(Math.abs(step.relElevation - elevation), `case ${k}`).toBeLessThanOrEqual(1e-5);
      expect(Math.abs(step.distance - distance), `case ${k}`).toBeLessThanOrEqual(1e-5);
    });
  });
  return cases.length;
}

describe('navigable', () => {
  it('is what the shared vectors say', () => {
    expect(check(`${vectorsFolder}nav_triangle.json`, `${vectorsFolder}data/connectivity`)).toBe(5);
  });

  const data = process.env['ENFILADE_DATA'];
  const real = process.env['ENFILADE_NAV_VECTORS'];
  it.skipIf(!data || !real || !existsSync(real))(
    'is what other tools found in real buildings (needs ENFILADE_DATA and ENFILADE_NAV_VECTORS)',
    () => {
      expect(check(real!, `${data}/connectivity`)).toBeGreaterThan(0);
    },
  );

  it('breaks ties by index', () => {
    const scan: Scan = {
      scan: 's', synthetic: true, storeys: [],
      viewpoints: [
        { id: 'a', included: true, position: [0, 0, 0], height: 0, neighbours: [2, 1], layers: [] },
        { id: 'b', included: true, position: [1, 1, 0], height: 0, neighbours: [0], layers: [] },
        { id: 'c', included: true, position: [-1, 1, 0], height: 0, neighbours: [0], layers: [] },
      ],
    };
    const found = navigable(scan, 0, { heading: 0, elevation: 0 });
    expect(found.map(({ viewpoint }) => viewpoint)).toEqual([1, 2]);
    expect(found[0]!.relHeading).toBeCloseTo(Math.PI / 4, 6);
  });
});
