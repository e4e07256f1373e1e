import { describe, expect, it } from 'vitest';
import { EvenWalk, lengthOf, TraceWalk, wordAt } from './spoken_instruction.ts';
import type { Scan } from '../scan/scan.ts';

const words = [{ word: 'Turn', start: 0.5, end: 1 }, { word: 'left', start: 1.5, end: 2 }, { word: '.' }, { word: 'Stop', start: 4, end: 5 }];

/** 4 m to the north, then 1 m to the east. */
const scan: Scan = {
  scan: 'small', synthetic: true, storeys: [],
  viewpoints: ([[0, 0, 1], [0, 4, 1], [1, 4, 1]] as const).map((position, k) => ({
    id: String(k), included: true, position, height: 1.5, neighbours: [k - 1, k + 1].filter((v) => v >= 0 && v < 3), layers: [],
  })),
};

describe('a recital', () => {
  it('says its words in time', () => {
    expect([0, 0.5, 1.2, 1.6, 3, 9].map((t) => wordAt(words, t))).toEqual([-1, 0, 0, 1, 1, 3]);
    expect(lengthOf(words)).toBe(5);
    expect(lengthOf([{ word: 'Go' }])).toBe(0);
  });

  it('walks evenly from start to goal', () => {
    const walk = new EvenWalk(scan, [0, 1, 2], 10, 3);
    expect(walk.at(0)).toEqual({ from: 0, to: 1, share: 0, heading: 0, elevation: 0 });
    expect(walk.at(4)).toMatchObject({ from: 0, to: 1, share: 0.5 });
    expect(walk.at(9)).toMatchObject({ from: 1, to: 2, share: 0.5 });
    expect(walk.at(9).heading).toBeCloseTo(Math.PI / 2);
    expect(walk.at(8.1).heading, 'it turns first').toBeLessThan(Math.PI / 2);
    expect(walk.at(99)).toMatchObject({ from: 2, to: 2, share: 0 });
  });

  it('stays where a path has no step', () => {
    expect(new EvenWalk(scan, [1], 10, 3).at(5)).toEqual({ from: 1, to: 1, share: 0, heading: 3, elevation: 0 });
  });

  it('looks as a trace says', () => {
    const trace = { times: [0, 1, 3, 4], viewpoints: ['0', '0', '1', '1'], headings: [6.2, 0.2, 1, 2], elevations: [0, -0.2, 0, 0] };
    const walk = new TraceWalk(scan, trace, 6);
    expect(walk.seconds).toBe(6);
    expect(walk.at(0)).toEqual({ from: 0, to: 0, share: 0, heading: 6.2, elevation: 0 });
    expect(walk.at(0.5).heading, 'the shorter way, across north').toBeCloseTo((6.2 + (2 * Math.PI + 0.2)) / 2 - 2 * Math.PI);
    expect(walk.at(0.5).elevation).toBeCloseTo(-0.1);
    expect(walk.at(2), 'it stands until shortly before the step').toMatchObject({ from: 0, to: 0, heading: 0.2 });
    expect(walk.at(2.75)).toMatchObject({ from: 0, to: 1, share: 0.5 });
    expect(walk.at(3.5)).toMatchObject({ from: 1, to: 1, heading: 1.5 });
    expect(walk.at(9)).toMatchObject({ from: 1, to: 1, heading: 2 });
    expect(() => new TraceWalk(scan, { ...trace, viewpoints: ['0', 'x', '1', '1'] })).toThrow('another building');
  });
});
