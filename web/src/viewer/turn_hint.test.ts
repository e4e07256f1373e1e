import { describe, expect, it } from 'vitest';
import { degrees, type Direction } from '../geometry/geometry.ts';
import { navigable } from '../scan/navigation.ts';
import type { Scan } from '../scan/scan.ts';
import { nextElsewhere } from './turn_hint.ts';

/** One viewpoint, and others around it: x and y in metres, all on one floor 1.5 m below. */
const around = (...others: readonly (readonly [number, number])[]): Scan => ({
  scan: 'star', synthetic: true, storeys: [],
  viewpoints: [[0, 0] as const, ...others].map(([x, y], k) => ({
    id: `v${k}`, included: true, position: [x, y, 1.5], height: 1.5, layers: [], neighbours: k === 0 ? others.map((_, n) => n + 1) : [0],
  })),
});
const within = degrees(40);

function looking(scan: Scan, heading: number, elevation = 0) {
  const pose = { viewpoint: 0, heading: degrees(heading), elevation: degrees(elevation), vfov: degrees(60) };
  return { scan, pose, view: { width: 640, height: 480, vfov: degrees(60) }, steps: () => navigable(scan, 0, pose, within) };
}
const sees = (scan: Scan, { heading, elevation }: Direction) =>
  nextElsewhere(looking(scan, (heading * 180) / Math.PI, (elevation * 180) / Math.PI)) === undefined;

describe('the hint', () => {
  it('is silent while a ring is in the picture', () => {
    expect(nextElsewhere(looking(around([0, 5]), 0))).toBeUndefined();
    expect(nextElsewhere(looking(around([2, 5]), 0))).toBeUndefined();
  });

  it('names the side that takes the least turn', () => {
    const scan = around([5, 0], [-5, -1]); // 90° and some 259° clockwise from +y
    expect(nextElsewhere(looking(scan, 0))?.where).toBe('to the right');
    expect(nextElsewhere(looking(scan, 320))?.where).toBe('to the left');
    expect(nextElsewhere(looking(around([0, -5]), 0))?.where).toBe('behind you');
  });

  it('says that a near ring lies below the picture', () => {
    const scan = around([0, 1.5]); // 45° down; the picture ends at 30°
    expect(nextElsewhere(looking(scan, 0))?.where).toBe('below the picture');
    expect(nextElsewhere(looking(scan, 0, -30))).toBeUndefined();
  });

  it('turns so that the ring is in the picture', () => {
    for (const scan of [around([5, 0]), around([0, -5]), around([0.9, -1.3]), around([-3, 0.2])]) {
      const next = nextElsewhere(looking(scan, 0))!;
      expect(next.look.elevation).toBeGreaterThanOrEqual(degrees(-30)); // as agents may look
      expect(sees(scan, next.look)).toBe(true);
    }
  });

  it('has nothing to say where no edge leads on', () => {
    expect(nextElsewhere(looking(around(), 0))).toBeUndefined();
  });
});
