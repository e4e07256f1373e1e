import { describe, expect, it } from 'vitest';
import { degrees } from '../geometry/geometry.ts';
import { freeLine, mayBeSeen, pathOf, rimInView } from './outline_layer.ts';

const camera = { width: 640, height: 480, vfov: degrees(60) };
const ahead = { heading: 1, elevation: 0 };

describe('outlines', () => {
  it('are where their directions are in the picture', () => {
    const [middle, right] = rimInView([1, 0, 1 + degrees(30), 0], camera, ahead);
    expect(middle![0]).toBeCloseTo(320);
    expect(middle![1]).toBeCloseTo(240);
    expect(right![0]).toBeCloseTo(560); // 240 / tan 30 * tan 30 from the middle
  });

  it('are closed lines', () => {
    expect(pathOf([[0, 0], [1, 0], [1, 2]])).toBe('M0.0 0.0L1.0 0.0L1.0 2.0Z');
    expect(pathOf([])).toBe('');
  });

  it('of something beside the camera are cut off outside the widest view, and keep the lines that are in it', () => {
    const wide = { width: 1600, height: 800, vfov: degrees(110) };
    // From 40 to 120 degrees to the right: the far side is behind.
    const [near, far] = [1 + degrees(40), 1 + degrees(120)];
    const points = rimInView([near, 0.2, far, 0.2, far, -0.2, near, -0.2], wide, ahead);
    expect(points).toHaveLength(4);
    const focal = 400 / Math.tan(degrees(55));
    const inside = points.filter(([x]) => x < wide.width);
    expect(inside).toHaveLength(2);
    for (const [x] of inside) expect(x).toBeCloseTo(800 + focal * Math.tan(degrees(40)));
    for (const [x, y] of points) expect(Number.isFinite(x) && Number.isFinite(y)).toBe(true);
    expect(mayBeSeen(points, wide)).toBe(true);
    // As straight as it was: the upper side in the view is the line from the corner to the cut.
    const upper = points.filter(([, y]) => y < 400);
    expect(upper).toHaveLength(2);
  });

  it('have labels over each other where they would meet', () => {
    const first = { left: 100, right: 200, y: 240 };
    expect(freeLine(first, [])).toBe(240);
    const second = { left: 150, right: 160, y: 245 };
    expect(freeLine(second, [first])).toBe(222);
    expect(freeLine({ ...second, y: 230 }, [first, { ...second, y: 222 }])).toBe(204);
    expect(freeLine({ left: 200, right: 210, y: 245 }, [first])).toBe(245); // beside it
    expect(freeLine({ ...second, y: 260 }, [first])).toBe(260); // under it
    expect(freeLine({ ...second, y: 16 }, [{ ...first, y: 16 }])).toBe(16); // at the top there is no room
  });

  it('of something behind are none', () => {
    const rim = [1 + Math.PI, 0.1, 1 + Math.PI + 0.1, 0, 1 + Math.PI, -0.1];
    expect(rimInView(rim, camera, ahead)).toEqual([]);
    expect(mayBeSeen([], camera)).toBe(false);
  });

  it('around the whole picture are lines, though no corner is in it', () => {
    const points = rimInView([1 - 0.9, 0.9, 1 + 0.9, 0.9, 1 + 0.9, -0.9, 1 - 0.9, -0.9], camera, ahead);
    expect(points.every(([x, y]) => x < 0 || x > 640 || y < 0 || y > 480)).toBe(true);
    expect(mayBeSeen(points, camera)).toBe(true);
    expect(mayBeSeen(rimInView([2.2, 0, 2.3, 0.1, 2.3, -0.1], camera, ahead), camera)).toBe(false);
  });
});
