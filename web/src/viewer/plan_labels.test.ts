import { describe, expect, it } from 'vitest';
import { placeLabel } from './plan_labels.ts';

/** 4 x 3 m, y up: on the plan y is from -3 to 0. */
const room = [0, 0, 4, 0, 4, 3, 0, 3];
const size = 0.3;

describe("a room's name", () => {
  it('stands in the middle of its room, a word a line', () => {
    expect(placeLabel('living room', room, size, [])).toEqual({ lines: ['living', 'room'], x: 2, y: -1.5 });
  });

  it('leaves a viewpoint in the middle free', () => {
    const disc = { x: 2, y: -1.5, radius: 0.25 };
    const { lines, x, y } = placeLabel('kitchen', room, size, [disc])!;
    const half = [(0.56 * size * 7) / 2, (size * lines.length) / 2] as const;
    expect(Math.abs(x - disc.x) >= half[0] + disc.radius || Math.abs(y - disc.y) >= half[1] + disc.radius).toBe(true);
    expect(x - half[0]).toBeGreaterThanOrEqual(0);
    expect(x + half[0]).toBeLessThanOrEqual(4);
    expect(y - half[1]).toBeGreaterThanOrEqual(-3);
    expect(y + half[1]).toBeLessThanOrEqual(0);
  });

  it('hides as little as may be where the room is full of them', () => {
    const discs = Array.from({ length: 12 }, (_, k) => ({ x: 0.5 + (k % 4), y: -0.5 - Math.floor(k / 4), radius: 0.25 }));
    const label = placeLabel('hall', room, size, discs)!;
    const away = (one: number, other: number, half: number) => Math.max(Math.abs(one - other) - half, 0);
    const touched = discs.filter(({ x, y, radius }) => Math.hypot(away(x, label.x, 0.56 * size * 2), away(y, label.y, size / 2)) < radius);
    expect(touched).toEqual([]);
  });

  it('stays within a room with a corner cut out', () => {
    const shaped = [0, 0, 4, 0, 4, 1, 1.5, 1, 1.5, 4, 0, 4]; // its box has its middle outside
    const { x, y } = placeLabel('hall', shaped, size, [])!;
    expect(x < 1.5 || y > -1).toBe(true);
  });

  it('is left out where it does not fit', () => {
    expect(placeLabel('bathroom', [0, 0, 1, 0, 1, 1, 0, 1], size, [])).toBeUndefined();
  });
});
