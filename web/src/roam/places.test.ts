import { describe, expect, it } from 'vitest';
import type { Scan } from '../scan/scan.ts';
import { formatPoint, nearestViewpoint, parsePoint } from './places.ts';
import { ceilingOf, storeyAt } from './storeys.ts';

describe('places', () => {
  it('are parts of addresses, to a centimetre', () => {
    expect(formatPoint([1.234, -3.4, 0])).toBe('@1.23,-3.4,0');
    expect(parsePoint('@1.23,-3.4,0')).toEqual([1.23, -3.4, 0]);
    for (const text of [undefined, '', 'v12', '@1,2', '@1,2,x', '@1,2,3,4']) expect(parsePoint(text), text).toBeUndefined();
  });

  it('have a nearest viewpoint with pictures, of the same storey', () => {
    const rotation = [1, 0, 0, 0, 1, 0, 0, 0, 1] as const;
    const viewpoint = (id: string, position: readonly [number, number, number], pictured = true) =>
      ({ id, included: true, position, height: 1.5, neighbours: [], layers: [], ...(pictured && { rotation }) });
    const scan: Scan = {
      scan: 's', synthetic: true, storeys: [],
      viewpoints: [viewpoint('above', [0, 0, 4.2]), viewpoint('bare', [0, 0.1, 1.5], false), viewpoint('here', [2, 0, 1.5])],
    };
    expect(nearestViewpoint(scan, [0, 0, 0])).toBe(2);
    expect(nearestViewpoint(scan, [0, 0, 2.7])).toBe(0);
    expect(nearestViewpoint({ ...scan, viewpoints: [] }, [0, 0, 0])).toBeUndefined();
  });

  it('are in storeys, stairs in the lower one until one is nearly up', () => {
    const floors = [0, 2.8];
    expect([-0.3, 0, 1.9, 2.1, 2.8, 6].map((z) => storeyAt(floors, z))).toEqual([0, 0, 0, 1, 1, 1]);
    expect(storeyAt([], 3)).toBe(0);
    expect(ceilingOf(floors, 1)).toBeCloseTo(4.7);
  });
});
