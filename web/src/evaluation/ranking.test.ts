import { describe, expect, it } from 'vitest';
import {
  bestText, type Column, firstDirection, format, intervalOf, places, type Published, rangeText, type Row, sorted, unitOf, valueOf,
} from './ranking.ts';

const columns: readonly Column[] = [
  { name: 'spl', short: 'SPL', title: 'Success weighted by path length', unit: 'share', better: 'higher' },
  { name: 'nav_error', short: 'NE', title: 'Navigation error', unit: 'm', better: 'lower' },
  { name: 'gp', short: 'GP', title: 'Goal progress', unit: 'm', better: 'higher' },
  { name: 'trajectory_length', short: 'TL', title: 'Trajectory length', unit: 'm' },
];
const column = (name: string) => columns.find((one) => one.name === name)!;
const row = (id: number, spl: number | null, error: number | null = 3): Row =>
  ({ id, team: `team ${id}`, method: 'm', created: '2027-01-01T00:00:00Z', means: { spl: { mean: spl }, nav_error: { mean: error } } });
const ids = (rows: readonly Row[]) => rows.map(({ id }) => id);

describe('a leaderboard', () => {
  it('gives equal scores one place', () => {
    expect(places([row(1, 0.5), row(2, 0.4), row(3, 0.4), row(4, 0.1)], column('spl'))).toEqual([1, 2, 2, 4]);
  });

  it('puts what has no score last', () => {
    expect(places([row(1, null), row(2, 0.4)], column('spl'))).toEqual([2, 1]);
    const rows = [row(1, null), row(2, 0.4), row(3, 0.6)];
    expect(ids(sorted(rows, column('spl'), 'descending'))).toEqual([3, 2, 1]);
    expect(ids(sorted(rows, column('spl'), 'ascending'))).toEqual([2, 3, 1]);
  });

  it('sorts with the best on top at first', () => {
    expect(firstDirection(column('spl'))).toBe('descending');
    expect(firstDirection(column('nav_error'))).toBe('ascending');
  });

  it('shows shares as per cent and lengths as metres', () => {
    expect(valueOf(row(1, 0.4567), column('spl'))).toBeCloseTo(45.67);
    expect(format(valueOf(row(1, 0.4567), column('spl')), column('spl'))).toBe('45.7');
    expect(format(valueOf(row(1, 1, 3.14159), column('nav_error')), column('nav_error'))).toBe('3.14');
    expect(format(undefined, column('spl'))).toBe('–');
  });

  it('ranks by metres of progress, which may be less than none', () => {
    const progress = (id: number, mean: number): Row => ({ ...row(id, 0), means: { gp: { mean } } });
    const rows = [progress(1, -1.25), progress(2, 3.5), progress(3, 0)];
    expect(places(rows, column('gp'))).toEqual([3, 1, 2]);
    expect(ids(sorted(rows, column('gp'), firstDirection(column('gp'))))).toEqual([2, 3, 1]);
    expect(format(valueOf(rows[0]!, column('gp')), column('gp'))).toBe('-1.25');
    expect([unitOf(column('gp')), unitOf(column('spl'))]).toEqual(['m', '%']);
  });

  it('writes intervals as they are read, and none without a length', () => {
    const between = (low: number | null, high: number | null) => ({ means: { spl: { mean: 0.97, low, high } } });
    expect(rangeText(between(0.951, 0.9932), column('spl'))).toBe('95.1–99.3');
    expect(intervalOf(between(0.951, 0.9932), column('spl'))!.low).toBeCloseTo(95.1);
    expect(rangeText(between(0.97, 0.97), column('spl'))).toBe('');
    expect(rangeText(between(0.97001, 0.97002), column('spl'))).toBe(''); // both look like 97.0
    expect(rangeText(between(null, 1), column('spl'))).toBe('');
    expect(rangeText(row(1, 0.97), column('spl'))).toBe('');
  });

  it('sorts what others have published among its rows, and what they have no figure of below', () => {
    const human: Published = { agent: 'Human', source: 'a paper', means: { nav_error: { mean: 1.61 } } };
    const all = sorted<Row | Published>([row(1, 0.5, 3), row(2, 0.4, 1), human], column('nav_error'), 'ascending');
    expect(all.map((one) => ('id' in one ? one.id : one.agent))).toEqual([2, 'Human', 1]);
    expect(sorted<Row | Published>([human, row(1, 0.5)], column('spl'), 'ascending')[1]).toBe(human);
  });

  it('marks the best as it is shown, and nothing where there is nothing to compare', () => {
    const rows = [row(1, 0.45671, 5), row(2, 0.45669, 4)];
    expect(bestText(rows, column('spl'))).toBe('45.7'); // of both rows: they look equal
    expect(bestText(rows, column('nav_error'))).toBe('4.00');
    expect(bestText(rows, column('trajectory_length'))).toBeUndefined(); // neither long nor short is better
    expect(bestText([row(1, 0.5)], column('spl'))).toBeUndefined();
  });
});
