import { describe, expect, it } from 'vitest';
import { pText, signed, verdictOf } from './comparison.ts';
import type { Column } from './ranking.ts';

const spl: Column = { name: 'spl', short: 'SPL', title: 'Success weighted by path length', unit: 'share', better: 'higher' };
const error: Column = { name: 'nav_error', short: 'NE', title: 'Navigation error', unit: 'm', better: 'lower' };
const length: Column = { name: 'trajectory_length', short: 'TL', title: 'Trajectory length', unit: 'm' };

describe('a comparison', () => {
  it('shows differences with their signs, as they are rounded', () => {
    expect(signed(0.0123, spl)).toBe('+1.2');
    expect(signed(-0.0123, spl)).toBe('−1.2');
    expect(signed(-0.0001, spl)).toBe('0.0'); // no minus before a nought
    expect(signed(-1.5, error)).toBe('−1.50');
    expect([signed(null, spl), signed(undefined, spl)]).toEqual(['–', '–']);
  });

  it('says no smaller p than the draws can tell', () => {
    expect(pText(0, 1000)).toBe('< 0.002');
    expect(pText(0.002, 1000)).toBe('0.002');
    expect(pText(1, 1000)).toBe('1.000');
    expect(pText(undefined, undefined)).toBe('–'); // secret goals
  });

  it('calls better what has less error or more success, and only where it is clear', () => {
    const of = (difference: number, p: number) => ({ first: 0, second: 0, difference, p });
    expect(verdictOf(of(0.1, 0.01), spl)).toBe('second');
    expect(verdictOf(of(-0.1, 0.01), spl)).toBe('first');
    expect(verdictOf(of(-1, 0.01), error)).toBe('second');
    expect(verdictOf(of(1, 0.01), error)).toBe('first');
    expect(verdictOf(of(0.1, 0.05), spl)).toBeUndefined();
    expect(verdictOf(of(2, 0), length)).toBeUndefined(); // neither is better
    expect(verdictOf({ first: 0, second: 1, difference: 1 }, spl)).toBeUndefined(); // secret goals
  });
});
