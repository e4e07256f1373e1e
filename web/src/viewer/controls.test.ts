import { describe, expect, it } from 'vitest';
import { degrees } from '../geometry/geometry.ts';
import { bearing } from './controls.ts';

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
