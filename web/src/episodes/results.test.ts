import { describe, expect, it } from 'vitest';
import { distancesFrom, lengthOf } from '../scan/distances.ts';
import { parseResults, withoutTurns } from './results.ts';
import { readScan, vectorsFolder } from '../testing/vectors.ts';

describe('results files', () => {
  const walk = (trajectory: unknown) =>
    parseResults(JSON.stringify([{ instr_id: '1_0', trajectory }])).get('1_0')!.viewpoints;

  it('have a viewpoint once where one stays, and again where one comes back', () => {
    expect(withoutTurns(['a', 'a', 'b', 'a', 'a'])).toEqual(['a', 'b', 'a']);
  });

  it('are read in every form, turns left out', () => {
    for (const trajectory of [
      [['a', 0, 0], ['a', 1, 0], ['b', 1, 0]],
      [['a'], ['b']],
      ['a', 'b'],
      [['a'], ['a', 'b']],
      [[['a', 0, 0]], [['b', 0, 0]]],
    ]) {
      expect(walk(trajectory)).toEqual(['a', 'b']);
    }
  });

  it('are refused with the place of the fault', () => {
    expect(() => walk([['a', 0, 0], 7])).toThrow('$[0].trajectory[1]');
    expect(() => walk([])).toThrow('$[0].trajectory: empty');
    expect(() => parseResults('[{}]')).toThrow('$[0].instr_id');
    expect(() => parseResults('{}')).toThrow('$: not a list');
  });
});

describe('distances', () => {
  it('are along edges', () => {
    const triangle = readScan(`${vectorsFolder}data/connectivity`, 'triangle');
    // v0 (0, 0), v1 (3, 0), v2 (3, 4): by the vectors' own description.
    expect(distancesFrom(triangle, 0).slice(0, 3)).toEqual([0, 3, 5]);
    expect(lengthOf(triangle, [0, 1, 2])).toBe(7);
    expect(lengthOf(triangle, [0])).toBe(0);
  });
});
