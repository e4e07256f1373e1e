import { describe, expect, it } from 'vitest';
import { degrees } from '../geometry/geometry.ts';
import { pathOf, rimInView } from './outline_layer.ts';

const camera = { width: 640, height: 480, vfov: degrees(60) };

describe('outlines', () => {
  it('are where their directions are in the picture', () => {
    const [middle, right, behind] = rimInView([1, 0, 1 + degrees(30), 0, 1 + Math.PI, 0], camera, { heading: 1, elevation: 0 });
    expect(middle![0]).toBeCloseTo(320);
    expect(middle![1]).toBeCloseTo(240);
    expect(right![0]).toBeCloseTo(560); // 240 / tan 30 * tan 30 from the middle
    expect(behind).toBeUndefined();
  });

  it('are closed lines with gaps where they leave the view', () => {
    expect(pathOf([[0, 0], [1, 0], [1, 2]])).toBe('M0.0 0.0L1.0 0.0L1.0 2.0L0.0 0.0');
    expect(pathOf([[0, 0], undefined, [1, 2]])).toBe('M0.0 0.0M1.0 2.0L0.0 0.0');
  });
});
