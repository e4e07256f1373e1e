import { describe, expect, it } from 'vitest';
import type { Scan, Viewpoint } from '../scan/scan.ts';
import { Flight } from './flight.ts';

const at = (id: string, x: number, y: number, neighbours: number[]): Viewpoint => ({
  id, included: true, position: [x, y, 1.5], height: 1.5, neighbours, layers: [],
});
/** Two metres north, then one east. */
const scan: Scan = {
  scan: 's', synthetic: true, storeys: [],
  viewpoints: [at('a', 0, 0, [1]), at('b', 0, 2, [0, 2]), at('c', 1, 2, [1])],
};

describe('a flight', () => {
  const flight = new Flight(scan, [0, 1, 2], { heading: 0, elevation: 0 });

  it('takes the time of its pauses, turns and metres', () => {
    // 0.8 s at each end, 2 m and 1 m at 1.2 m/s, one turn of 90 degrees in a second.
    expect(flight.seconds).toBeCloseTo(0.8 + 2 / 1.2 + 1 + 1 / 1.2 + 0.8, 10);
  });

  it('begins at the start as one looked, and ends at the goal', () => {
    expect(flight.at(-1)).toMatchObject({ from: 0, to: 0, heading: 0 });
    expect(flight.at(1e9)).toMatchObject({ from: 2, to: 2 });
    expect(flight.at(1e9).heading).toBeCloseTo(Math.PI / 2);
  });

  it('is half way in the middle of a leg, and turns on the spot', () => {
    const half = flight.at(0.8 + 1 / 1.2);
    expect(half).toMatchObject({ from: 0, to: 1, heading: 0 });
    expect(half.share).toBeCloseTo(0.5);
    const turning = flight.at(0.8 + 2 / 1.2 + 0.5);
    expect(turning).toMatchObject({ from: 1, to: 1, share: 0 });
    expect(turning.heading).toBeCloseTo(Math.PI / 4);
  });

  it('never jumps', () => {
    let before = flight.at(0);
    for (let t = 0; t < flight.seconds; t += 0.01) {
      const now = flight.at(t);
      const turned = Math.abs(Math.sin((now.heading - before.heading) / 2));
      expect(turned).toBeLessThan(0.05);
      before = now;
    }
  });

  it('of one viewpoint just stays', () => {
    const still = new Flight(scan, [1], { heading: 1, elevation: 0.2 });
    expect(still.at(0.5)).toEqual({ from: 1, to: 1, share: 0, heading: 1, elevation: 0.2 });
  });
});
