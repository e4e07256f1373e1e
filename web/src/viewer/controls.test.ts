import { describe, expect, it } from 'vitest';
import { degrees } from '../geometry/geometry.ts';
import { bearing, standing } from './controls.ts';

describe('bearing', () => {
  it.each([
    [0, 'ahead'],
    [2, 'ahead'],
    [47, '45° to the right'],
    [-90, '90° to the left'],
    [180, 'behind'],
    [-178, 'behind'],
    [350, '10° to the left'],
  ])('of %d degrees', (angle, words) => {
    expect(bearing(degrees(angle))).toBe(words);
  });
});

describe('what is said at a viewpoint', () => {
  it.each([
    [3, 'kitchen', 2, 'Viewpoint 3, kitchen. 2 places to go to.'],
    [0, undefined, 1, 'Viewpoint 0. 1 place to go to.'],
    [4, undefined, 0, 'Viewpoint 4.'],
  ] as const)('%i, %s, %i', (viewpoint, room, places, words) => {
    expect(standing(viewpoint, room, places)).toBe(words);
  });
});
