import { describe, expect, it } from 'vitest';
import type { PlanStorey, Room } from '../scan/scan.ts';
import { things, wallsOf } from './house_shape.ts';
import { roundLength } from './plan_shapes.ts';

const room: Room = { name: 'kitchen', storey: 0, floor: 0, outline: [0, 0, 4, 0, 4, 3, 0, 3], viewpoints: [] };
/** Walls all around except for x from 1 to 2 in the south; a window in the north from 1 to 3. */
const storey: PlanStorey = {
  floor: 0, doors: [], stairs: [], furniture: [],
  walls: [0, 0, 1, 0, 2, 0, 4, 0, 4, 0, 4, 3, 4, 3, 3, 3, 1, 3, 0, 3, 0, 3, 0, 0],
  windows: [1, 3.2, 3, 3.2],
};
const area = (parts: ReturnType<typeof wallsOf>) =>
  parts.reduce((sum, { a, b, low, high }) => sum + Math.hypot(b[0] - a[0], b[1] - a[1]) * (high - low), 0);

describe('the walls of a room', () => {
  const parts = wallsOf(room, storey, 2.5);

  it('leave doors open up to 2.1 m', () => {
    const south = parts.filter(({ a, b }) => a[1] === 0 && b[1] === 0);
    expect(south.filter(({ low }) => low === 0).map(({ a, b }) => [a[0], b[0]])).toEqual([[0, 1], [2, 4]]);
    expect(south.filter(({ low }) => low > 0)).toEqual([{ a: [1, 0], b: [2, 0], low: 2.1, high: 2.5, glass: false }]);
  });

  it('have glass where a window is, and a wall below and above it', () => {
    const glass = parts.filter((part) => part.glass);
    expect(glass).toHaveLength(1);
    expect(glass[0]).toMatchObject({ low: 0.9, high: 2.1 });
    expect(Math.abs(glass[0]!.a[0] - glass[0]!.b[0])).toBeCloseTo(2);
    expect(parts.filter(({ a, b, low }) => a[1] === 3 && b[1] === 3 && low === 0)).toHaveLength(3);
  });

  it('cover all that is no opening, once', () => {
    expect(area(parts)).toBeCloseTo(14 * 2.5 - 1 * 2.1); // 14 m around, a door of 1 m
  });

  it('stand around the whole room where a plan says nothing of doors', () => {
    const closed = { ...storey, walls: [0, 0, 4, 0, 4, 0, 4, 3, 4, 3, 0, 3, 0, 3, 0, 0], windows: [] };
    expect(area(wallsOf(room, closed, 2))).toBeCloseTo(28);
    // A door's box beside the wall opens it.
    expect(area(wallsOf(room, { ...closed, doors: [1, 0.05, 2, 0.05, 1, -0.05, 2, -0.05] }, 2.5))).toBeCloseTo(35 - 2.1);
  });
});

describe('things', () => {
  it('are the hulls of lines that hang together', () => {
    const square = [0, 0, 1, 0, 1, 0, 1, 1, 1, 1, 0, 1, 0, 1, 0, 0];
    const other = square.map((value) => value + 5);
    const found = things([...other, ...square]);
    expect(found).toHaveLength(2);
    expect(found.map((ring) => ring.length)).toEqual([4, 4]);
  });

  it('leave out what has no area', () => {
    expect(things([0, 0, 1, 0, 1, 0, 2, 0])).toEqual([]);
  });
});

describe('the length of a scale bar', () => {
  it.each([[3.3, 2], [2, 2], [1.9, 1], [12, 10], [5.5, 5], [0.7, 0.5]])('below %d m is %d m', (most, length) => {
    expect(roundLength(most)).toBeCloseTo(length);
  });
});
