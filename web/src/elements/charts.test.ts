import { describe, expect, it } from 'vitest';
import { bestSoFar, placeOn, scaleOf, ticksOf } from './charts.ts';

describe('an interval', () => {
  it('stands on a scale that all rows share', () => {
    const scale = scaleOf([{ low: 2, mean: 3, high: 4 }, { low: 6, mean: 8, high: 12 }]);
    expect(scale).toEqual([2, 12]);
    expect(placeOn(2, scale)).toBe(0);
    expect(placeOn(7, scale)).toBe(50);
    expect(placeOn(12, scale)).toBe(100);
    expect(placeOn(99, scale)).toBe(100);
  });

  it('has its place where all values are equal', () => {
    expect(placeOn(5, [5, 5])).toBe(50);
  });
});

describe('progress', () => {
  const point = (time: number, value: number) => ({ team: 'a', time, value, name: 'm' });

  it('never falls, whatever the order', () => {
    const steps = bestSoFar([point(3, 0.2), point(1, 0.1), point(2, 0.3)]);
    expect(steps.map(({ best }) => best)).toEqual([0.1, 0.3, 0.3]);
    expect(steps.map(({ better }) => better)).toEqual([true, true, false]);
  });

  it.each([[0, 1], [41.2, 47.9], [9.4, 58.3], [3, 3], [0.001, 0.0013], [-2, 7]])('has a few round lines from %d to %d', (least, most) => {
    const ticks = ticksOf(least, most);
    expect(ticks[0]).toBeLessThanOrEqual(least + 1e-9);
    expect(ticks.at(-1)).toBeGreaterThanOrEqual(most - 1e-9);
    expect(ticks.length).toBeLessThanOrEqual(8);
    expect(new Set(ticks).size).toBe(ticks.length);
  });
});
