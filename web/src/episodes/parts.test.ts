import { describe, expect, it } from 'vitest';
import type { Part } from './episode.ts';
import { partsAt, pieceText, placesText } from './parts.ts';

const path = [10, 11, 12, 13, 14];
const part = (...places: [number, number]): Pick<Part, 'places'> => ({ places });

describe('pieces of an instruction', () => {
  const parts = [part(0, 2), part(2, 2), part(2, 3), part(3, 4), part(3, 4)];
  const on = (from: number, to: number) => partsAt(parts, path, { from, to });

  it('are followed on their steps', () => {
    expect(on(10, 11)).toEqual([0]);
    expect(on(11, 12)).toEqual([0]);
    expect(on(12, 13)).toEqual([2]);
    expect(on(13, 14), 'both of one step').toEqual([3, 4]);
  });

  it('are followed where one stands', () => {
    expect(on(10, 10)).toEqual([0]);
    expect(on(11, 11), 'on the way').toEqual([0]);
    expect(on(12, 12), 'a turn').toEqual([1]);
    expect(on(13, 13), 'one turns to what comes').toEqual([3, 4]);
    expect(on(14, 14), 'the end').toEqual([3, 4]);
  });

  it('may leave out a step, and places', () => {
    expect(partsAt([part(0, 1), part(2, 3)], path, { from: 11, to: 12 })).toEqual([]);
    expect(partsAt([{}, part(0, 4)], path, { from: 11, to: 12 })).toEqual([1]);
    expect(partsAt([part(0, 4)], path, { from: 99, to: 99 }), 'off the path').toEqual([]);
  });

  it('are written as people write', () => {
    expect(pieceText(['turn', 'left', ',', 'then', 'right', '.'])).toBe('turn left, then right.');
    expect(pieceText(['do', "n't", 'pass', 'the', 'child', "'s", 'bed', '!'])).toBe("don't pass the child's bed!");
  });

  it('say their viewpoints, counted from 1', () => {
    expect([placesText([0, 2]), placesText([3, 3])]).toEqual(['viewpoints 1 to 3', 'viewpoint 4']);
  });
});
