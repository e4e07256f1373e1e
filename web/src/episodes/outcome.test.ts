import { describe, expect, it } from 'vitest';
import type { Scan } from '../scan/scan.ts';
import type { Goal } from './episode.ts';
import { judge, outcomeText, ruleText } from './outcome.ts';

/** Seven viewpoints in a row, 2 m apart, and one that no edge leads to. */
const scan: Scan = {
  scan: 'row', synthetic: true, storeys: [],
  viewpoints: Array.from({ length: 8 }, (_, k) => ({
    id: `v${k}`, included: true, position: [2 * k, 0, 1.5], height: 1.5, layers: [],
    neighbours: k === 7 ? [] : [k - 1, k + 1].filter((v) => v >= 0 && v < 7),
  })),
};
const path = ['v0', 'v1', 'v2', 'v3'];
const judged = (walk: readonly number[], goal?: Goal, along = path) => judge(scan, { path: along, ...(goal && { goal }) }, walk)!;

describe('an outcome', () => {
  it('is a success nearer than 3 m to the end of the path', () => {
    expect(judged([0, 1, 2])).toMatchObject({ kind: 'end', length: 4, error: 2, success: true, walk: ['v0', 'v1', 'v2'] });
    expect(judged([0, 1])).toMatchObject({ length: 2, error: 4, success: false });
    expect(judged([0])).toMatchObject({ length: 0, error: 6, success: false });
    expect(judged([7])).toMatchObject({ error: null, success: false });
  });

  it('of an object is a success where it is seen, and nowhere else', () => {
    const goal: Goal = { kind: 'object', object: 5, viewpoints: ['v2', 'v5'] };
    expect(judged([0, 1, 2], goal)).toMatchObject({ error: 0, success: true });
    expect(judged([0, 1, 2, 3, 4], goal)).toMatchObject({ error: 2, success: false });
    expect(judged([0], { kind: 'object', object: 5, viewpoints: [] })).toMatchObject({ error: null, success: false });
  });

  it('of a region is a success in it', () => {
    const goal: Goal = { kind: 'region', viewpoints: ['v4', 'v5'] };
    expect(judged([3, 4], goal)).toMatchObject({ error: 0, success: true });
    expect(judged([2, 3], goal)).toMatchObject({ error: 2, success: false });
  });

  it('of boxes is a success at one, or near the end of the path', () => {
    const goal: Goal = { kind: 'boxes', viewpoints: ['v6'] };
    expect(judged([5, 6], goal)).toMatchObject({ error: 0, success: true });
    expect(judged([0, 1, 2], goal)).toMatchObject({ error: 8, success: true });
    expect(judged([0, 1], goal)).toMatchObject({ error: 10, success: false });
    expect(judged([0, 1], { kind: 'boxes' })).toMatchObject({ error: 4 });
  });

  it('of R2R-Back is a success back at the end, after the turning point', () => {
    const goal: Goal = { kind: 'turning_point', viewpoints: ['v3'] };
    const there = ['v0', 'v1', 'v2', 'v3', 'v2', 'v1', 'v0'];
    expect(judged([0, 1, 2, 3, 2, 1, 0], goal, there)).toMatchObject({ error: 0, success: true });
    expect(judged([0, 1, 2, 1, 0], goal, there), 'it turned back before').toMatchObject({ error: 12, success: false });
    expect(judged([0], goal, there), 'the way out and back lies ahead').toMatchObject({ error: 12, success: false });
    expect(judged([0, 1, 2, 3], goal, there)).toMatchObject({ error: 6, success: false });
  });

  it('is none where the goal is hidden', () => {
    expect(judge(scan, {}, [0])).toBeUndefined();
  });

  it('is said in one sentence, with the rule', () => {
    expect(outcomeText(judged([0, 1, 2]))).toBe('You walked 4.0 m and stopped 2.0 m from the goal.');
    expect(outcomeText(judged([7]), 'It')).toBe('It walked 0.0 m and stopped where no path leads to the goal.');
    expect(ruleText(judged([0]))).toBe('Success is to stop nearer than 3 m to the goal.');
    expect(ruleText({ kind: 'region', success_distance: 3 })).toContain('region');
  });
});
