import { describe, expect, it } from 'vitest';
import { degrees, type Mat3 } from '../geometry/geometry.ts';
import type { Scan } from '../scan/scan.ts';
import { arrival, faceTowards } from './trajectory.ts';

/** A panorama whose front looks along a heading: x right, y down, z forward. */
function panorama(front: number): Mat3 {
  const [s, c] = [Math.sin(front), Math.cos(front)];
  return [c, 0, s, -s, 0, c, 0, -1, 0];
}

/** Viewpoints a, b, c: b is east of a, and c is north of b. */
const scan: Scan = {
  scan: 's', synthetic: true, storeys: [],
  viewpoints: ([['a', 0, 0], ['b', 2, 0], ['c', 2, 3]] as const).map(([id, x, y]) =>
    ({ id, included: true, position: [x, y, 1] as const, height: 1, neighbours: [], layers: [] })),
};

describe('an episode of a submission', () => {
  it('is seen as one arrives at its goal', () => {
    expect(arrival(scan, ['a', 'b'])).toEqual({ at: 1, heading: Math.PI / 2 });
    expect(arrival(scan, ['a', 'b', 'c'])).toEqual({ at: 2, heading: 0 });
    expect(arrival(scan, ['c'])).toEqual({ at: 2, heading: 0 }); // no way to it
    expect(arrival(scan, ['a', 'elsewhere'])).toBeUndefined();
    expect(arrival(scan, [])).toBeUndefined();
  });

  it('is shown by the face that looks where the agent did', () => {
    for (const front of [0, 1, 4]) {
      const turned = (by: number) => faceTowards(panorama(front), front + degrees(by));
      expect([0, 44, -44].map(turned)).toEqual([3, 3, 3]); // front
      expect([90, 46, 134].map(turned)).toEqual([4, 4, 4]); // right
      expect([180, -180, 136, 224].map(turned)).toEqual([1, 1, 1, 1]); // back
      expect([270, -90].map(turned)).toEqual([2, 2]); // left
    }
  });
});
